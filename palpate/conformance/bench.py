"""The stage `guidance` on a bench: a fixture, a motion of the hand, what comes out of every tick."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from palpate import _core
from palpate.conformance.combinations import OPERATOR, PEDAL, POLICIES, Combination
from palpate.conformance.judges import LAWS, ROLES
from palpate.conformance.specimens import SPECIMENS

Array = NDArray[np.float64]

DT = 1e-3
FORCE_RATE, MOMENT_RATE, RETURN_SPEED, RESERVE = 20.0, 0.35, 0.05, 5e-5
"""As the stage's defaults: what it may change beside what motions explain, and where hard fixtures keep the goal."""


@dataclass(frozen=True)
class Motion:
    """Goals of the hand, tick by tick."""

    X: Array
    """(n, 4, 4)."""
    V: Array
    """(n, 6) linear over angular, in W."""

    @cached_property
    def way(self) -> Array:
        """(n - 1, 6) from tick to tick: shift over rotation vector."""
        R = Rotation.from_matrix(self.X[:, :3, :3])
        return np.column_stack([np.diff(self.X[:, :3, 3], axis=0), (R[1:] * R[:-1].inv()).as_rotvec()])


@dataclass(frozen=True)
class Answer:
    """What came out."""

    F: Array
    """(n, 6) on the tool."""
    X: Array
    """(n, 4, 4) goal."""


def fixture(
    c: Combination,
    name: str = "f",
    X_WG: Array | None = None,
    frame: _core.Frame | None = None,
    law: dict[str, Any] | None = None,
    on: bool = True,
    geometry: _core.Geometry | None = None,
) -> _core.Fixture:
    """A combination for the core, its geometry at X_WG or in a frame, some of its law's options changed."""
    role, law_options = _core.GuidanceRoleOptions(), _core.GuidanceLawOptions()
    for key, value in ROLES[c.role].options.items():
        setattr(role, key, value)
    for key, value in (LAWS[c.law].options | (law or {})).items():
        setattr(law_options, key, value)
    shape = geometry or SPECIMENS[c.geometry].make()
    if frame is not None:
        shape = _core.PlacedGeometry(shape, np.eye(4), frame)
    elif X_WG is not None:
        shape = _core.PlacedGeometry(shape, X_WG)
    policy = POLICIES[c.policy].make(ROLES[c.role].turns)
    return _core.Fixture(name, shape, ROLES[c.role].role, role, c.law, law_options, policy, on)


class Bench:
    """One stage; it keeps what it is given alive."""

    def __init__(self, *fixtures: _core.Fixture, quick: bool = False) -> None:
        """quick: the wrench follows at once, so that a pose's answer needs few ticks."""
        options = _core.GuidanceOptions()
        options.servo_bandwidth = 0.0
        if quick:
            options.force_rate = options.moment_rate = 1e6
        self.stage = _core.Guidance(options, DT)
        self._ticks = 0
        self.take(*fixtures)

    def take(self, *fixtures: _core.Fixture) -> None:
        """A live edit."""
        self._list = _core.Fixtures(list(fixtures))
        self.stage.take(self._list)

    def run(self, motion: Motion) -> Answer:
        """Goes on along a motion."""
        n = len(motion.X)
        t = (DT * (self._ticks + np.arange(n))).tolist()
        self._ticks += n
        X, V = np.ascontiguousarray(motion.X), np.ascontiguousarray(motion.V)
        out = _core.run_guidance(self.stage, t, X, V, F_hand=OPERATOR, pedal=PEDAL)
        return Answer(out["F_T_W"], out["X_WT_goal"].reshape(n, 4, 4))


def still(X: Array, n: int) -> Motion:
    """n ticks at one pose."""
    return Motion(np.repeat(X[None], n, axis=0), np.zeros((n, 6)))


def between(a: Array, b: Array, n: int) -> Motion:
    """From pose a to pose b in n ticks, at rest at both ends."""
    u = np.linspace(0.0, 1.0, n)
    s = u**3 * (10.0 - 15.0 * u + 6.0 * u * u)
    return along(a, b, s)


def along(a: Array, b: Array, s: Array) -> Motion:
    """Poses a share s (n,) of the way from a to b, with their velocities."""
    X = np.repeat(np.eye(4)[None], len(s), axis=0)
    X[:, :3, 3] = a[:3, 3] + s[:, None] * (b[:3, 3] - a[:3, 3])
    turn = Slerp([0.0, 1.0], Rotation.from_matrix(np.stack([a[:3, :3], b[:3, :3]])))
    X[:, :3, :3] = turn(np.clip(s, 0.0, 1.0)).as_matrix()
    w = (Rotation.from_matrix(b[:3, :3]) * Rotation.from_matrix(a[:3, :3]).inv()).as_rotvec()
    rate = np.gradient(s, DT)
    return Motion(X, np.column_stack([rate[:, None] * (b[:3, 3] - a[:3, 3]), rate[:, None] * w]))
