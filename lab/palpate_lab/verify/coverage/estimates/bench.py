"""Mass, damping, friction and delay of a simulated device, along its three axes."""

from __future__ import annotations

import math
import random

import numpy as np

from palpate.base.arrays import Array
from palpate.devices.bench import measure
from palpate.devices.driver import Reading
from palpate.devices.simulated import SimulatedDevice, Truth
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_intervals

COMMAND = "device bench"
FORMS = {
    RIGHT: "0.2 kg, 2.25 ms, 20 um of noise",
    "cogging": "motors of 0.15 N that depend on the place",
    "held": "a hand holds the handle by a spring of 120 N/m",
    "late": "a delay of 85 ms",
}


_PERIOD, _QUARTERS = 1e-3, 4
_MASS, _DAMPING, _FRICTION, _NOISE, _STEP = 0.2, 0.5, 0.05, 2e-5, 1e-5  # kg, N s/m, N, m, m
_EYE = np.eye(4)


class _Device(SimulatedDevice):
    """Three axes with the same mass, damping and friction, integrated here: one period per reading, plain numbers."""

    def __init__(self, form: str, seed: int) -> None:
        super().__init__(truth=Truth(delay=0.0))
        self.form, self.late = form, 340 if form == "late" else 9  # quarters of a period
        self.noise = random.Random(seed)
        self.forces = [(0.0, 0.0, 0.0)] * (self.late // _QUARTERS + 2)  # of the last periods, the newest last
        self.places, self.speeds, self.now = [0.0] * 3, [0.0] * 3, (0.0, 0.0, 0.0)

    def open(self) -> None:
        """Nothing to open."""

    def read(self) -> Reading:
        """The noisy, rounded pose a period later."""
        self.forces.append(self.now)
        gauss = self.noise.gauss
        for quarter in range(_QUARTERS):
            force = self.forces[-1 - (self.late + _QUARTERS - 1 - quarter) // _QUARTERS]
            for i in range(3):
                if force[i] != 0.0 or self.speeds[i] != 0.0 or self.form != RIGHT:
                    self._move(i, force[i], _PERIOD / _QUARTERS)
        del self.forces[0]
        X = _EYE.copy()
        X[:3, 3] = [_STEP * round((p + _NOISE * gauss(0.0, 1.0)) / _STEP) for p in self.places]
        return Reading(X)

    def write(self, wrench: Array) -> None:
        """Take the force, which acts after the delay."""
        self.now = tuple(wrench[:3].tolist())

    def _move(self, i: int, force: float, dt: float) -> None:
        p, v = self.places[i], self.speeds[i]
        if self.form == "cogging":
            force += 0.15 * math.sin(p / 1.5e-3)
        if self.form == "held":
            force -= 120.0 * p + 5.0 * v
        u = (v + dt / _MASS * force) / (1.0 + dt / _MASS * _DAMPING)
        after = math.copysign(max(abs(u) - dt / _MASS * _FRICTION, 0.0), u)
        self.places[i], self.speeds[i] = p + 0.5 * dt * (v + after), after


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One bench."""
    bench = measure(_Device(form, int(rng.integers(2**31))), "simulated")
    value, true, half = [], [], []
    for axis in bench.axes:
        if axis.fit is not None:
            for name, known in (("mass", _MASS), ("damping", _DAMPING), ("friction", _FRICTION), ("delay", 2.25e-3)):
                value.append(getattr(axis.fit, name))
                true.append(known)
                half.append(axis.fit.student * getattr(axis.fit.deviations, name))
    return of_intervals(np.array(value), np.array(true), np.array(half), bool(bench.doubts()))
