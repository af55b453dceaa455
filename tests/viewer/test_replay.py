"""The viewer of a record shows any chosen instant."""

import time

import numpy as np
import pytest
from fake_session import FakeSession, stage

from palpate.viewer.replay import ReplayViewer


def record_of(seconds=4.0, rate=1000):
    """A record with a force that rises by 1 N/s and a tool that moves along x at 10 mm/s."""
    ticks = np.repeat(FakeSession().latest()[None], int(seconds * rate))
    ticks["t"] = np.arange(len(ticks)) / rate
    ticks["F_H_L"] = ticks["t"][:, None] * [0.0, 0.0, 1.0]
    ticks["p_WT"] = ticks["t"][:, None] * [0.01, 0.0, 0.0]
    ticks["contacts"], ticks["cycle_us"] = 1.0, np.nan
    return ticks


@pytest.fixture
def viewer():
    viewer = ReplayViewer(record_of(), stage(), port=0)
    yield viewer
    viewer.close()


def settled(read, target, tolerance, seconds=20.0):
    end = time.monotonic() + seconds
    while abs(read() - target) > tolerance:
        assert time.monotonic() < end, f"still at {read()}, not at {target}"
        time.sleep(0.05)


def test_viewer_plays_automatically_and_repeats(viewer):
    start = viewer.time.value
    time.sleep(0.5)
    assert viewer.play.value
    assert viewer.time.value > start
    viewer.time.value = 3.95
    time.sleep(0.5)
    assert viewer.time.value < 3.0


def test_viewer_shows_the_chosen_instant(viewer):
    for t in (2.5, 0.5):  # forwards, then back
        viewer.show_at(t)
        settled(lambda: float(viewer._drawing.p_WT[0]), 0.01 * t, 1e-4)
        settled(lambda at=f">{t:.2f} N<": at in viewer._gauges._figures.content, True, 0)
        assert f">{t:.2f} s<" in viewer._gauges._figures.content
        times, forces = viewer._gauges._force_plot.data
        assert times[-1] == pytest.approx(t, abs=0.02)
        np.testing.assert_allclose(forces, times, atol=1e-9)
    assert "nan" not in viewer._gauges._figures.content  # a lockstep record has no cycle times


def test_a_replay_opens_with_the_view_of_the_running_viewer(viewer):
    from palpate.viewer import views

    position, look_at = views.overview(stage())
    np.testing.assert_allclose(viewer._server.initial_camera.position, position)
    np.testing.assert_allclose(viewer._server.initial_camera.look_at, look_at)


@pytest.mark.parametrize("count", [1, 2])
def test_a_record_of_an_instant_has_a_slider_with_a_width(count):
    shown = ReplayViewer(record_of(0.001 * count), stage(), port=0)
    try:
        assert shown.time.max - shown.time.min >= 10 * shown.time.step or count == 2
        assert shown.time.max > shown.time.min
        assert shown.time.disabled == (count == 1)
    finally:
        shown.close()


def test_the_end_of_a_run_is_called_so():
    from palpate.record.ticks import STATUS
    from palpate.viewer.played import Played
    from palpate.viewer.words import in_words

    ticks = record_of(0.1)
    bit = STATUS["not_following"][0]
    ticks["status"][20:30] |= bit  # a pause in the middle is none
    ticks["status"][90:] |= bit
    assert Played(ticks).end() == 90
    assert Played(record_of(0.1)).end() == 100
    assert in_words(ticks[25], 3.0)[0].startswith("not following")
    words = in_words(ticks[-1], 3.0, over=True)
    assert words[0] == "the run has ended"
    assert not any("not following" in word for word in words)


def test_viewer_shows_the_lag_of_each_filter():
    ticks = record_of(1.0)
    ticks["lag_ms"] = [0.0, 1.144, 0.0, 0.0]
    viewer = ReplayViewer(ticks, stage(), port=0)
    try:
        viewer.show_at(0.5)
        settled(lambda: 'id="palpate-lag">low-pass 1.1 ms<' in viewer._gauges._figures.content, True, 0)
    finally:
        viewer.close()
