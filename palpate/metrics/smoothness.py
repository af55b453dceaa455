"""Smoothness of movements: spectral arc length and log dimensionless jerk of the speed (Balasubramanian 2012, 2015).

Both judge single movements of seconds: a pause within makes any movement unsmooth. `movements` cuts a recording.
"""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array

PADDING, CUTOFF, LEAST = 4, 10.0, 0.05
"""SPARC: powers of two by which the spectrum is refined; highest frequency [Hz]; smallest amplitude that counts."""
MOVING, SHORTEST = 0.05, 0.5
"""A movement is faster than this share of the largest speed, and longer than this [s]."""


def sparc(speed: Array, rate: float) -> float:
    """Spectral arc length: minus the length of the amplitude spectrum of the speed; 0 would be perfectly smooth.

    Args:
        speed: (n,) speed of one movement [any unit].
        rate: samples a second [Hz].

    Returns:
        The length below CUTOFF and below the last amplitude above LEAST; NaN without motion.
    """
    if not len(speed):
        return float("nan")
    n = 2 ** (int(np.ceil(np.log2(len(speed)))) + PADDING)
    amplitude = np.abs(np.fft.fft(speed, n))
    if not amplitude.max() > 0.0:
        return float("nan")
    frequency, amplitude = np.arange(n) * rate / n, amplitude / amplitude.max()
    low = frequency <= CUTOFF
    frequency, amplitude = frequency[low], amplitude[low]
    loud = np.flatnonzero(amplitude >= LEAST)
    frequency, amplitude = frequency[loud[0] : loud[-1] + 1], amplitude[loud[0] : loud[-1] + 1]
    across = np.diff(frequency) / (frequency[-1] - frequency[0])
    return float(-np.hypot(across, np.diff(amplitude)).sum())


def log_dimensionless_jerk(speed: Array, rate: float) -> float:
    """Minus the logarithm of the squared jerk, made dimensionless by duration and peak speed; larger is smoother.

    Args:
        speed: (n,) speed of one movement [any unit].
        rate: samples a second [Hz].

    Returns:
        -ln(T^3 / v_peak^2 integral of (d^2 v / dt^2)^2 dt); NaN without motion.
    """
    peak = float(np.abs(speed).max(initial=0.0))
    if peak == 0.0 or len(speed) < 3:
        return float("nan")
    jerk = np.diff(speed, 2) * rate**2
    duration = len(speed) / rate
    return float(-np.log(duration**3 / peak**2 * (jerk**2).sum() / rate))


def movements(speed: Array, rate: float) -> list[slice]:
    """The movements of a recording: spans faster than MOVING of the largest speed, longer than SHORTEST.

    Args:
        speed: (n,) speed [any unit]; what is NaN ends a movement.
        rate: samples a second [Hz].
    """
    moving = np.concatenate(([False], speed > MOVING * np.fmax.reduce(speed, initial=0.0), [False]))
    edges = np.flatnonzero(np.diff(moving.astype(int)))
    return [slice(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if (b - a) / rate > SHORTEST]
