"""Identifies a device from traces: noise, resolution, mass, friction and delay along one axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.arrays import Array

_DELAYS = range(21)  # candidates [periods]
_SLOW = 0.15  # share of the peak velocity below which the sign of the velocity is not trusted


@dataclass(frozen=True)
class AxisFit:
    """Model of one axis: ``mass x'' + damping x' + friction sign(x') = F(t - delay) + bias``."""

    mass: float  # [kg]
    damping: float  # [N s/m]
    friction: float  # [N]
    bias: float  # constant force, for example weight that is not compensated [N]
    delay: float  # from the command to its force [s]
    residual: float  # rms of the force that the model does not explain [N]
    windows: int  # number of equations


def resolution(x: Array) -> float:
    """Step of a quantised signal x (n,), or 0.0 if its values lie on no grid of equal steps.

    The smallest difference of two values is a first guess; the step is then fitted to the whole numbers of steps.
    """
    values = np.unique(x)
    gaps = np.diff(values)
    gaps = gaps[gaps > 1e-6 * max(float(np.ptp(x)), 1e-12)]
    if len(gaps) < 3:
        return 0.0
    step = float(gaps.min())
    for _ in range(3):
        counts = np.round((values - values[0]) / step)
        if counts[-1] > 1e7:
            return 0.0
        step = float(counts @ (values - values[0]) / (counts @ counts))
    error = (values - values[0]) / step - np.round((values - values[0]) / step)
    return step if float(np.abs(error).max()) < 0.1 else 0.0


def noise(t: Array, x: Array, step: float) -> float:
    """Noise of a signal x (n,) at rest, rms: without a linear drift, and without the share of its steps."""
    residual = x - np.polyval(np.polyfit(t - t.mean(), x, 1), t - t.mean())
    return float(np.sqrt(max(float(residual @ residual) / (len(x) - 2) - step**2 / 12.0, 0.0)))


def fit_axis(t: Array, x: Array, F: Array, width: float = 0.05) -> AxisFit | None:
    """Fit of the model to positions x (n,) [m] and forces F (n,) [N] commanded at times t (n,) [s].

    The equation is multiplied by bumps that vanish with two derivatives at their ends and is integrated by parts
    (modulating functions, Shinbrot 1957), so that x is never differentiated: noise and steps of x average out. Only
    bumps, `width` [s] wide, during which the velocity keeps its sign are used. The delay is the one with the smallest
    residual. None if the device hardly moved.
    """
    dt = float(np.median(np.diff(t)))
    half = max(4, round(0.5 * width / dt))
    phi, phi1, phi2 = _bump(half, dt)
    v = np.convolve(np.gradient(x, dt), np.ones(half) / half, mode="same")
    centres = np.arange(half, len(x) - half - 1, max(1, half // 3))
    rows = centres[:, None] + np.arange(-half, half + 1)
    sign = np.sign(v[centres])
    steady = (np.abs(v[rows]) > _SLOW * np.abs(v).max()).all(axis=1) & (np.sign(v[rows]) == sign[:, None]).all(axis=1)
    centres, rows, sign = centres[steady], rows[steady], sign[steady]
    if len(centres) < 12 or float(np.ptp(x)) < 1e-4:
        return None
    area = dt * phi.sum()
    local = x[rows] - x[centres, None]
    A = np.column_stack([dt * local @ phi2, -dt * local @ phi1, sign * area, -np.full(len(sign), area)]) / area
    best: AxisFit | None = None
    for periods in _DELAYS:
        late = np.concatenate([np.zeros(periods), F[: len(F) - periods]])
        held = 0.5 * (late[rows] + late[rows - 1])  # the force acts from one sample to the next
        b = dt * held @ phi / area
        found, *_ = np.linalg.lstsq(A, b, rcond=None)
        residual = float(np.sqrt(np.mean((A @ found - b) ** 2)))
        if best is None or residual < best.residual:
            mass, damping, friction, bias = found.tolist()
            best = AxisFit(mass, damping, friction, bias, periods * dt, residual, len(b))
    return best


def _bump(half: int, dt: float) -> tuple[Array, Array, Array]:
    """The bump (1 - s^2)^4 over 2 half + 1 samples, and its first two derivatives by time."""
    s = np.linspace(-1.0, 1.0, 2 * half + 1)
    w = half * dt
    u = 1.0 - s**2
    return u**4, -8.0 * s * u**3 / w, (-8.0 * u**3 + 48.0 * s**2 * u**2) / w**2
