"""The viewer with a real session: the shipped scene in real time, and a hand dragged in the browser."""

import time

import numpy as np
import pytest
from browser import number, on_screen, open_page, small_scene

from palpate import Session
from palpate.viewer import LiveViewer, stage_of


@pytest.fixture
def running():
    session = Session(small_scene())
    controls = session.controls
    controls.hold = True  # the hand is held 20 mm above the organ
    session.controls = controls
    viewer = LiveViewer(session, stage_of(session.rig), port=0)
    viewer.control_panel.path.value = False
    session.start()
    yield session, viewer
    session.stop()
    viewer.close()


def test_dragging_the_hand_down_presses_the_organ(running):
    session, viewer = running
    with open_page(viewer.url) as page:
        time.sleep(1.0)
        assert number(page, "force") == 0.0
        x, y = on_screen(page, viewer._server, viewer.control_panel.ball.position)
        page.mouse.move(x, y)
        page.mouse.down()
        end = time.monotonic() + 120.0
        step = 0
        while number(page, "force") < 0.3:
            assert time.monotonic() < end, f"no force; the hand is at {session.controls.p_hand_offset_W}"
            step = min(step + 1, 60)
            page.mouse.move(x, y + 3 * step)
            time.sleep(0.1)
        page.mouse.up()
        assert page.errors == []
        assert page.strangers == []
    felt = session.latest()
    assert felt["contacts"] == 1.0
    assert 0.2 < np.linalg.norm(felt["F_H_L"]) <= 3.0
    assert session.controls.p_hand_offset_W[2] < -0.02
