"""Fixtures in a real browser: drawing, switches, weights, dragging; every change reaches the session."""

import time
from dataclasses import replace

import numpy as np
import pytest
from browser import on_screen, open_page
from fake_session import FakeSession
from fake_session import stage as plain_stage

from palpate.scene.guidance import Fixture
from palpate.scene.guidance.context import FixtureContext
from palpate.scene.guidance.steered import SteeredFixtures
from palpate.viewer.fixtures import in_words
from palpate.viewer.live import LiveViewer
from palpate.viewer.staging import fixture_mark

VESSEL = """
name: vessel
role: {name: forbid, margin: 0.004}
hard: true
geometry: {cylinder: {radius: 0.006, length: 0.06}}
frame: {pose: {xyz: [-0.02, -0.03, 0.07]}}
"""
WAY = """
name: way
role: guide
geometry: {line: {start: [0.03, -0.05, 0.06], end: [0.09, -0.05, 0.09]}}
"""
SECTIONS = [Fixture.from_yaml(f"- {text.strip().replace(chr(10), chr(10) + '  ')}") for text in (VESSEL, WAY)]


class Guided(FakeSession):
    def __init__(self):
        super().__init__()
        self.given = []
        self.steered = SteeredFixtures(SECTIONS, FixtureContext(), lambda sections, _: self.given.append(sections))

    def latest(self):
        tick = super().latest()
        tick["guidance_fixture"], tick["F_guidance_W"], tick["p_correction_W"] = 0.0, [0.0, 0.9, 1.2], [0.0, 0.0, 3e-4]
        return tick


@pytest.fixture(scope="module")
def shown():
    session = Guided()
    stage = replace(plain_stage(), fixtures=tuple(fixture_mark(s, FixtureContext()) for s in SECTIONS))
    viewer = LiveViewer(session, stage, port=0)
    with open_page(viewer.url) as page:
        time.sleep(1.0)
        yield session, viewer, page
    viewer.close()


def until(condition, seconds=90.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "timeout"
        time.sleep(0.1)


def test_fixtures_are_drawn_and_described(shown):
    _, viewer, page = shown
    assert [mark.forbids for mark in viewer._drawing._stage.fixtures] == [True, False]
    until(lambda: page.inner_text("#palpate-guidance") == "vessel: 1.50 N; the goal is kept 0.3 mm back")
    assert in_words(FakeSession().latest(), ()) == ""
    assert page.errors == []
    assert page.strangers == []


def test_switch_reaches_the_session(shown):
    session, _, page = shown
    page.get_by_label("vessel", exact=True).click()
    until(lambda: session.given and not session.given[-1][0].enabled)
    page.get_by_label("vessel", exact=True).click()
    until(lambda: session.given[-1][0].enabled)


def test_weight_reaches_the_session(shown):
    session, _, page = shown
    thumb = page.query_selector_all('[role="slider"]')[2]  # after the two of the tissue
    thumb.focus()
    for _ in range(4):
        page.keyboard.press("ArrowLeft")
    until(lambda: session.given[-1][0].authority == pytest.approx(0.8))


def test_dragging_a_handle_moves_a_fixture(shown):
    session, viewer, page = shown
    page.get_by_label("move it").nth(0).click()
    handle = viewer.guidance.handle["vessel"]
    until(lambda: handle.visible)
    time.sleep(1.0)
    x, y = on_screen(page, viewer._server, np.add(handle.position, [0.0, 0.0, 0.6 * 0.05]))  # on its upward arrow
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(1, 7):
        page.mouse.move(x, y - 5 * step)
        time.sleep(0.1)
    page.mouse.up()
    until(lambda: session.given[-1][0].frame.pose.xyz[2] > 0.072)
    moved = session.given[-1][0].frame.pose.xyz
    np.testing.assert_allclose(moved[:2], [-0.02, -0.03], atol=1e-3)
    assert page.errors == []
