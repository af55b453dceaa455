"""A run that is shown from its first second: loading lines, then buttons that step, record and stop."""

import threading
import time

import pytest
from browser import open_page, small_scene
from rich.console import Console

from palpate import Record, Session
from palpate.cli.terminal.view import live
from palpate.viewer import LiveViewer, stage_of
from palpate.viewer.opening import Opening


def wait(condition, seconds=90.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


def test_page_opens_before_the_scene_is_loaded_and_stop_ends_the_run(tmp_path):
    page, loaded, finished = Opening("slow", port=0), threading.Event(), []

    def begin():
        loaded.wait(60.0)
        return Session(small_scene(), out=tmp_path)

    def report(summary):
        finished.append(summary)
        return summary

    run = lambda session: session.run(3600.0, realtime=True)  # noqa: E731
    thread = threading.Thread(target=live, args=(begin, run, report, page, Console(quiet=True)), daemon=True)
    thread.start()
    with open_page(page.url, ready="#palpate-loading") as browser:
        assert "loading the scene" in browser.inner_text("#palpate-loading")
        assert browser.title() == "Palpate - slow"
        loaded.set()
        browser.wait_for_selector("#palpate-force")
        assert not browser.query_selector("#palpate-loading")
        browser.get_by_role("button", name="Stop and report").click()
        thread.join(90.0)
        assert not thread.is_alive()
        assert browser.errors == []
    assert len(finished) == 1
    assert finished[0].interrupted
    assert Record.open(finished[0].record).complete


@pytest.fixture
def running(tmp_path):
    session = Session(small_scene(), out=tmp_path)
    viewer = LiveViewer(session, stage_of(session.rig), port=0, runner=session)
    session.start()
    yield session, viewer
    session.stop()
    viewer.close()


def test_buttons_step_and_record(running):
    session, viewer = running
    with open_page(viewer.url) as page:
        page.get_by_label("pause").check()
        wait(lambda: session.controls.paused)
        time.sleep(0.2)
        before = float(session.latest()["t"])
        page.get_by_role("button", name="Step 10 ms").click()
        wait(lambda: float(session.latest()["t"]) > before)
        time.sleep(0.3)
        assert 0.009 < float(session.latest()["t"]) - before < 1.0  # the clock is that of a busy machine
        stopped = float(session.latest()["t"])
        time.sleep(0.3)
        assert float(session.latest()["t"]) == stopped
        assert session.controls.paused
        first = session.record
        page.get_by_label("record").uncheck()
        wait(lambda: not session.recording)
        page.get_by_label("record").check()
        page.get_by_label("pause").uncheck()
        wait(lambda: session.record is not None and session.record != first)
    time.sleep(0.6)
    assert session.close().record == str(session.record)
    assert Record.open(first).complete
    assert Record.open(session.record).ticks["t"][0] > Record.open(first).ticks["t"][-1]
