"""Closed ways of the tool: corners, the samples between them, and their time law."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array

_TURN_LENGTH = 0.03  # length that counts as much as a rotation by one radian [m]
_LEVER = 0.15  # length by which a rotation of the hand counts for its speed and acceleration [m]


@dataclass(frozen=True)
class Way:
    """A closed polyline of poses. The tool starts at the first corner and ends there."""

    p: Array  #: (k, 3) corners in W; the last equals the first [m]
    theta: Array  #: (k, 3) rotation vectors relative to the start, in W [rad]

    def backwards(self) -> Way:
        """The same way in the other direction."""
        return Way(self.p[::-1], self.theta[::-1])

    def without(self, k: int) -> Way:
        """The way without its corner k, which is neither the first nor the last."""
        return Way(np.delete(self.p, k, axis=0), np.delete(self.theta, k, axis=0))

    @property
    def lengths(self) -> Array:
        """Length (k - 1,) of each edge, rotations included [m]."""
        moved = np.linalg.norm(np.diff(self.p, axis=0), axis=1)
        turned = np.linalg.norm(np.diff(self.theta, axis=0), axis=1)
        return np.asarray(moved + _TURN_LENGTH * turned)

    def samples(self, step: float, least: int) -> tuple[Array, Array]:
        """Positions and rotation vectors, both (n, 3), at most `step` [m] apart, `least` on each edge."""
        p, theta = [self.p[:1]], [self.theta[:1]]
        for k, length in enumerate(self.lengths):
            n = max(least, int(np.ceil(length / step)))
            s = np.arange(1, n + 1)[:, None] / n
            p.append(self.p[k] + s * (self.p[k + 1] - self.p[k]))
            theta.append(self.theta[k] + s * (self.theta[k + 1] - self.theta[k]))
        return np.concatenate(p), np.concatenate(theta)

    def timed(self, speed: float, acceleration: float, period: float, scale: float = 1.0) -> tuple[Array, Array]:
        """Positions and rotation vectors, both (n, 3), at each tick: by minimum jerk from corner to corner.

        Args:
            speed: mean speed of the hand on an edge [m/s].
            acceleration: its largest acceleration, which lengthens short edges [m/s^2].
            period: time between two ticks [s].
            scale: motion of the tool per motion of the hand [-].
        """
        p, theta = [self.p[:1]], [self.theta[:1]]
        moved = np.linalg.norm(np.diff(self.p, axis=0), axis=1) / scale
        turned = np.linalg.norm(np.diff(self.theta, axis=0), axis=1)
        for k, length in enumerate(moved + _LEVER * turned):
            time = max(length / speed, float(np.sqrt(5.78 * length / acceleration)), 2 * period)
            n = int(np.ceil(time / period))
            s = np.arange(1, n + 1)[:, None] / n
            s = s**3 * (10 - 15 * s + 6 * s * s)
            p.append(self.p[k] + s * (self.p[k + 1] - self.p[k]))
            theta.append(self.theta[k] + s * (self.theta[k + 1] - self.theta[k]))
        return np.concatenate(p), np.concatenate(theta)
