"""Explains in words the terms of one fixture's force. The core computes the numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.scene.guidance.sections import Law, Role

if TYPE_CHECKING:
    from palpate import _guidance

SMALL = 1e-9
"""Forces and constraint values below this are treated as zero [N, m]."""


@dataclass(frozen=True)
class FixtureResponse:
    """Response of a fixture: its constraint and its wrench for one state of the tool."""

    gap: float
    """Constraint value: negative by the amount of violation [m, or rad if rotational]; infinite when inactive."""
    turns: bool
    """True if the constraint is rotational."""
    speed: float
    """Speed limit [m/s]; infinite without a limit."""
    F: Array
    """(6,) wrench on the tool with full authority [N, N m], in W."""

    @classmethod
    def of(cls, core: _guidance.Fixture, X_WT: Array, V_WT: Array, t: float) -> Self:
        """The response to a tool at X_WT (4, 4) with the twist V_WT (6,) [m/s, rad/s]."""
        constraint = core.evaluate(X_WT, t, V_WT)
        return cls(
            float(constraint["gap"]), bool(constraint["turns"]), float(constraint["speed"]), np.asarray(constraint["F"])
        )

    @property
    def acting(self) -> Array:
        """(3,) force [N], or the moment [N m] of a rotational constraint."""
        return self.F[3:] if self.turns else self.F[:3]


def reasons(
    core: _guidance.Fixture, role: Role, law: Law, X_WT: npt.ArrayLike, V_WT: npt.ArrayLike | None, t: float
) -> str:
    """Describe the effect of a single fixture on a tool: its constraint, the constraint's state, and the force terms.

    Args:
        core: the fixture, made from `role` and `law`.
        X_WT: (4, 4) pose of the tool, or its position (3,) [m].
        V_WT: (6,) velocity of the tool over its angular velocity, in W [m/s, rad/s]; zero when None.
        t: time [s].
    """
    X = np.array(X_WT, dtype=np.float64)
    if X.shape == (3,):
        p, X = X, np.eye(4)
        X[:3, 3] = p
    moving = FixtureResponse.of(core, X, np.zeros(6) if V_WT is None else np.array(V_WT, dtype=np.float64), t)
    policy = core.policy
    lines = [f"{core.name} ({role.name}, law {law.name}, {'hard' if policy.hard else 'soft'}):"]
    lines += [f"  {line}" for line in _lines(role, law, moving, FixtureResponse.of(core, X, np.zeros(6), t))]
    if not core.on:
        lines.append("  the fixture is switched off: it applies none of this")
    elif policy.authority < 1.0:
        given, unit = policy.authority * float(np.linalg.norm(moving.acting)), "N m" if moving.turns else "N"
        lines.append(f"  its authority is {policy.authority:g}: the hand is given {given:.3g} {unit}")
    return "\n".join(lines)


def _lines(role: Role, law: Law, moving: FixtureResponse, still: FixtureResponse) -> list[str]:
    """Lines on state and force; `moving` and `still` are the core's answers for the moving and the resting tool."""
    if not np.isfinite(moving.gap):
        limit = f"; the tool may move at {moving.speed:g} m/s" if np.isfinite(moving.speed) else ""
        return [f"no constraint is active here{limit}"]
    F = moving.acting
    return [_state(role, moving.gap, moving.turns), *_terms(law, F, F - still.acting, moving.turns)]


def _state(role: Role, gap: float, turns: bool) -> str:
    size = f"{np.degrees(abs(gap)):.3g} deg" if turns else f"{1e3 * abs(gap):.3g} mm"
    margin = f" its margin of {1e3 * role.margin:g} mm" if role.margin > 0.0 else ""
    violated = {
        "guide": f"the tool is {size} off{' beyond' + margin if margin else ''}",
        "forbid": f"the tool is {size} inside{margin or ' it'}",
        "keep-in": f"the tool is {size} outside{' of' + margin if margin else ''}",
        "orient": f"the attitude of the tool is {size} off",
        "limit": f"the tool is {size} beyond the limit",
        "rcm": f"the shaft passes the place at a distance of {size}",
    }
    satisfied = {
        "guide": "the tool is on it",
        "forbid": f"the tool is {size} away from{margin or ' it'}",
        "keep-in": f"the tool is inside, {size} from{margin or ' its border'}",
        "orient": "the tool has the required attitude",
        "limit": f"the limit is {size} away",
        "rcm": "the shaft passes through the place",
    }
    return (violated if gap < -SMALL else satisfied)[role.name]


def _terms(law: Law, F: Array, F_B: Array, turns: bool) -> list[str]:
    unit = "N m" if turns else "N"
    total = float(np.linalg.norm(F))
    if total < SMALL:
        return ["no force"]
    damping = float(np.linalg.norm(F_B))
    spring = float(np.linalg.norm(F - F_B))
    K, B = (law.turning_stiffness, law.turning_damping) if turns else (law.stiffness, law.damping)
    per = "N m/rad" if turns else "N/m"
    lines = [f"spring: {spring:.3g} {unit}, at {K:g} {per}"] if spring > SMALL else []
    if damping > SMALL:
        against = ", against the total" if float(F_B @ F) < 0.0 else ""
        lines.append(f"damping: {damping:.3g} {unit}, at {B:g} {per.replace('/', ' s/')}{against}")
    direction = ", ".join(f"{x:+.2f}" for x in F / total)
    largest = "damping" if damping > spring else "the spring"
    return [*lines, f"together {total:.3g} {unit} along ({direction}) in W; most of it is {largest}"]
