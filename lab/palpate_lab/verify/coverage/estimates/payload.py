"""A body on a bar of a moving PSM, weighed by its drive torques against two unloaded recordings of the motion."""

from __future__ import annotations

from functools import cache

import numpy as np

from palpate.arm import Arm
from palpate.arm.drives import drive_train
from palpate.arm.dynamics import Dynamics
from palpate.arm.identify.motion import RecordedMotion
from palpate.arm.identify.payload import Hang, estimate_load
from palpate.base.arrays import Array
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_intervals

COMMAND = "study force"
FORMS = {
    RIGHT: "0.1 to 0.4 kg on the bar, 2 mN m of noise, cables that slip within 3 mN m",
    "tip": "the body hangs at the tip of the instrument",
    "late": "the loaded torques are 60 ms late",
    "caught": "a cable pulls with 0.15 N m for 4 s of the loaded recording",
}
_RATE, _SECONDS = 200.0, 20.0
_HEIGHTS = (-0.05, 0.05, 0.08, 0.12)  # of the body on the bar [m]


@cache
def _motion() -> tuple[Arm, Array, Array, Array]:
    """The arm and q, v, a (k, 7) of sums of sines."""
    rng = np.random.default_rng(7)
    middle, swing = np.array([-0.2, 0, 0.15, 0, 0, 0, 0]), np.array([0.5, 0.8, 0.07, 0.5, 0.3, 0.3, 0.3])
    w, phase = 2.0 * np.pi * rng.uniform(0.1, 0.9, (5, 7)), rng.uniform(0.0, 2.0 * np.pi, (5, 7))
    size = rng.dirichlet(np.ones(5), 7).T * swing
    t = np.arange(round(_SECONDS * _RATE))[:, None, None] / _RATE
    q = middle + (size * np.sin(w * t + phase)).sum(axis=1)
    v, a = (size * w * np.cos(w * t + phase)).sum(axis=1), -(size * w**2 * np.sin(w * t + phase)).sum(axis=1)
    return Arm.psm(), q, v, a


@cache
def _known() -> tuple[Dynamics, Array]:
    """The dynamics without friction, and the torques (k, 7) of the motion without a load [N m, N]."""
    arm, q, v, a = _motion()
    dynamics = Dynamics(arm, arm.inertial_parameters, np.zeros(len(drive_train(arm).terms)))
    return dynamics, dynamics.torque(q, v, a)


@cache
def _of_a_kilogram(height: float | None) -> Array:
    """Torques (k, 2) of a body of 1 kg on the bar, or at the tip, by d'Alembert's principle [N m]."""
    arm, q, _, _ = _motion()
    q, pivot = q[:, :6], np.array([*Hang().p_pivot, 0.0])

    def place(q: Array) -> Array:
        poses = arm.link_poses(q)
        if height is None:
            return np.asarray(poses["tip"][:, :3, 3])
        return np.asarray(poses["yaw_link"][:, :3, 0] * height + poses["pitch_link"][:, :3, :3] @ pivot)

    h, tau = 1e-6, np.zeros((len(q), 2))
    acceleration = np.gradient(np.gradient(place(q), 1.0 / _RATE, axis=0), 1.0 / _RATE, axis=0)
    for j in range(2):
        e = np.eye(6)[j] * h
        J = (place(q + e) - place(q - e)) / (2.0 * h)
        tau[:, j] = (J * (acceleration - [0.0, 0.0, -9.81])).sum(axis=1)
    return tau


def _recorded(rng: np.random.Generator) -> Array:
    """Torques (k, 7) of one unloaded recording: noise, a constant, and friction that slips at random."""
    tau = _known()[1] + 2e-3 * rng.normal(size=(len(_known()[1]), 7))
    keep = np.exp(-1.0 / _RATE)  # over a second
    slip, x = np.empty((len(tau), 2)), 3e-3 * rng.normal(size=2)
    for k, kick in enumerate(3e-3 * np.sqrt(1.0 - keep**2) * rng.normal(size=slip.shape)):
        x = keep * x + kick
        slip[k] = x
    tau[:, :2] += slip + 0.01 * rng.normal(size=2)
    return tau


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One weighing."""
    _, q, v, a = _motion()
    mass, height = rng.uniform(0.1, 0.4), _HEIGHTS[rng.integers(len(_HEIGHTS))]
    loaded = _recorded(rng)
    added = mass * _of_a_kilogram(None if form == "tip" else height)
    if form == "late":
        added = np.roll(added, 12, axis=0)
    loaded[:, :2] += added
    if form == "caught":
        start = rng.integers(200, 3000)
        loaded[start : start + 800, 1] += 0.15
    recordings = [RecordedMotion(q, v, a, tau, _RATE, 0, "simulated")
                  for tau in (loaded, _recorded(rng), _recorded(rng))]  # fmt: skip
    found = estimate_load(_known()[0], recordings[0], recordings[1:])
    low, high = found.interval
    return of_intervals(np.array([found.mass]), np.array([mass]), np.array([0.5 * (high - low)]), bool(found.doubts))
