"""OMPL's planners on the checker's proofs: no edge enters a tree unless the whole motion is proved free."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.base.errors import PlanningError
from palpate.planning.checker import Checker
from palpate.planning.curves import line
from palpate.planning.robot import Robot

#: Planners of OMPL that can be chosen; the first is the default. docs/planning.md shows the measurement.
PLANNERS = ("RRTConnect", "LBKPIECE1", "BKPIECE1", "KPIECE1", "RRT", "BITstar")
STRAIGHT = "straight line"
RETRACT = "retract, pivot, insert"
_DEPTHS = (0.8, 0.6, 0.4, 0.2, 0.05)  # insertions to which an instrument retracts, of the shallower of start and goal
_RANGE = 0.06  # longest edge of a tree, as motion of the tip [m]
_LEAST = 0.02  # lever of a joint whose axis passes through the tip [m]


@dataclass
class Search:
    """Result of a search: way points (k, n), or None; the planner; and how often each pair blocked an edge."""

    waypoints: Array | None
    planner: str
    blocked: Counter[tuple[str, str]] = field(default_factory=Counter)
    edges: int = 0

    @property
    def blocker(self) -> tuple[str, str]:
        """The pair that blocked most edges."""
        return self.blocked.most_common(1)[0][0] if self.blocked else ("", "")


def levers(arm: Arm) -> Array:
    """Motion of the tip per motion of each joint (n,) [m/rad, 1]: the metric of all paths."""
    kin = [arm.jacobian(q)[:3] for q in (arm.home, 0.5 * (arm.home + arm.q_max))]
    return np.asarray(np.maximum(np.abs([np.linalg.norm(J, axis=0) for J in kin]).max(axis=0), _LEAST))


def search(
    checker: Checker,
    start: Array,
    goals: Sequence[Array],
    clearance: float,
    seed: int,
    deadline: float,
    planner: str = PLANNERS[0],
) -> Search:
    """Way points of a free motion from `start` (n,) to one of `goals`, each step a straight line of the joints.

    deadline: time.monotonic() at which the search gives up [s]. The same seed gives the same way points.

    Raises:
        PlanningError: there is no such planner.
    """
    if planner not in PLANNERS:
        raise PlanningError(f"there is no planner {planner!r}", mend=f"the planners are {', '.join(PLANNERS)}")
    blocked: Counter[tuple[str, str]] = Counter()
    for goal in goals:
        found = checker.blocked(line(start, goal), clearance)
        if found is None:
            return Search(np.stack([start, goal]), STRAIGHT, blocked, 1)
        blocked[found.pair] += 1
        if time.monotonic() > deadline:
            return Search(None, STRAIGHT, blocked, 1)
    for goal in goals:
        waypoints = retracting(checker, start, goal, clearance, deadline)
        if waypoints is not None:
            return Search(waypoints, RETRACT, blocked, 1)
    return _with_ompl(checker, start, goals, clearance, seed, deadline, planner, blocked)


def retracting(checker: Checker, start: Array, goal: Array, clearance: float, deadline: float) -> Array | None:
    """Way points (k, n) that retract along the trocar's axis, pivot, and insert again; None if no depth is free.

    Surgeons change places like this. A search among random joint positions hardly finds the way out of a window that
    is little wider than the shaft, because it would have to move the insertion alone.
    """
    slides = retreat_joint(checker.robot)
    if slides is None:
        return None
    low = float(checker.robot.arm.q_min[slides])
    legs: list[list[Array]] = [_straightened(checker, q, slides, clearance) for q in (start, goal)]
    for part in _DEPTHS:
        if time.monotonic() > deadline:
            return None
        out, over = legs[0][-1].copy(), legs[1][-1].copy()
        out[slides] = over[slides] = low + part * (min(out[slides], over[slides]) - low)
        steps = ((out, over), (legs[0][-1], out), (over, legs[1][-1]))
        if all(checker.free_line(a, b, clearance) for a, b in steps):
            return np.stack([*legs[0], out, over, *reversed(legs[1])])
    return None


def _straightened(checker: Checker, q: Array, slides: int, clearance: float) -> list[Array]:
    """q, and q with a straight wrist if the motion there is free: a bent wrist does not pass a narrow window."""
    straight = q.copy()
    straight[slides + 2 :] = checker.robot.arm.home[slides + 2 :]  # behind the joint that rolls the shaft
    return [q, straight] if np.abs(straight - q).max() > 0 and checker.free_line(q, straight, clearance) else [q]


def retreat_joint(robot: Robot) -> int | None:
    """The joint that moves the instrument along its trocar; None for arms without a remote centre."""
    if not robot.arm.has_remote_centre:
        return None
    return next((joint.source for joint in robot.kinematics.joints if not joint.turns), None)


def _with_ompl(
    checker: Checker,
    start: Array,
    goals: Sequence[Array],
    clearance: float,
    seed: int,
    deadline: float,
    planner: str,
    blocked: Counter[tuple[str, str]],
) -> Search:
    import ompl.base as ob
    import ompl.geometric as og
    from ompl import util

    util.noOutputHandler()  # the seed is set before each search, of which OMPL warns
    util.RNG.setSeed(seed + 1)
    space = _Space(checker, clearance, deadline, blocked)
    problem = ob.ProblemDefinition(space.info)
    problem.addStartState(space.state(start))
    targets = ob.GoalStates(space.info)
    for goal in goals:
        targets.addState(space.state(goal))
    problem.setGoal(targets)
    made = getattr(og, planner)(space.info)
    if hasattr(made, "setRange"):
        made.setRange(_RANGE)
    made.setProblemDefinition(problem)
    made.setup()
    made.solve(ob.PlannerTerminationCondition(lambda: time.monotonic() > deadline or problem.hasExactSolution()))
    if not problem.hasExactSolution():
        return Search(None, planner, blocked, space.edges)
    path = problem.getSolutionPath()
    waypoints = np.array([space.joints(path.getState(i)) for i in range(path.getStateCount())])
    waypoints[0] = start
    waypoints[-1] = min(goals, key=lambda goal: float(np.abs(goal - waypoints[-1]).max()))
    return Search(waypoints, planner, blocked, space.edges)


class _Space:
    """The joints as a space of OMPL, scaled to the motion of the tip, with the checker's proofs as edges."""

    def __init__(self, checker: Checker, clearance: float, deadline: float, blocked: Counter[tuple[str, str]]) -> None:
        import ompl.base as ob

        arm = checker.robot.arm
        self._arm, self._scale = arm, levers(arm)
        self._count = count = [0]
        scale = self._scale

        class Validator(ob.MotionValidator):  # type: ignore[misc]  # holds no reference to OMPL's objects: no cycle
            def checkMotion(self, a: object, b: object, *_: object) -> bool:
                if time.monotonic() > deadline:
                    return False
                count[0] += 1
                found = checker.blocked(line(_joints(a, scale), _joints(b, scale)), clearance)
                if found is not None:
                    blocked[found.pair] += 1
                return found is None

        space, bounds = ob.RealVectorStateSpace(arm.n), ob.RealVectorBounds(arm.n)
        for i in range(arm.n):
            bounds.setLow(i, float(self._scale[i] * arm.q_min[i]))
            bounds.setHigh(i, float(self._scale[i] * arm.q_max[i]))
        space.setBounds(bounds)
        self.info = ob.SpaceInformation(space)
        self.info.setStateValidityChecker(lambda state: True)  # edges prove their ends, too
        self._validator = Validator(self.info)
        self.info.setMotionValidator(self._validator)
        self.info.setup()

    @property
    def edges(self) -> int:
        """Number of motions checked."""
        return self._count[0]

    def joints(self, state: object) -> Array:
        """Joint positions (n,) of a state."""
        return _joints(state, self._scale)

    def state(self, q: Array) -> object:
        """A state of joint positions (n,)."""
        made = self.info.allocState()
        for i, value in enumerate(np.clip(q, self._arm.q_min, self._arm.q_max) * self._scale):
            made[i] = float(value)
        return made


def _joints(state: object, scale: Array) -> Array:
    return np.array([state[i] for i in range(len(scale))]) / scale  # type: ignore[index]
