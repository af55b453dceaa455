"""An independent check of a finished plan: dense samples, exact shapes, Coal's distances on the full meshes.

It shares neither the kinematics, nor the capsules, nor the culling nor the bounds of the checker that made the plan:
poses come from `palpate.Arm`, and boxes, cylinders and spheres of the arm's model stand for themselves.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from palpate.arrays import Array
from palpate.planning import geometry
from palpate.planning.problem import Problem
from palpate.planning.result import Plan

STEP = 2.5e-4  # largest motion of any point between two samples [m]
_MORE = 5e-4  # distances up to the clearance plus this are measured [m]


@dataclass(frozen=True)
class Verdict:
    """Result of the dense check."""

    samples: int
    largest_step: float  # motion of any point between two samples [m]
    smallest: float  # distance [m]; infinite if it exceeds the clearance asked for by 0.5 mm
    pair: tuple[str, str]
    violations: int  # samples nearer than the clearance asked for
    worst_rate: float  # largest ratio of speed, acceleration or jerk to its limit, at 1 kHz [-]


def verify(problem: Problem, plan: Plan, step: float = STEP) -> Verdict:
    """Check a plan at steps of any point of at most `step` [m], and its times at 1 kHz."""
    import coal

    parts = _parts(problem)
    poses, largest = _poses(problem, plan, step, parts)
    radii = np.array([part.radius for part in parts])
    asked, request, result = plan.clearance_asked, coal.DistanceRequest(), coal.DistanceResult()
    near, touch = coal.CollisionRequest(), coal.CollisionResult()
    distances = np.full(len(poses), np.inf)
    smallest, pair = np.inf, ("", "")
    for obstacle in problem.world.obstacles:
        low, high = obstacle.bounds_W
        p = poses[..., :3, 3]
        apart = np.linalg.norm(np.maximum(np.maximum(low - p, p - high), 0.0), axis=-1) - radii
        for k, i in np.argwhere(apart < asked + _MORE):
            if frozenset((parts[i].link, obstacle.name)) in problem.world.allowed:
                continue
            X = geometry.transform(poses[k, i, :3, :3], poses[k, i, :3, 3])
            near.security_margin = asked + _MORE + obstacle.solid.inflation
            touch.clear()
            if coal.collide(parts[i].solid, X, obstacle.solid.coal, obstacle.transform, near, touch) == 0:
                continue  # Coal excludes a pair within the margin faster than it measures the distance
            result.clear()
            value = coal.distance(parts[i].solid, X, obstacle.solid.coal, obstacle.transform, request, result)
            value -= obstacle.solid.inflation
            distances[k] = min(distances[k], value)
            if value < smallest:
                smallest, pair = float(value), (parts[i].name, obstacle.name)
    return Verdict(len(poses), largest, smallest, pair, int((distances < asked).sum()), worst_rate(plan))


@dataclass(frozen=True)
class _Part:
    """A part of the arm as its model describes it."""

    link: str
    solid: Any  # coal.CollisionGeometry
    X_link_part: Array  # (4, 4)
    radius: float  # of the sphere around it [m]
    name: str


def _parts(problem: Problem) -> list[_Part]:
    """All parts of the arm, and of what it holds."""
    import coal

    robot = problem.robot
    parts: list[_Part] = []
    held = {one.name for one in robot.attached}
    for body in robot.bodies:
        if body.kind != "capsules":
            solid, X = body.solid()
            X_link = np.asarray(np.linalg.inv(robot.kinematics.mount[body.link][1])) @ X
            box = np.abs(solid.bounds).max(axis=0)
            parts.append(_Part(body.link, solid.coal, X_link, float(np.linalg.norm(box)), body.name))
    given = {part.link for part in parts if part.name not in held}
    for part in robot.arm.visuals:
        if part.link in given or (given and not robot.arm.drawn):
            continue
        made = {"box": coal.Box, "cylinder": coal.Cylinder, "sphere": coal.Sphere}[part.shape](*part.size)
        half = {"box": np.array(part.size) / 2, "cylinder": np.array([part.size[0], part.size[-1] / 2]),
                "sphere": np.array(part.size)}[part.shape]  # fmt: skip
        parts.append(_Part(part.link, made, part.X_link_visual, float(np.linalg.norm(half)), part.link))
    return parts


def _poses(problem: Problem, plan: Plan, step: float, parts: list[_Part]) -> tuple[Array, float]:
    """Poses (N, P, 4, 4) of all parts along the plan, so dense that no corner moves by more than `step` [m]."""
    signs = np.array([[x, y, z, 3**0.5] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float) / 3**0.5
    corners = np.array([signs * [part.radius, part.radius, part.radius, 1.0] for part in parts])  # (P, 8, 4)
    found: list[Array] = []
    largest = 0.0
    for curve in plan.curves:
        count, moved = 64, np.inf
        while moved > step:
            q = curve.at(np.linspace(0.0, 1.0, count + 1))
            poses = _part_poses(problem, q, parts)
            places = np.einsum("kpij,pcj->kpci", poses, corners)[..., :3]
            moved = float(np.linalg.norm(np.diff(places, axis=0), axis=-1).max(initial=0.0))
            count = int(np.ceil(count * max(1.05, 1.02 * moved / step)))
        largest = max(largest, moved)
        found.append(poses)
    return np.concatenate(found), largest


def _part_poses(problem: Problem, q: Array, parts: list[_Part]) -> Array:
    """Poses X_Wpart (K, P, 4, 4) at q (K, n)."""
    robot = problem.robot
    names = list(dict.fromkeys(part.link for part in parts))
    rows = (robot.arm.link_poses(row, robot.jaw) for row in q)
    links = robot.X_WB @ np.array([[row[name] for name in names] for row in rows])
    return np.asarray(links[:, [names.index(part.link) for part in parts]] @ [part.X_link_part for part in parts])


def worst_rate(plan: Plan) -> float:
    """Largest ratio of speed, acceleration or jerk of a joint to its limit, by differences at 1 kHz [-]."""
    limits = plan.trajectory.limits
    dt = 1e-3
    t = np.arange(0.0, plan.trajectory.duration + dt, dt)
    q = plan.trajectory.at(t)[0]
    ratios = []
    for order, limit in ((1, limits.v), (2, limits.a), (3, limits.j)):
        change = np.diff(q, n=order, axis=0) / dt**order
        if len(change):
            ratios.append(float((np.abs(change) / limit).max()))
    return max(ratios, default=0.0)
