"""Reference constraints of all roles in numpy, written from the documentation; gradients by finite differences.

A role is a one-sided constraint: it is satisfied while its gap is not negative [m; rad for roles that rotate the tool].
The gradient of the gap with respect to the tool pose (linear over angular, about the tip) is the wrench's direction.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from palpate import _guidance
from palpate.base.arrays import Array
from palpate_lab.verify.conformance.laws import LAWS
from palpate_lab.verify.conformance.specimens import SPECIMENS, Specimen

Gap = Callable[[Specimen, Array], float]

H = 1e-6
"""Step of the finite differences [m, rad]."""
LEVER = 0.05
"""Length that converts angles to distances for comparison [m/rad]."""

FREE, MARGIN, KEPT, TILT, TROCAR = 0.0005, 0.004, 0.001, 0.05, 0.0005
FAR = 0.03
"""Margin of limits; all probes lie within the region of such a limit [m]."""
AROUND = 0.01
"""Step of the central differences for the mean normal of the role `orient` [m]."""
SPEED = 0.02
"""Speed limit [m/s]."""
FORCE, TOUCHED = 2.0, 1000.0
"""Force limit [N]; stiffness of the touched ground z = 0 [N/m]."""


def slope(f: Callable[[Array], Array], p: Array, h: float = H) -> Array:
    """Gradient (3,) of the function f (n, 3) -> (n,) at p (3,)."""
    steps = np.concatenate([np.eye(3), -np.eye(3)]) * h
    d = f(p + steps)
    return np.asarray((d[:3] - d[3:]) / (2.0 * h))


def nearest(specimen: Specimen, p: Array) -> Array:
    """The geometry's point (3,) nearest to p (3,), from the distance and its gradient."""
    d = float(specimen.distance(p[None])[0])
    n = slope(specimen.distance, p)
    return np.asarray(p - d * n / np.linalg.norm(n))


def angle(X: Array, Y: Array) -> float:
    """Angle between the orientations of two poses or rotations [rad]."""
    return float(Rotation.from_matrix(X[:3, :3].T @ Y[:3, :3]).magnitude())


def _between(a: Array, b: Array) -> float:
    side = a[[1, 2, 0]] * b[[2, 0, 1]] - a[[2, 0, 1]] * b[[1, 2, 0]]  # numpy.cross, but several times as fast
    return float(np.arctan2(np.sqrt(side @ side), a @ b))


def _distance(s: Specimen, X: Array) -> float:
    return float(s.distance(X[None, :3, 3])[0])


def _orient_normal(s: Specimen, X: Array) -> float:
    n = slope(s.distance, X[:3, 3], AROUND)
    return TILT - float(np.linalg.norm(n)) * _between(X[:3, 2], -n)


def _orient_frame(s: Specimen, X: Array) -> float:
    return TILT - angle(X, s.attitude(X[:3, 3]))


def _rcm(s: Specimen, X: Array) -> float:
    to = nearest(s, X[:3, 3]) - X[:3, 3]
    a = X[:3, 2]
    return TROCAR - float(np.linalg.norm(to - a * (a @ to)))


@dataclass(frozen=True)
class RoleCase:
    """A role with the options of its check."""

    role: str
    options: Mapping[str, float | str]
    """Options of the role by the names of the core."""
    gap: Gap
    attracts: bool = False
    turns: bool = False
    needs_solid: bool = False
    needs_point: bool = False
    needs_axis: bool = False
    touches: bool = False
    """True if the tool touches the elastic ground z = 0 of the geometry's frame."""
    speed: bool = False
    """True if the role limits the tool's speed and does not constrain its pose."""


#: Cases by name; each role of the core has at least one case.
ROLES: dict[str, RoleCase] = {
    "guide": RoleCase("guide", {"margin": FREE}, lambda s, X: FREE - abs(_distance(s, X)), attracts=True),
    "forbid": RoleCase("forbid", {"margin": MARGIN}, lambda s, X: _distance(s, X) - MARGIN),
    "forbid, no margin": RoleCase("forbid", {}, _distance, needs_solid=True),
    "keep-in": RoleCase("keep-in", {"margin": KEPT}, lambda s, X: -_distance(s, X) - KEPT, needs_solid=True),
    "limit of the workspace": RoleCase("limit", {}, lambda s, X: -_distance(s, X), needs_solid=True),
    "limit of force": RoleCase("limit", {"margin": FAR, "force": FORCE},
                               lambda s, X: FORCE / TOUCHED - max(-float(X[2, 3]), 0.0), touches=True),
    "limit of speed": RoleCase("limit", {"margin": FAR, "speed": SPEED}, lambda s, X: np.inf, speed=True),
    "orient along the axis": RoleCase("orient", {"angle": TILT},
                                      lambda s, X: TILT - _between(X[:3, 2], s.axis(X[:3, 3])),
                                      attracts=True, turns=True, needs_axis=True),
    "orient against the normal": RoleCase("orient", {"angle": TILT, "target": "normal"}, _orient_normal, attracts=True,
                                          turns=True),
    "orient as the frame": RoleCase("orient", {"angle": TILT, "target": "frame"}, _orient_frame, attracts=True,
                                    turns=True),
    "rcm": RoleCase("rcm", {"margin": TROCAR}, _rcm, attracts=True, needs_point=True),
}  # fmt: skip


WITHOUT_AXIS = {"point", "sphere", "cloud", "union", "intersection", "difference", "placed"}
"""Specimens without a distinguished axis; those after the cloud consist of balls."""


def gradient(case: RoleCase, s: Specimen, X: Array, n: int = 6) -> Array:
    """Gradient of the gap with respect to the tool pose, its first n of six components.

    An orientation target may depend on the position.
    """
    h = 1e-5 if case.turns else H  # a larger step limits rounding errors of the nested differences
    steps = h * np.eye(6)[:n]
    return np.array([case.gap(s, moved(X, y)) - case.gap(s, moved(X, -y)) for y in steps]) / (2.0 * h)


def moved(X: Array, y: Array) -> Array:
    """Pose X (4, 4) displaced by y (6,), rotated about its own origin."""
    out = X.copy()
    out[:3, 3] += y[:3]
    if y[3:].any():
        out[:3, :3] = Rotation.from_rotvec(y[3:]).as_matrix() @ X[:3, :3]
    return out


def unjudged() -> list[str]:
    """Roles and laws of the core without a reference here."""
    roles = {case.role for case in ROLES.values()}
    return [r for r in _guidance.guidance_roles() if r not in roles] + [
        n for n in _guidance.guidance_laws() if n not in LAWS
    ]


def meaningless(role: str, geometry: str) -> str:
    """Reason why a role is meaningless with a geometry; empty if it is meaningful."""
    if ROLES[role].needs_solid and not SPECIMENS[geometry].solid:
        return f"a {geometry} has no inside, and {role} needs one"
    if ROLES[role].needs_point and geometry != "point":
        return f"a {geometry} is no point, and {role} is about one"
    if ROLES[role].needs_axis and geometry in WITHOUT_AXIS:
        return f"a {geometry} has no axis that a person would name, and {role} needs one"
    return ""
