"""The held peak, against plateaus of known height under noise."""

import numpy as np
import pytest

from palpate.base.arrays import peaks
from palpate.base.arrays.peaks import SustainedPeak, sustained, sustained_held


@pytest.mark.parametrize("seconds", [2, 60])
def test_held_peak_is_that_of_the_plateau_while_the_largest_sample_grows(seconds):
    """A force of 2 N with a plateau of 3 N for 0.2 s, and noise of 0.1 N."""
    rng, held, largest = np.random.default_rng(seconds), [], []
    for _ in range(20):
        force = np.full(1000 * seconds, 2.0)
        force[500:700] = 3.0
        force += 0.1 * rng.normal(size=len(force))
        held.append(sustained(force, 1e-3))
        largest.append(force.max())
    assert np.mean(held) == pytest.approx(3.0, rel=0.01)
    assert np.mean(largest) > 3.2


def test_held_peak_of_pieces_is_that_of_the_whole():
    rng = np.random.default_rng(1)
    force = rng.normal(size=777)
    whole = max(np.convolve(force, np.full(50, 0.02), "valid"))
    for cuts in ([], [1], [30, 49, 50, 51], [100, 100, 400]):
        peak = SustainedPeak(1e-3)
        for piece in np.split(force, cuts):
            peak.add(piece)
        assert peak.value == pytest.approx(whole)
    assert sustained(force[:9], 1e-3) == pytest.approx(force[:9].mean())


def test_held_peak_of_messages_counts_how_long_each_value_holds():
    t, force = np.array([0.0, 0.1, 0.11, 0.3, 0.35]), np.array([1.0, 6.0, 1.0, 3.0, 0.0])
    assert sustained_held(t, force, 0.6) == pytest.approx(3.0), "3 N for 50 ms; 6 N for 10 ms are 2 N over 50"
    assert sustained_held(t[:3], force[:3], 0.4) == pytest.approx(2.0)
    assert sustained_held(t, force, 0.35) == pytest.approx(3.0)
    assert sustained_held(t[:1], force[:1], 1.0) == pytest.approx(1.0)
    assert sustained_held(np.zeros(0), np.zeros(0), 1.0) == 0.0


def test_held_peak_of_regular_messages_is_that_of_samples():
    rng = np.random.default_rng(2)
    force = rng.normal(size=500)
    t = 1e-3 * np.arange(500)
    assert sustained_held(t, force, 0.5) == pytest.approx(sustained(force, 1e-3))


def test_a_peak_of_values_that_hold_is_that_of_the_whole_signal_whatever_the_pieces(monkeypatch):
    monkeypatch.setattr(peaks, "_PIECE", 37)
    rng = np.random.default_rng(3)
    t = np.cumsum(rng.uniform(0.0002, 0.004, 2000))
    x = np.abs(rng.normal(size=2000)) + np.exp(-(((t - 2.0) / 0.1) ** 2))
    peak = peaks.HeldPeak()
    assert peak.values() == (0.0, 0.0)
    for now, value in zip(t, x, strict=True):
        peak.add(now, value)
    assert peak.values() == (x.max(), pytest.approx(sustained_held(t, x, t[-1])))
