"""Friction of a moving arm with six joints, from 12 s of motion."""

from __future__ import annotations

from functools import cache

import numpy as np

from palpate.arm import Arm
from palpate.arm.identify import dynamics
from palpate.arm.identify.motion import motion
from palpate.arm.identify.recordings import Moving
from palpate.base.arrays import Array
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_intervals

COMMAND = "calibrate dynamics"
FORMS = {
    RIGHT: "links of the model file, friction and rotors, 2 % of noise",
    "stribeck": "friction that doubles at low speed",
    "cable": "springs that are sines of the joints",
    "late": "torques 50 ms after the motion",
}
_RATE, _SECONDS = 100.0, 12.0
_MIDDLE, _SWING = np.array([0.0, 0.3, 1.5, 0.0, 1.2, 0.0]), np.array([1.0, 0.5, 0.5, 1.0, 0.6, 1.0])  # rad
_COULOMB = np.array([0.03, 0.03, 0.02, 0.005, 0.005, 0.003])  # N m
_VISCOUS = np.array([0.03, 0.03, 0.02, 0.002, 0.002, 0.001])  # N m s/rad
_ROTOR = np.array([2e-3, 2e-3, 1e-3, 5e-5, 5e-5, 2e-5])  # kg m^2


@cache
def _arm() -> Arm:
    return Arm.model("six_axis")


def _dry(q: Array) -> Array:
    """Dry friction (k,) over its Coulomb value, with 10 mrad of presliding: exact along monotone pieces."""
    z = np.zeros(len(q))
    for k in range(1, len(q)):
        d = q[k] - q[k - 1]
        s = 1.0 if d > 0.0 else -1.0
        z[k] = s + (z[k - 1] - s) * np.exp(-abs(d) / 0.01)
    return z


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One recording; the intervals of dry and viscous friction are judged."""
    arm, t = _arm(), np.arange(round(_RATE * _SECONDS))[:, None, None] / _RATE
    w, phase = 2.0 * np.pi * rng.uniform(0.1, 0.9, (5, 6)), rng.uniform(0.0, 2.0 * np.pi, (5, 6))
    size = rng.dirichlet(np.ones(5), 6).T * _SWING
    q = _MIDDLE + (size * np.sin(w * t + phase)).sum(axis=1)
    v = (size * w * np.cos(w * t + phase)).sum(axis=1)
    a = -(size * w**2 * np.sin(w * t + phase)).sum(axis=1)
    dry = np.column_stack([_dry(q[:, j]) for j in range(6)])
    if form == "stribeck":
        dry = dry * (1.0 + np.exp(-np.square(v / 0.1)))
    tau = np.array([arm.inverse_dynamics(*row) for row in zip(q, v, a, strict=True)])
    tau += _COULOMB * dry + _VISCOUS * v + _ROTOR * a
    if form == "cable":
        tau += 0.1 * tau.std(axis=0) * np.sin(4.0 * q)
    if form == "late":
        tau = np.roll(tau, 5, axis=0)
    tau += 0.02 * tau.std(axis=0) * rng.normal(size=tau.shape)
    found = dynamics.identify([motion(Moving(q, v, tau, _RATE, "simulated"))], arm)
    names = [term.name for term in found.train.terms]
    rows = [names.index(f"{kind}_{j + 1}") for kind in ("coulomb", "viscous") for j in range(6)]
    told = bool((found.misfit > dynamics.MISFIT).any())
    return of_intervals(found.theta[rows], np.r_[_COULOMB, _VISCOUS], 1.96 * found.deviation[rows], told)
