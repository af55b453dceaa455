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
