"""Predicts the present pose of a tracked tool from late, noisy poses with their times of measurement.

Position and rotation have a filter each: a Kalman filter of a motion whose jerk is white noise. Its measurement noise
is taken from the poses themselves. A tool that keeps to one place within what noise explains rests: its velocity is
exactly zero, so that noise alone moves nothing.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array, rigid

LONGEST = 0.25
"""Longest interval over which a pose is extrapolated, and between two poses of one motion [s]."""
_MOVING = 1.0  # a tool moves for this long after it left a place [s]
_RATIO = 2.0  # mean squared innovation over its variance above which the motion has changed [-]
_FOLLOW = 300.0  # factor of the jerk's density when the motion changes [-]
_FLAT_FOR, _FLAT = 0.3, 4.0  # a tool stops when the slope of this time [s] is below this squared ratio to its variance
_MEAN = 100  # poses in the mean of a place
_RECENT, _NOISE_SHARE = 0.4, 0.03  # weight of the newest innovation, and of the newest estimate of the noise [-]
_SIGMAS = 7.0  # displacement that shows a motion, in standard deviations of the filtered position [-]


@dataclass(frozen=True)
class _Scale:
    """Values of a translation [m] or of a rotation [rad]."""

    noise: float  # first guess of the measurement noise on each axis
    least: float  # smallest noise
    jerk: float  # spectral density of the jerk [unit^2/s^5]
    speed: float  # standard deviation of the speed of a tool that is seen for the first time [unit/s]
    acceleration: float  # the same [unit/s^2]
    place: float  # displacement that shows a motion where there is no noise


# The jerk: breathing of 10 mm at 0.25 Hz has an rms of 0.03 m/s^3, which this density reaches in a third of a second.
_POSITION = _Scale(2.5e-4, 2e-5, 3e-3, 0.05, 0.1, 3e-4)
_ROTATION = _Scale(2e-3, 1e-4, 0.08, 0.5, 1.0, 5e-3)


class Predictor:
    """Motion of one tool.

    Args:
        X: pose (4, 4) of the first measurement [m].
        t: its time [s].
    """

    def __init__(self, X: Array, t: float) -> None:
        self._R, self.t = X[:3, :3], t  #: time of the newest measurement [s]
        self._p, self._turn = _Filter(_POSITION, X[:3, 3], t), _Filter(_ROTATION, np.zeros(3), t)
        self._interval = 0.0  # mean time between two measurements [s]

    def take(self, X: Array, t: float) -> None:
        """Take in a pose (4, 4) [m] that was measured at the time `t` [s]. A long silence begins a new motion."""
        dt = t - self.t
        if not 0.0 < dt <= LONGEST:
            if dt != 0.0:
                self.__init__(X, t)  # type: ignore[misc]
            return
        self.t = t
        self._interval += (0.2 if self._interval else 1.0) * (dt - self._interval)
        self._p.take(X[:3, 3], t)
        self._turn.take(rigid.log(X[:3, :3] @ self._R.T), t)
        self._R = rigid.exp(self._turn.recentred()) @ self._R

    @property
    def moving(self) -> bool:
        """True while the tool moves; a tool at rest has no velocity."""
        return self._p.moving or self._turn.moving

    def at(self, t: float, delay: float = 0.0) -> Array:
        """Pose (4, 4) at the time `t` [s], constant once poses are missing.

        delay: usual time from a measurement to its arrival [s].
        """
        t = min(t, self.t + min(delay + 2.0 * self._interval, LONGEST))
        return rigid.rigid(rigid.exp(self._turn.at(t)) @ self._R, self._p.at(t))


class _Filter:
    """Kalman filter of three axes with one covariance: position, velocity and acceleration; the jerk is white noise."""

    def __init__(self, scale: _Scale, x: Array, t: float) -> None:
        self._scale, self._t = scale, t
        self._x = np.vstack([x, np.zeros((2, 3))])  # rows: position, velocity, acceleration
        self._P = np.diag([scale.noise**2, scale.speed**2, scale.acceleration**2])
        self._noise, self._ratio = scale.noise**2, 1.0
        self._place, self._stayed = x, 1  # mean position since the tool left the place before, number of poses
        self._left = -math.inf  # time at which it left it [s]
        self._base = np.zeros(3)  # sum of the positions by which the axes were moved
        self._seen: deque[tuple[float, Array]] = deque([(t, x)])  # the newest measurements
        self._flat = False  # True: their slope is explained by noise

    @property
    def moving(self) -> bool:
        return bool(self._t - self._left < _MOVING and not self._flat)

    def take(self, x: Array, t: float) -> None:
        F, Q = _transition(t - self._t), self._scale.jerk * _covariance(t - self._t)
        self._t, self._x, P = t, F @ self._x, F @ self._P @ F.T
        self._keep(t, x + self._base)
        off, variance = x - self._x[0], P[0, 0] + Q[0, 0] + self._noise
        self._ratio += _RECENT * (off @ off / (3.0 * variance) - self._ratio)
        P = P + (_FOLLOW if self._ratio > _RATIO else 1.0) * Q
        gain = P[:, 0] / (P[0, 0] + self._noise)
        self._x = self._x + np.outer(gain, off)
        self._P = P - np.outer(gain, P[0])
        self._look_for_motion(t)

    def at(self, t: float) -> Array:
        return np.asarray((_transition(t - self._t) @ self._x if self.moving else self._x)[0])

    def recentred(self) -> Array:
        """Move the origin of the axes to the position; returns the displacement."""
        moved: Array = self._x[0].copy()
        self._base, self._x[0] = self._base + moved, 0.0
        return moved

    def _keep(self, t: float, x: Array) -> None:
        """Keep a measurement; measure the noise and the slope of the newest ones."""
        self._seen.append((t, x))
        while len(self._seen) > 4 and t - self._seen[0][0] > _FLAT_FOR:
            self._seen.popleft()
        if len(self._seen) < 4:
            return
        times, xs = np.array([at for at, _ in self._seen]) - t, np.array([x for _, x in self._seen])
        # The third divided difference of four positions is zero for every parabola.
        last = times[-4:]
        weights = 1.0 / (last[:, None] - last + np.eye(4)).prod(axis=1)
        d = weights @ xs[-4:]
        self._noise += _NOISE_SHARE * (d @ d / (3.0 * weights @ weights) - self._noise)
        self._noise = max(self._noise, self._scale.least**2)
        times -= times.mean()
        slope, spread = times @ xs / (times @ times), times @ times
        self._flat = bool(slope @ slope < _FLAT * self._noise / spread)

    def _look_for_motion(self, t: float) -> None:
        """Compare the position with the mean of those since the tool left its last place."""
        here, far = self._x[0] + self._base, max(self._scale.place, _SIGMAS * math.sqrt(self._P[0, 0]))
        if np.linalg.norm(here - self._place) > far:
            self._place, self._stayed, self._left = here, 0, t
        self._stayed = min(self._stayed + 1, _MEAN)
        self._place = self._place + (here - self._place) / self._stayed


def _transition(dt: float) -> Array:
    return np.array([[1.0, dt, 0.5 * dt * dt], [0.0, 1.0, dt], [0.0, 0.0, 1.0]])


def _covariance(dt: float) -> Array:
    """Covariance (3, 3) that white jerk of density 1 adds in a time."""
    a, b, c = dt**3 / 6.0, dt**2 / 2.0, dt
    return np.array([[dt**5 / 20, dt**4 / 8, a], [dt**4 / 8, dt**3 / 3, b], [a, b, c]])
