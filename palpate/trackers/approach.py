"""Rate-limited motion of an object towards a goal pose: limited speed, angular speed and acceleration."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from palpate import _core
from palpate.arrays import Array, rigid

_GAIN = 8.0  # speed per remaining distance near the goal [1/s]
_SMOOTH = 4.0 * _GAIN  # rate at which the velocity takes its new value: the pair is critically damped [1/s]
_LEVER = 0.1  # length that converts the limit of the acceleration to an angular acceleration [m]
_BAND = (3e-4, 5e-3)  # mean distance from the goal within which an object rests [m, rad]
_MEAN = 0.2  # time constant of that mean [s]
_SLOW = (1e-3, 1e-2)  # speed below which an object at its goal stops [m/s, rad/s]


@dataclass(frozen=True)
class RateLimits:
    """Limits of the motion of an object that follows a frame."""

    speed: float = 0.1
    """[m/s]"""
    turn: float = math.radians(60.0)
    """[rad/s]"""
    acceleration: float = 0.5
    """[m/s^2]"""


class Approach:
    """An object that moves in closed form between updates, and changes its velocity at each update.

    After an update at t0 it moves by v sin(omega (t - t0)) / omega: with the velocity v, as long as the next update is
    near, and never farther than v / omega if updates fail, for example because the machine is busy.

    The wanted velocity of the centre points to the goal: with the remaining distance e, its magnitude is the smallest
    of k e, sqrt(a e) (from which it can still stop) and the largest speed. The velocity approaches it at the rate 4 k,
    which filters the tracker's noise, and changes by at most a h in an interval h. The rotation likewise. An object
    rests while its mean distance from the goal is below 0.3 mm and 0.3 deg, so that noise alone does not move it.

    Args:
        X_WO: pose (4, 4) at the time `t` [m].
        centre_O: point (3,) in the object's frame about which it turns [m].
        t: time [s].
        limits: limits of speed and acceleration.
    """

    def __init__(self, X_WO: Array, centre_O: Array, t: float, limits: RateLimits) -> None:
        self.X, self.t, self.limits = X_WO.copy(), t, limits
        self.v, self.w = np.zeros(3), np.zeros(3)  # of the centre, in W [m/s, rad/s]
        self._centre_O = np.array(centre_O)
        self._omega = _GAIN  # of the motion between updates [rad/s]
        self._off = np.zeros(6)  # mean displacement from here to the goal [m, rad]

    @property
    def moves(self) -> bool:
        """True while the object has a velocity."""
        return bool(self.v.any() or self.w.any())

    @property
    def V_WO(self) -> Array:
        """Velocity (6,) of the object's origin over its angular velocity, in W [m/s, rad/s]."""
        v = self.v + np.cross(self.w, self.X[:3, 3] - self._centre_W(self.X))
        return np.concatenate([v, self.w])

    def advance(self, t: float) -> None:
        """Move to the time `t` [s] along the present motion."""
        angle, c = self._omega * (t - self.t), self._centre_W(self.X)
        dt = math.sin(angle) / self._omega
        R = rigid.exp(self.w * dt)
        self.X[:3, :3], self.X[:3, 3] = R @ self.X[:3, :3], c + self.v * dt + R @ (self.X[:3, 3] - c)
        self.v, self.w, self.t = math.cos(angle) * self.v, math.cos(angle) * self.w, t

    def aim(self, goal: Array, interval: float) -> None:
        """Choose the velocity for the next interval [s] towards a goal pose (4, 4)."""
        a, k = self.limits.acceleration, min(_GAIN, 0.5 / interval)
        self._omega = min(_GAIN, 1.5 / interval)
        e = self._centre_W(goal) - self._centre_W(self.X)
        turn = rigid.log(goal[:3, :3] @ self.X[:3, :3].T)
        self._off += (np.concatenate([e, turn]) - self._off) * min(interval / _MEAN, 1.0)
        if self._is_near(0.5 if self.moves else 1.0) and not self._is_fast():
            self.hold()
            return
        self.v = _changed(self.v, e, k, self.limits.speed, a, interval)
        self.w = _changed(self.w, turn, k, self.limits.turn, a / _LEVER, interval)

    def _is_near(self, share: float) -> bool:
        size = np.linalg.norm(self._off[:3]), np.linalg.norm(self._off[3:])
        return bool(size[0] < share * _BAND[0] and size[1] < share * _BAND[1])

    def _is_fast(self) -> bool:
        return bool(np.linalg.norm(self.v) > _SLOW[0] or np.linalg.norm(self.w) > _SLOW[1])

    def hold(self) -> None:
        """Stop at the present pose."""
        self.v, self.w = np.zeros(3), np.zeros(3)

    def motion(self) -> tuple[Array, _core.Motion]:
        """Pose (4, 4) at the present time, and the motion from there, for the core."""
        wave = _core.Wave(self.v / self._omega, self.w / self._omega, math.tau / self._omega, -self._omega * self.t)
        return self.X, _core.Motion(waves=[wave] if self.moves else [], about=self._centre_W(self.X))

    def _centre_W(self, X: Array) -> Array:
        return np.asarray(X[:3, :3] @ self._centre_O + X[:3, 3])


def _changed(v: Array, e: Array, k: float, fastest: float, a: float, interval: float) -> Array:
    """Velocity (3,) for the next interval, from the present one and the remaining displacement (3,)."""
    left = float(np.linalg.norm(e))
    wanted = e * (min(k * left, math.sqrt(a * left), fastest) / left) if left > 0.0 else np.zeros(3)
    change = (wanted - v) * min(_SMOOTH * interval, 1.0)
    size, most = float(np.linalg.norm(change)), a * interval
    new = v + change * min(most / max(size, 1e-12), 1.0)
    return np.asarray(new)
