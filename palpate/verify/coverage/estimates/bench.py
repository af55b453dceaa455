"""Mass, damping, friction and delay of a simulated device, along its three axes."""

from __future__ import annotations

import numpy as np

from palpate.arrays import Array
from palpate.devices.bench import measure
from palpate.devices.simulated import SimulatedDevice, Truth
from palpate.verify.coverage.trial import RIGHT, Trial, of_intervals

COMMAND = "device bench"
FORMS = {
    RIGHT: "0.2 kg, 2.25 ms, 20 um of noise",
    "cogging": "motors of 0.15 N that depend on the place",
    "held": "a hand holds the handle by a spring of 120 N/m",
    "late": "a delay of 85 ms",
}


class _Other(SimulatedDevice):
    """A device of another form."""

    def __init__(self, truth: Truth, form: str) -> None:
        super().__init__(truth=truth)
        self.form = form

    def _advance(self, F: Array, dt: float, steps: int) -> None:
        for _ in range(steps):
            more = 0.15 * np.sin(self._p / 1.5e-3) if self.form == "cogging" else 0.0
            more = more - 120.0 * self._p - 5.0 * self._v if self.form == "held" else more
            super()._advance(F + more, dt, 1)


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One bench."""
    truth = Truth(noise=2e-5, delay=85 if form == "late" else 2.25, seed=int(rng.integers(2**31)))
    driver = SimulatedDevice(truth=truth) if form in (RIGHT, "late") else _Other(truth, form)
    bench = measure(driver, "simulated")
    value, true, half = [], [], []
    for axis in bench.axes:
        if axis.fit is not None:
            for name, known in (("mass", 0.2), ("damping", 0.5), ("friction", 0.05), ("delay", 2.25e-3)):
                value.append(getattr(axis.fit, name))
                true.append(known)
                half.append(axis.fit.student * getattr(axis.fit.deviations, name))
    return of_intervals(np.array(value), np.array(true), np.array(half), bool(bench.doubts()))
