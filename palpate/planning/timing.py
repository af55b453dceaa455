"""Times along a path, within limits of the joints' speed, acceleration and jerk.

A straight line is travelled by the time-optimal motion of one axis with limited jerk (Ruckig: Berscheid and Kroeger,
RSS 2021), a rounded corner at the constant speed that its curvature allows. Speed and acceleration are continuous.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.planning.curves import Curve

_SPEED_UP = 0.25  # default time in which a joint reaches its speed [s]
_JERK = 0.08  # default time in which a joint reaches its acceleration [s]
_MARGIN = 0.995  # fraction of the limits that is used, because extremes of corners are found by sampling


@dataclass(frozen=True)
class Limits:
    """Largest speed, acceleration and jerk (n,) of each joint [rad/s, m/s; per s; per s^2]."""

    v: Array
    a: Array
    j: Array

    @classmethod
    def of(cls, arm: Arm, speed: float) -> Limits:
        """A fraction of the arm's speed limits, reached in 0.25 s, with the acceleration reached in 0.08 s."""
        v = speed * np.asarray(arm.v_max)
        return cls(v, v / _SPEED_UP, v / _SPEED_UP / _JERK)


@dataclass(frozen=True)
class _Jerked:
    """A motion along one axis in phases of constant jerk."""

    duration: float
    begins: Array  # (7,) first time of each phase [s]; then position, speed, acceleration and jerk there
    s: Array
    v: Array
    a: Array
    j: Array

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Position, speed and acceleration (K,) at times (K,) within the duration."""
        k = np.maximum(np.searchsorted(self.begins, t, "right") - 1, 0)
        d, j = t - self.begins[k], self.j[k]
        a, v = self.a[k] + d * j, self.v[k] + d * (self.a[k] + 0.5 * d * j)
        return self.s[k] + d * (self.v[k] + d * (0.5 * self.a[k] + d * j / 6.0)), v, a


@dataclass(frozen=True)
class _Piece:
    """A curve with its length in the metric of the path, its first time [s], duration [s] and motion along it."""

    curve: Curve
    length: float
    begin: float
    duration: float
    motion: _Jerked | float  # the constant speed of a corner


class Trajectory:
    """A path with times.

    Args:
        curves: the path, each curve beginning where the one before ends.
        scale: motion of the tip per motion of each joint (n,), in which lengths are measured.
        limits: limits of the joints.
    """

    def __init__(self, curves: list[Curve], scale: Array, limits: Limits) -> None:
        self.curves, self.scale, self.limits = curves, scale, limits
        lengths = [max(_length(curve, scale), 1e-12) for curve in curves]
        allowed = [_allowed(curve, length, limits) for curve, length in zip(curves, lengths, strict=True)]
        speeds = _junction_speeds(curves, lengths, allowed)
        self._pieces: list[_Piece] = []
        begin = 0.0
        for k, (curve, length) in enumerate(zip(curves, lengths, strict=True)):
            if _is_line(curve):
                motion = _one_axis(length, speeds[k], speeds[k + 1], allowed[k])
                duration = float(motion.duration)
            else:
                motion, duration = speeds[k], length / speeds[k]
            self._pieces.append(_Piece(curve, length, begin, duration, motion))
            begin += duration
        self.duration = begin  #: [s]

    @cached_property
    def _begins(self) -> Array:
        return np.array([piece.begin for piece in self._pieces])

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration (K, n) at times t (K,) [s]; the start before 0, the end after it."""
        t = np.clip(np.asarray(t, dtype=float), 0.0, self.duration)
        n = self.curves[0].controls.shape[1]
        q, v, a = np.empty((len(t), n)), np.empty((len(t), n)), np.empty((len(t), n))
        which = np.clip(np.searchsorted(self._begins, t, "right") - 1, 0, len(self._pieces) - 1)
        for k in np.unique(which):
            piece, rows = self._pieces[k], np.nonzero(which == k)[0]
            s, ds, dds = _along(piece, np.minimum(t[rows] - piece.begin, piece.duration))
            u, du, ddu = s / piece.length, ds / piece.length, dds / piece.length
            first, second = piece.curve.derivative(u), piece.curve.derivative(u, 2)
            q[rows] = piece.curve.at(u)
            v[rows] = first * du[:, None]
            a[rows] = second * du[:, None] ** 2 + first * ddu[:, None]
        return q, v, a

    def time_at(self, index: int, u: float) -> float:
        """Time [s] at which the motion passes the place u in 0..1 of a curve."""
        piece = self._pieces[index]
        if isinstance(piece.motion, float):
            return piece.begin + u * piece.duration
        low, high = 0.0, piece.duration
        for _ in range(50):
            middle = 0.5 * (low + high)
            s = float(piece.motion.at(np.array([middle]))[0][0])
            low, high = (middle, high) if s < u * piece.length else (low, middle)
        return piece.begin + high

    def index_at(self, t: float) -> int:
        """Index of the curve on which the motion is at a time [s]."""
        return int(np.clip(np.searchsorted(self._begins, t, "right") - 1, 0, len(self._pieces) - 1))

    def between(self, begin: float, end: float) -> list[Curve]:
        """The curves that are travelled from one time to another [s]; corners whole."""
        first, last = self.index_at(begin), self.index_at(end)
        curves = list(self.curves[first : last + 1])
        a, b = self._place(first, begin), self._place(last, end)
        if first == last:
            return [curves[0].part(a, max(b, a))]
        return [curves[0].part(a, 1.0), *curves[1:-1], curves[-1].part(0.0, b)]

    def _place(self, index: int, t: float) -> float:
        """The place in 0..1 of a curve at a time [s]."""
        piece = self._pieces[index]
        s = _along(piece, np.clip([t - piece.begin], 0.0, piece.duration))[0]
        return float(np.clip(s[0] / piece.length, 0.0, 1.0))

    def sampled(self, rate: float) -> tuple[Array, Array]:
        """Times (N,) [s] and positions (N, n) [rad, m] at a rate [Hz], the end included."""
        t = np.r_[np.arange(0.0, self.duration, 1.0 / rate), self.duration]
        return t, self.at(t)[0]


