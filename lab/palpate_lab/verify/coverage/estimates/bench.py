"""Mass, damping, friction and delay of a simulated device, along its three axes."""

from __future__ import annotations

import math

import numpy as np

from palpate.devices.bench import measure
from palpate_lab.verify.coverage.handle import Axis, Handle
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_intervals

COMMAND = "device bench"
FORMS = {
    RIGHT: "0.2 kg, 2.25 ms, 20 um of noise",
    "cogging": "motors of 0.15 N that depend on the place",
    "held": "a hand holds the handle by a spring of 120 N/m",
    "late": "a delay of 85 ms",
}
_TRUE = {"mass": 0.2, "damping": 0.5, "friction": 0.05, "delay": 2.25e-3}  # kg, N s/m, N, s


def _outside(form: str, p: float, v: float) -> float:
    if form == "cogging":
        return 0.15 * math.sin(p / 1.5e-3)
    return -120.0 * p - 5.0 * v if form == "held" else 0.0


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One bench."""
    outside = None if form == RIGHT else lambda i, p, v, t: _outside(form, p, v)
    device = Handle(Axis(delay=340 if form == "late" else 9), int(rng.integers(2**31)), outside)
    bench = measure(device, "simulated")
    fits = [axis.fit for axis in bench.axes if axis.fit is not None]
    found = [(getattr(f, name), true, f.student * getattr(f.deviations, name))
             for f in fits for name, true in _TRUE.items()]  # fmt: skip
    value, known, half = np.array(found).reshape(-1, 3).T
    return of_intervals(value, known, half, bool(bench.doubts()))
