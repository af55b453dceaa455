"""Random routes between organs, other instruments and an endoscope: each is a plan that passes near something."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from palpate import _guidance
from palpate.base.arrays import Array, rigid
from palpate.base.errors import PalpateError
from palpate.planning.checker import Checker
from palpate.planning.problem import Problem
from palpate.planning.result import Plan, tip_path
from palpate.scene.guidance import from_yaml
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene

MARGIN = 3e-3
"""Clearance of the plans, and the margin that the operators should not enter [m]."""
SCALE = 0.5
"""Tool motion per hand motion [-]."""
NEAR = 4e-3
"""Plans that come no nearer to anything than this are left out: few operators would enter the margin on them [m]."""
STIFFNESSES = (200.0, 400.0, 700.0, 1000.0)
"""Springs to the path that the sweep compares; 1000 N/m is the default of `follow: {plan:}` [N/m]."""
_LOW, _HIGH = np.array([-0.09, -0.16, -0.04]), np.array([0.06, 0.02, 0.07])  # box of the tips in W [m]
_LENGTH = (0.04, 0.10)  # distance from start to target [m]
_SPACING = 5e-4  # of the points of a route [m]
_COARSE = 4  # every fourth of these is examined


@dataclass(frozen=True)
class Route:
    """A plan, the scene at its start, and the fixtures that lead along it."""

    rig: Rig
    problem: Problem
    plan: Plan
    path: Array  # (n, 3) planned positions of the tip in W [m]
    fixtures: dict[str, _guidance.Fixture]  # "plan", "plan 200" ...: springs to the path; "plan-tube": wall of the tube


@lru_cache
def routes(count: int, seed: int) -> tuple[Route, ...]:
    """The first `count` random routes with this seed; a route does not depend on the number of routes."""
    rng = np.random.default_rng(seed)
    found: list[Route] = []
    while len(found) < count:
        start = rng.uniform(_LOW, _HIGH)
        target = rng.uniform(_LOW, _HIGH)
        if _LENGTH[0] < np.linalg.norm(target - start) < _LENGTH[1]:
            route = route_between(start, target, seed)
            found += [route] if route is not None else []
    return tuple(found)


def route_between(start: Array, target: Array, seed: int = 0) -> Route | None:
    """The route from a start to a target (3,) [m] in one orientation; None if there is none, or it is far from all.

    Routes that a perfect operator could not follow are left out, too: where the tip cannot keep its orientation, where
    the instrument would then enter the margin, or where the master would need its clutch.
    """
    scene = Scene.load("planning")
    data = scene.model_dump(mode="json", exclude_unset=True)
    data |= {"operator": {"path": [{"t": 0.0, "xyz": start.tolist()}]}, "mapping": {"scale": SCALE},
             "rates": {"plant": 2000.0}, "stability": {"force_cap": 6.0}}  # fmt: skip
    try:
        rig = build(Scene.model_validate(data))
        problem = Problem.of(rig.scene, rig=rig)
        X_WT = rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0)
        X_WT[:3, 3] = target
        plan = problem.plan(rig.arms.q_follower0, X_WT, MARGIN, seed)
    except PalpateError:  # the start or the target lies in something, or cannot be reached
        return None
    if not plan.success or (plan.clearance_m or np.inf) > NEAR:
        return None
    arm = problem.robot.arm
    path = tip_path(plan, arm, _SPACING)[:, :3, 3]
    if not (_free_without_turning(problem, X_WT, path, rig.arms.q_follower0) and _within_reach(rig, path)):
        return None
    with TemporaryDirectory() as folder:
        file = Path(folder) / "plan.yaml"
        plan.save(file, arm)
        sections = {one.name: one for one in from_yaml(f"follow: {{plan: {file}}}")}
        spring = sections["plan"]
        for stiffness in STIFFNESSES:
            law = spring.law.model_copy(update={"stiffness": stiffness})
            sections[f"plan {stiffness:g}"] = spring.model_copy(update={"law": law})
        fixtures = {name: one.make(rig.context) for name, one in sections.items()}
    return Route(rig, problem, plan, path, fixtures)


def _free_without_turning(problem: Problem, X_WT: Array, path: Array, q: Array) -> bool:
    """True if the instrument keeps the margin while its tip follows the path (n, 3) [m] in one orientation."""
    arm, checker, X_BW = problem.robot.arm, Checker(problem.robot, problem.world), rigid.inverse(problem.robot.X_WB)
    for p in path[::_COARSE]:
        X_WT = X_WT.copy()
        X_WT[:3, 3] = p
        q, found = arm.ik_from(X_BW @ X_WT, q)
        if not found.converged or checker.refusal(q, MARGIN) is not None:
            return False
    return True


def _within_reach(rig: Rig, path: Array) -> bool:
    """True if the master reaches all of the path (n, 3) [m] without a clutch."""
    arm, q, R_WL = rig.arms.leader, rig.options(0).q_leader0, rig.arms.X_WL[:3, :3]
    X_LH0 = arm.fk(q)
    for p in path[::_COARSE]:
        X_LH = X_LH0.copy()
        X_LH[:3, 3] += R_WL.T @ (p - path[0]) / SCALE
        q, found = arm.ik_from(X_LH, q)
        if not found.converged:
            return False
    return True
