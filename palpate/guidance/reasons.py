"""Explains in words the terms of one fixture's force. The core computes the numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.arrays import Array
from palpate.guidance.sections import Law, Role

SMALL = 1e-9
"""Forces and constraint values below this are treated as zero [N, m]."""


def reasons(
    core: _core.Fixture, role: Role, law: Law, X_WT: npt.ArrayLike, V_WT: npt.ArrayLike | None, t: float
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
    moving = core.ask(X, t, np.zeros(6) if V_WT is None else np.array(V_WT, dtype=np.float64))
    policy = core.policy
    lines = [f"{core.name} ({role.name}, law {law.name}, {'hard' if policy.hard else 'soft'}):"]
    lines += [f"  {line}" for line in _lines(role, law, moving, core.ask(X, t, np.zeros(6)))]
    if not core.on:
        lines.append("  the fixture is switched off: it applies none of this")
    elif policy.authority < 1.0:
        part = np.asarray(moving["F"])[3:] if moving["turns"] else moving["F"][:3]
        given, unit = policy.authority * float(np.linalg.norm(part)), "N m" if moving["turns"] else "N"
        lines.append(f"  its authority is {policy.authority:g}: the hand is given {given:.3g} {unit}")
    return "\n".join(lines)


def _lines(role: Role, law: Law, moving: dict[str, Any], still: dict[str, Any]) -> list[str]:
    """Lines on state and force; `moving` and `still` are the core's answers for the moving and the resting tool."""
    gap, turns = float(moving["gap"]), bool(moving["turns"])
    if not np.isfinite(gap):
        limit = f"; the tool may move at {moving['speed']:g} m/s" if np.isfinite(moving["speed"]) else ""
        return [f"no constraint is active here{limit}"]
    part = slice(3, 6) if turns else slice(0, 3)
    F, F_still = np.asarray(moving["F"])[part], np.asarray(still["F"])[part]
    return [_state(role, gap, turns), *_terms(law, F, F - F_still, turns)]


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
