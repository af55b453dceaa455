"""Force on the handle over the commanded one, by a weight that hangs on it."""

from __future__ import annotations

import numpy as np

from palpate.devices.accuracy import by_weight
from palpate.devices.simulated import GRAVITY
from palpate_lab.verify.coverage.handle import Axis, Handle
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_intervals

COMMAND = "device bench"
FORMS = {
    RIGHT: "weights of 50 to 200 g; 20 to 150 mN of friction",
    "rests": "the weight rests on a table in the lower third of the way",
    "falls": "the weight falls off in the middle of its motion",
    "leans": "a hand leans on the handle with 0.1 N",
}
_LEAN = np.array([0.1, 0.07, 0.05])  # N
_HANGS = 10.0  # time after which the weight hangs [s]


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One comparison with a weight."""
    weight, gain = rng.uniform(0.05, 0.2), rng.uniform(0.8, 1.2)
    axis = Axis(mass=rng.uniform(0.1, 0.4), damping=rng.uniform(0.1, 1.0), friction=rng.uniform(0.02, 0.15))

    turn, phase = 2.0 * np.pi / rng.uniform(3.0, 15.0, 3), rng.uniform(0.0, 2.0 * np.pi, 3)

    def outside(i: int, p: float, v: float, t: float) -> float:
        lean = float(np.sum(_LEAN * np.sin(turn * t + phase))) if form == "leans" else 0.0
        if device.load == 0.0:
            return lean
        carried = lean
        if form == "rests" and p < -1.3e-3:
            carried = min(weight * GRAVITY, 2000.0 * (-1.3e-3 - p))
        if form == "falls" and t > 1.5 * _HANGS:
            carried = weight * GRAVITY
        return carried - weight * GRAVITY

    device = Handle(axis, int(rng.integers(2**31)), outside)
    device.gain, device.free = gain, (2,)
    found = by_weight(device, "simulated", weight, lambda words: None)
    return of_intervals(np.array([found.gain]), np.array([gain]), np.array([found.reach]), bool(found.doubts))
