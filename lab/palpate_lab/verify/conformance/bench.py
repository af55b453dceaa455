"""Test bench of the stage `guidance`: input is a hand motion, output is the wrench and the goal per tick."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from palpate import _core, _guidance
from palpate.base.arrays import Array
from palpate_lab.verify.conformance.combinations import OPERATOR, PEDAL, POLICIES, QUICK, Combination, PolicyCase
from palpate_lab.verify.conformance.laws import LAWS
from palpate_lab.verify.conformance.probes import Probe, satisfied_pose
from palpate_lab.verify.conformance.roles import ROLES, TOUCHED
from palpate_lab.verify.conformance.specimens import SPECIMENS

DT = 1e-3
VISIT = 60
"""Ticks in a satisfied pose before a run, so that the fixture engages."""
FORCE_RATE, MOMENT_RATE, RETURN_SPEED, RESERVE = 20.0, 0.35, 0.05, 5e-5
"""Bounds from docs/guidance-laws.md: rate of the wrench in addition to motion [N/s, N m/s], speed at which a
corrected goal returns [m/s], and distance that hard fixtures keep to their boundary [m]."""


@dataclass(frozen=True)
class Motion:
    """Commanded tool poses per tick."""

    X: Array
    """Poses in W (n, 4, 4)."""
    V: Array
    """Twists in W (n, 6), linear over angular [m/s, rad/s]."""

    @cached_property
    def displacements(self) -> Array:
        """Displacements per tick (n - 1, 6): translation over rotation vector [m, rad]."""
        R = Rotation.from_matrix(self.X[:, :3, :3])
        return np.column_stack([np.diff(self.X[:, :3, 3], axis=0), (R[1:] * R[:-1].inv()).as_rotvec()])

    def carried(self, X_WF: Array, V_WF: Array | None = None) -> Motion:
        """This motion relative to a frame with poses X_WF, (4, 4) or (n, 4, 4), and velocities V_WF (n, 6)."""
        R = np.broadcast_to(X_WF, self.X.shape)[:, :3, :3]
        V = np.concatenate([np.einsum("nij,nj->ni", R, self.V[:, s]) for s in (slice(0, 3), slice(3, 6))], axis=1)
        return Motion(X_WF @ self.X, V if V_WF is None else V + V_WF)


@dataclass(frozen=True)
class Answer:
    """Output of a run."""

    F: Array
    """Total wrench on the tool (n, 6), including the damping that the master renders [N, N m]."""
    X: Array
    """Goal poses (n, 4, 4)."""
    B: Array
    """Damping that the master renders (n, 3, 3) [N s/m]."""

    def steps(self, before: Array | None = None) -> Array:
        """Changes of force and moment per tick (n - 1, 2) [N, N m]; (n, 2) if the preceding wrench (6,) is given."""
        F = self.F if before is None else np.concatenate([before[None], self.F])
        return np.column_stack([np.linalg.norm(np.diff(F[:, s], axis=0), axis=1) for s in (slice(0, 3), slice(3, 6))])


def fixture(
    c: Combination,
    name: str = "f",
    X_WG: Array | None = None,
    frame: _core.Frame | None = None,
    law: Mapping[str, float] | None = None,
    law_name: str = "",
    policy: PolicyCase | None = None,
    rise: float = QUICK,
    on: bool = True,
    geometry: _guidance.Geometry | None = None,
) -> _guidance.Fixture:
    """The core's fixture of a combination, with a placed geometry, changed options of the law, or another policy."""
    role, law_options = _core.GuidanceRoleOptions(), _core.GuidanceLawOptions()
    for key, value in ROLES[c.role].options.items():
        setattr(role, key, value)
    for key, number in {**LAWS[c.law].options, **(law or {})}.items():
        setattr(law_options, key, number)
    shape = geometry or SPECIMENS[c.geometry].make()
    if frame is not None:
        shape = _guidance.PlacedGeometry(shape, np.eye(4) if X_WG is None else X_WG, frame)
    elif X_WG is not None:
        shape = _guidance.PlacedGeometry(shape, X_WG)
    made = (policy or POLICIES[c.policy]).make(ROLES[c.role], rise)
    return _guidance.Fixture(name, shape, ROLES[c.role].role, role, law_name or c.law, law_options, made, on)


