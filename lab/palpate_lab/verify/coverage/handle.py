"""A simulated handle with three axes for the estimates of `device bench`, integrated here in plain numbers."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.devices.driver import Reading
from palpate.devices.simulated import SimulatedDevice, Truth

PERIOD, QUARTERS = 1e-3, 4
"""Time between two readings [s], and steps of the motion in it."""
_EYE = np.eye(4)


@dataclass(frozen=True)
class Axis:
    """Parameters of each axis."""

    mass: float = 0.2  # kg
    damping: float = 0.5  # N s/m
    friction: float = 0.05  # N
    delay: int = 9  # quarters of a period
    noise: float = 2e-5  # m
    step: float = 1e-5  # m


class Handle(SimulatedDevice):
    """Three axes with the same parameters; each reading takes one period.

    `outside` is a force [N] by axis, position [m], velocity [m/s] and time [s]. Without one, an axis that is neither
    commanded nor moving is left where it is.
    """

    def __init__(
        self, axis: Axis, seed: int, outside: Callable[[int, float, float, float], float] | None = None
    ) -> None:
        super().__init__(truth=Truth(delay=0.0))
        self.axis, self.outside, self.gain, self.time = axis, outside, 1.0, 0.0
        self.free: tuple[int, ...] = (0, 1, 2)  #: axes that move
        self.random = random.Random(seed)
        self.forces = [(0.0, 0.0, 0.0)] * (axis.delay // QUARTERS + 2)  # of the last periods, the newest last
        self.places, self.speeds, self.now = [0.0] * 3, [0.0] * 3, (0.0, 0.0, 0.0)

    def open(self) -> None:
        """Nothing to open."""

    def read(self) -> Reading:
        """The noisy, rounded pose a period later."""
        self.forces.append(self.now)
        gauss, late = self.random.gauss, self.axis.delay
        for quarter in range(QUARTERS):
            force = self.forces[-1 - (late + QUARTERS - 1 - quarter) // QUARTERS]
            for i in self.free:
                if force[i] != 0.0 or self.speeds[i] != 0.0 or self.outside is not None:
                    self._move(i, self.gain * force[i], PERIOD / QUARTERS)
        self.time += PERIOD
        del self.forces[0]
        step, noise = self.axis.step, self.axis.noise
        X = _EYE.copy()
        X[:3, 3] = [step * round((p + noise * gauss(0.0, 1.0)) / step) for p in self.places]
        return Reading(X)

    def write(self, wrench: Array) -> None:
        """Take the force, which acts after the delay."""
        self.now = tuple(wrench[:3].tolist())

    def _move(self, i: int, force: float, dt: float) -> None:
        p, v, m = self.places[i], self.speeds[i], self.axis.mass + (self.load if i == 2 else 0.0)
        if self.outside is not None:
            force += self.outside(i, p, v, self.time)
        u = (v + dt / m * force) / (1.0 + dt / m * self.axis.damping)
        after = math.copysign(max(abs(u) - dt / m * self.axis.friction, 0.0), u)
        self.places[i], self.speeds[i] = p + 0.5 * dt * (v + after), after
