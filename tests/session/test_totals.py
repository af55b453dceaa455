"""The totals of a run need bounded memory: compute times are thinned out, the longest one is kept."""

import numpy as np
import pytest

from palpate.record.ticks import TICK
from palpate.session import samples, summary


def totals(times, chunk=100):
    out = summary.Totals(1000.0)
    for begin in range(0, len(times), chunk):
        ticks = np.zeros(len(times[begin : begin + chunk]), TICK)
        ticks["cycle_us"] = times[begin : begin + chunk]
        out.add(ticks)
    assert out.ticks == len(times)
    return out


def test_memory_of_totals_is_bounded_and_percentiles_stay(monkeypatch):
    monkeypatch.setattr(samples, "MOST", 1000)
    times = np.random.default_rng(1).uniform(5.0, 15.0, 50_000)
    times[777] = 99.0
    long = totals(times)
    assert 500 <= len(long._cycle_us.values) <= 1000
    told = long.summary()
    assert told.ticks == 50_000
    assert told.cycle_max_us == 99.0
    assert told.cycle_p50_us == pytest.approx(10.0, abs=0.5)
    assert told.cycle_p99_us == pytest.approx(14.9, abs=0.2)


@pytest.mark.parametrize("chunk", [1, 7, 100, 12_500])
def test_times_are_thinned_out_evenly_whatever_the_number_of_ticks_at_once(monkeypatch, chunk):
    """A node on ROS 2 adds few ticks at a time: every 64th of all stays, not the first of each addition."""
    monkeypatch.setattr(samples, "MOST", 250)
    times = np.arange(12_500.0)
    long = totals(times, chunk)
    np.testing.assert_array_equal(long._cycle_us.values, times[::64])


def test_percentiles_of_a_short_run_are_exact():
    times = np.r_[np.arange(1.0, 101.0), np.nan]
    told = totals(times).summary()
    assert (told.cycle_p50_us, told.cycle_max_us) == (50.5, 100.0)
    assert totals(np.zeros(0)).summary().cycle_max_us == 0.0
