"""Is a plan what its file claims? A file may be old, edited, or of another arm: nothing in it is taken on trust.

The limits, the metric, the joints and the base of a motion are those of the problem's own arm; a plan that differs is
refused. Its curves must join and stay within the joints' ranges. The proof that its way is free is made anew
(`palpate.planning.ahead`), as the version of the world in a file proves nothing.
"""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array, rigid
from palpate.base.errors import PlanningError
from palpate.planning.planners import levers
from palpate.planning.problem import Problem
from palpate.planning.result import Plan
from palpate.planning.verify import worst_rate

JOIN = 1e-6
"""Largest gap between two curves of a plan [rad, m]: a file keeps all digits."""
_SAME = 1e-6  # largest relative difference between a number of the file and the arm's [-]
_BASE = (1e-4, 1e-3)  # largest displacement [m] and rotation [rad] between the base of the plan and the scene's
_RATE = 1.02  # largest ratio of a joint's speed, acceleration or jerk to its limit, found by differences at 1 kHz [-]


def require_sound(problem: Problem, plan: Plan) -> None:
    """Refuse a plan that its own arm could not or must not execute.

    Raises:
        PlanningError: the message names what differs, with both values.
    """
    robot, arm = problem.robot, problem.robot.arm
    again = "plan again: palpate plan SCENE ... --out FILE"
    if tuple(plan.joint_names) != tuple(arm.joint_names):
        ours, theirs = ", ".join(arm.joint_names), ", ".join(plan.joint_names)
        raise PlanningError(f"the plan moves the joints {theirs}", why=f"{robot.name} has {ours}", mend=again)
    _require_joined(plan, arm.n)
    for k, curve in enumerate(plan.curves):
        low, high = curve.controls.min(axis=0), curve.controls.max(axis=0)  # a Bezier curve stays in their hull
        for joint, name in enumerate(arm.joint_names):
            least, most = float(arm.q_min[joint]), float(arm.q_max[joint])
            if low[joint] < least - JOIN or high[joint] > most + JOIN:
                raise PlanningError(
                    f"part {k + 1} of the plan leads {name} to {low[joint]:.4g} ... {high[joint]:.4g}",
                    why=f"its range is {least:.4g} ... {most:.4g} rad or m", mend=again,
                )  # fmt: skip
    _require_own_numbers(problem, plan)
    moved, turned = apart(robot.X_WB, plan.X_WB)
    if not (moved <= _BASE[0] and turned <= _BASE[1]):
        raise PlanningError(
            f"the plan has the base of {robot.name} {1e3 * moved:.1f} mm and {np.degrees(turned):.1f} deg from where "
            "the scene has it", mend="plan again in this scene",
        )  # fmt: skip
    if not (np.isfinite(plan.clearance_asked) and plan.clearance_asked >= 0.0):
        raise PlanningError(f"the plan asks for a clearance of {1e3 * plan.clearance_asked:g} mm", mend=again)
    worst = worst_rate(plan)
    if not worst <= _RATE:
        raise PlanningError(f"a joint would move at {worst:.2f} times its limit of speed, acceleration or jerk",
                            mend=again)  # fmt: skip


def apart(X_A: Array, X_B: Array) -> tuple[float, float]:
    """Displacement [m] and angle [rad] between two poses (4, 4)."""
    X = rigid.inverse(X_A) @ X_B
    return float(np.linalg.norm(X[:3, 3])), float(np.arccos(np.clip((np.trace(X[:3, :3]) - 1.0) / 2.0, -1.0, 1.0)))


def _require_joined(plan: Plan, n: int) -> None:
    """Refuse a path with gaps."""
    for k, (one, two) in enumerate(zip(plan.curves[:-1], plan.curves[1:], strict=True)):
        gap = np.abs(two.controls[0] - one.controls[-1])
        if not gap.max() <= JOIN:
            joint = int(np.argmax(np.where(np.isfinite(gap), gap, np.inf)))
            raise PlanningError(
                f"parts {k + 1} and {k + 2} of the plan do not join: {plan.joint_names[joint]} would jump by "
                f"{gap[joint]:.4g} rad or m",
                why="the file was changed after the plan was made", mend="plan again",
            )  # fmt: skip
    if any(curve.controls.shape[1] != n for curve in plan.curves):
        raise PlanningError("a part of the plan has another number of joints than the arm", mend="plan again")


def _require_own_numbers(problem: Problem, plan: Plan) -> None:
    """Refuse limits above the arm's, and another metric of the path than the arm's."""
    assert plan.limits is not None
    names = problem.robot.arm.joint_names
    rows = ((plan.limits.v, problem.limits.v, "speed", "/s"), (plan.limits.a, problem.limits.a, "acceleration", "/s^2"),
            (plan.limits.j, problem.limits.j, "jerk", "/s^3"))  # fmt: skip
    for mine, limit, what, unit in rows:
        joint = _above(mine, limit)
        if joint is not None:
            raise PlanningError(
                f"the plan moves {names[joint]} with a {what} of up to {float(mine[joint]):.4g} rad or m {unit}",
                why=f"in this scene the arm's limit is {float(limit[joint]):.4g} (planning.speed times its own)",
                mend="plan again, or raise planning.speed in the scene",
            )  # fmt: skip
    scale = levers(problem.robot.arm)
    if plan.scale.shape != scale.shape or not np.allclose(plan.scale, scale, rtol=_SAME, atol=_SAME):
        raise PlanningError("the plan measures its path by another arm's lengths (key scale)", mend="plan again")


def _above(values: Array, limits: Array) -> int | None:
    """The joint (index) whose value is not in 0 < value <= limit; None if all are."""
    if values.shape != limits.shape:
        return 0
    bad = ~((values > 0.0) & (values <= limits * (1.0 + _SAME)))
    return int(np.argmax(bad)) if bad.any() else None
