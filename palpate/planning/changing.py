"""Plans in a world that changes while they are searched for: moving organs, clouds of sensors, an edited scene."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from palpate.planning.checker import Checker
from palpate.planning.problem import Problem
from palpate.planning.result import Plan
from palpate.planning.world import World

PROVED_AGAIN = "the scene changed during the search; the plan was proved again in the new one"
"""Note of a plan that was found in another world than the one in which it is returned."""
SEARCHED_AGAIN = "the scene changed during the search, which began again"
"""Note of a plan whose predecessor is not free in the newest world."""


def plan(
    problem: Problem, world: Callable[[], World], search: Callable[[Problem, float], Plan], timeout: float
) -> Plan:
    """A plan that is free in the newest world.

    A plan found in an older world is proved again; where it is not free any more, the search begins again in the time
    that is left. Without time left, the result has no success, and its reason names the pair that comes too near.

    Args:
        problem: the problem, in any world.
        world: returns the present world; of a session, `LiveWorld(problem, session.rig).at(session.latest())`.
        search: searches a problem for a time [s], e.g. `lambda now, left: now.plan(start, goal, timeout=left)`.
        timeout: of everything [s].

    Raises:
        PlanningError: as for `Problem.plan`, also when start or goal is not free in the newest world.
    """
    begin = time.monotonic()
    now = problem.with_world(world())
    notes: list[str] = []
    found = search(now, timeout)
    while found.success and (newest := world()).version != now.world.version:
        now = problem.with_world(newest)
        found, why = _proved(now, found)
        if not why:
            notes = notes or [PROVED_AGAIN]
            continue
        left = timeout - (time.monotonic() - begin)
        if left <= 0.0:
            reason = f"the scene changed during the search, and {why}; no time of {timeout:g} s is left to search again"
            return now.failed(now.empty_plan(found.clearance_asked, found.seed, found.planner), reason, begin=begin)
        notes = [SEARCHED_AGAIN]
        found = search(now, left)
    return replace(found, notes=(*found.notes, *notes), time_s=time.monotonic() - begin)


def _proved(problem: Problem, found: Plan) -> tuple[Plan, str]:
    """The plan with its clearance in the problem's world; or unchanged, and why it is not free there."""
    checker = Checker(problem.robot, problem.world)
    for curve in found.curves:
        blocked = checker.blocked(curve, found.clearance_asked)
        if blocked is not None:
            pair = " and ".join(blocked.pair)
            return found, f"{pair} come nearer than {1e3 * found.clearance_asked:g} mm on the path that was found"
    base = problem.empty_plan(found.clearance_asked, found.seed, found.planner)
    return problem.finished(base, checker, list(found.curves), time.monotonic()), ""