class Bench:
    """A guidance stage with the fixture of a combination, or with given fixtures; it keeps them alive."""

    def __init__(
        self, c: Combination, *fixtures: _guidance.Fixture, quick: bool = False, damping: bool = False, **options: float
    ) -> None:
        """``quick`` disables the wrench's rate limit; with ``damping`` the master renders the damping itself."""
        o = _core.GuidanceOptions()
        o.servo_bandwidth = 0.0
        if quick:
            o.force_rate = o.moment_rate = 1e6
        for key, value in options.items():
            setattr(o, key, value)
        self.c, self.damping, self.ticks = c, damping, 0
        self.pedal, self.operator = PEDAL, OPERATOR
        self.stage = _guidance.Guidance(o, DT)
        self._tool: Array | None = None
        self.take(*(fixtures or [fixture(c)]))

    def take(self, *fixtures: _guidance.Fixture) -> None:
        """Replace the fixtures as a live edit does."""
        self._list = _guidance.Fixtures(list(fixtures))
        self.stage.take(self._list)

    def begin(self, there: Array, X_WG: Array | None = None) -> Bench:
        """Hold a satisfied pose near `there` (4, 4) for VISIT ticks if the policy has an engagement distance.

        X_WG: pose of the geometry, (4, 4) or (n, 4, 4).
        """
        if POLICIES[self.c.policy].engage is not None:
            good = constant_pose(satisfied_pose(self.c.role, self.c.geometry, there), VISIT)
            X = None if X_WG is None else X_WG if X_WG.ndim == 2 else X_WG[:VISIT]
            self.run(good if X is None else good.carried(X), X)
        return self

    def run(self, motion: Motion, X_WG: Array | None = None) -> Answer:
        """Continue along a motion; the touched ground moves with the geometry's pose X_WG (4, 4) or (n, 4, 4)."""
        n = len(motion.X)
        t = (DT * (self.ticks + np.arange(n))).tolist()
        self.ticks += n
        X, V = np.ascontiguousarray(motion.X), np.ascontiguousarray(motion.V)
        tool = motion.X[0] if self._tool is None else self._tool
        compute = partial(_guidance.run_guidance, self.stage, t, X, V, tool, F_hand=self.operator, pedal=self.pedal,
                          takes_damping=self.damping)  # fmt: skip
        if ROLES[self.c.role].touches:
            ground = np.broadcast_to(np.eye(4) if X_WG is None else X_WG, (n, 4, 4))
            normal = ground[0, :3, 2]
            out = compute(normal=normal, height=(ground[:, :3, 3] @ normal).tolist(), stiffness=TOUCHED)
        else:
            out = compute()
        F, B = out["F_T_W"], out["B_W"].reshape(n, 3, 3)
        F[:, :3] -= np.einsum("nij,nj->ni", B, V[:, :3])
        goals = out["X_WT_goal"].reshape(n, 4, 4)
        self._tool = goals[-1]
        return Answer(F, goals, B)


def constant_pose(X: Array, n: int, V: Array | None = None) -> Motion:
    """n ticks at one pose X (4, 4) with the reported twist V (6,)."""
    return Motion(np.repeat(X[None], n, axis=0), np.repeat((np.zeros(6) if V is None else V)[None], n, axis=0))


def constant_probe(probe: Probe, n: int) -> Motion:
    """n ticks at a probe's pose with its reported twist."""
    return constant_pose(probe.X, n, probe.V)


def between(a: Array, b: Array, n: int) -> Motion:
    """Motion from pose a to pose b in n ticks, with zero velocity at both ends."""
    u = np.linspace(0.0, 1.0, n)
    s = u**3 * (10.0 - 15.0 * u + 6.0 * u * u)
    return interpolate(a, b, s)


def interpolate(a: Array, b: Array, s: Array) -> Motion:
    """Poses between a and b at the fractions s (n,) of the path, with their twists."""
    X = np.repeat(np.eye(4)[None], len(s), axis=0)
    X[:, :3, 3] = a[:3, 3] + s[:, None] * (b[:3, 3] - a[:3, 3])
    turn = Slerp([0.0, 1.0], Rotation.from_matrix(np.stack([a[:3, :3], b[:3, :3]])))
    X[:, :3, :3] = turn(np.clip(s, 0.0, 1.0)).as_matrix()
    w = (Rotation.from_matrix(b[:3, :3]) * Rotation.from_matrix(a[:3, :3]).inv()).as_rotvec()
    rate = np.gradient(s, DT)
    return Motion(X, np.column_stack([rate[:, None] * (b[:3, 3] - a[:3, 3]), rate[:, None] * w]))