def _is_line(curve: Curve) -> bool:
    return len(curve.controls) == 2


def _length(curve: Curve, scale: Array) -> float:
    """Length of a line; for a corner the length with which its speed joins those of its legs."""
    if _is_line(curve):
        return float(np.linalg.norm(scale * (curve.controls[1] - curve.controls[0])))
    return float(5.0 * np.linalg.norm(scale * (curve.controls[1] - curve.controls[0])))


def _allowed(curve: Curve, length: float, limits: Limits) -> tuple[float, float, float]:
    """Speed, acceleration and jerk along a curve that keep all joints within their limits; for a corner its speed."""
    u = np.linspace(0.0, 1.0, 2 if _is_line(curve) else 129)
    first = np.abs(curve.derivative(u) / length).max(axis=0)
    v, a, j = (_MARGIN * _least(limit, first) for limit in (limits.v, limits.a, limits.j))
    if not _is_line(curve):
        second = np.abs(curve.derivative(u, 2) / length**2).max(axis=0)
        third = np.abs(curve.derivative(u, 3) / length**3).max(axis=0)
        v = min(v, _MARGIN * _least(limits.a, second) ** 0.5, _MARGIN * _least(limits.j, third) ** (1.0 / 3.0))
    return v, a, j


def _least(limit: Array, rate: Array) -> float:
    with np.errstate(divide="ignore"):
        return float(np.min(np.where(rate > 1e-12, limit / np.maximum(rate, 1e-300), 1e9)))


def _junction_speeds(curves: list[Curve], lengths: list[float], allowed: list[tuple[float, float, float]]) -> Array:
    """Speeds (k + 1,) at the ends of the curves: zero at both ends and at corners that are not rounded."""
    count = len(curves)
    speeds = np.zeros(count + 1)
    for k in range(1, count):
        round_ends = [allowed[i][0] for i in (k - 1, k) if not _is_line(curves[i])]
        speeds[k] = min(*round_ends, allowed[k - 1][0], allowed[k][0]) if round_ends else 0.0
    for _ in range(count + 1):
        before = speeds.copy()
        for k in [*range(count), *reversed(range(count))]:
            if _is_line(curves[k]):
                low, high = sorted((speeds[k], speeds[k + 1]))
                high = _reachable(low, high, lengths[k], allowed[k])
                speeds[k], speeds[k + 1] = min(speeds[k], high), min(speeds[k + 1], high)
            else:
                speeds[k] = speeds[k + 1] = min(speeds[k], speeds[k + 1])
        if np.array_equal(before, speeds):
            break
    return speeds


def _reachable(low: float, high: float, length: float, allowed: tuple[float, float, float]) -> float:
    """The largest speed up to `high` that is reached from `low` within a length, with no acceleration at both ends."""
    _, a, j = allowed

    def needed(v: float) -> float:
        change = v - low
        duration = 2.0 * (change / j) ** 0.5 if change <= a * a / j else change / a + a / j
        return 0.5 * (v + low) * duration

    if needed(high) <= length * 0.999:
        return high
    least, most = low, high
    for _ in range(60):
        middle = 0.5 * (least + most)
        least, most = (middle, most) if needed(middle) <= length * 0.999 else (least, middle)
    return least


def _one_axis(length: float, v0: float, v1: float, allowed: tuple[float, float, float]) -> _Jerked:
    """The time-optimal motion of one axis over a length."""
    import ruckig

    otg, given, made = ruckig.Ruckig(1), ruckig.InputParameter(1), ruckig.Trajectory(1)
    given.current_position, given.current_velocity, given.current_acceleration = [0.0], [v0], [0.0]
    given.target_position, given.target_velocity, given.target_acceleration = [length], [v1], [0.0]
    given.max_velocity, given.max_acceleration, given.max_jerk = [allowed[0]], [allowed[1]], [allowed[2]]
    result = otg.calculate(given, made)
    if int(result) < 0:
        raise RuntimeError(f"ruckig: {result} for length {length}, speeds {v0} to {v1}, limits {allowed}")
    profile = made.profiles[0][0]
    begins = np.r_[0.0, np.cumsum(profile.t)[:-1]]
    parts = (np.array(x[: len(begins)]) for x in (profile.p, profile.v, profile.a, profile.j))
    return _Jerked(float(made.duration), begins, *parts)


def _along(piece: _Piece, t: Array) -> tuple[Array, Array, Array]:
    """Position, speed and acceleration (K,) along a piece at times t (K,) after its begin."""
    if isinstance(piece.motion, float):
        return piece.motion * t, np.full(len(t), piece.motion), np.zeros(len(t))
    s, ds, dds = piece.motion.at(t)
    return np.clip(s, 0.0, piece.length), ds, dds
