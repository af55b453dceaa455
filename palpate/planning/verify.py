"""An independent check of a finished plan: dense samples, exact shapes, Coal's distances on the full meshes.

It shares neither the kinematics, nor the capsules, nor the culling nor the bounds of the checker that made the plan:
poses come from `palpate.Arm`, and boxes, cylinders and spheres of the arm's model stand for themselves.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.planning import geometry
from palpate.planning.allowed import disabled_pairs
from palpate.planning.problem import Problem
from palpate.planning.result import Plan

STEP = 2.5e-4  # largest motion of any point between two samples [m]
_OWN_STRIDE = 10  # every such sample is examined for contact of the instrument with itself
_JAWS = 5  # angles of jaws that open and close during the motion
_MORE = 5e-4  # distances up to the clearance plus this are measured [m]


@dataclass(frozen=True)
class Verdict:
    """Result of the dense check."""

    samples: int
    largest_step: float  # motion of any point between two samples [m]
    smallest: float  # distance [m]; infinite if it exceeds the clearance asked for by 0.5 mm
    pair: tuple[str, str]
    violations: int  # samples nearer than the clearance asked for
    own_contacts: int  # samples in which the instrument touches itself, every tenth examined
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
    own = _own_contacts(problem, parts, poses[::_OWN_STRIDE])
    return Verdict(len(poses), largest, smallest, pair, int((distances < asked).sum()), own, worst_rate(plan))


def _own_contacts(problem: Problem, parts: list[_Part], poses: Array) -> int:
    """Samples (N, P, 4, 4) in which two parts of the instrument overlap that may not.

    Parts of links that are left out of the checks with a reason, and parts that never move against each other, may.
    """
    import coal

    allowed = {frozenset((pair.one, pair.two)) for pair in disabled_pairs(problem.robot)} | problem.world.allowed
    carrier = {link: place[0] for link, place in problem.robot.kinematics.mount.items()}
    radii, p = np.array([part.radius for part in parts]), poses[..., :3, 3]
    request, result = coal.CollisionRequest(), coal.CollisionResult()
    touching = np.zeros(len(poses), dtype=bool)
    for i, j in combinations(range(len(parts)), 2):
        one, two = parts[i].link, parts[j].link
        if carrier[one] == carrier[two] or frozenset((one, two)) in allowed:
            continue
        near = np.linalg.norm(p[:, i] - p[:, j], axis=-1) < radii[i] + radii[j]
        for k in np.nonzero(near & ~touching)[0]:
            X, Y = (geometry.transform(poses[k, part, :3, :3], poses[k, part, :3, 3]) for part in (i, j))
            result.clear()
            touching[k] = coal.collide(parts[i].solid, X, parts[j].solid, Y, request, result) > 0
    return int(touching.sum())


@dataclass(frozen=True)
class _Part:
    """A part of the arm as its model describes it."""

    link: str
    solid: Any  # coal.CollisionGeometry
    X_link_part: Array  # (4, 4)
    radius: float  # of the sphere around it [m]
    name: str
    jaw: float  # angle of the jaws at which it is placed [rad]


def _parts(problem: Problem) -> list[_Part]:
    """All parts of the arm, and of what it holds; those that move with the jaws once for each of their angles."""
    low, high = problem.robot.span
    still = _parts_at(problem, low)
    if high <= low:
        return still
    closed, opened = (problem.robot.arm.link_poses(problem.robot.arm.home, jaw) for jaw in (low, high))
    moves = {link for link in closed if np.abs(closed[link] - opened[link]).max() > 1e-12}
    more = [_parts_at(problem, float(jaw)) for jaw in np.linspace(low, high, _JAWS)[1:]]
    return [*still, *(part for parts in more for part in parts if part.link in moves)]


def _parts_at(problem: Problem, jaw: float) -> list[_Part]:
    """All parts with the jaws at an angle [rad]."""
    import coal

    robot = problem.robot.with_jaws(jaw, jaw)
    parts: list[_Part] = []
    held = {one.name for one in robot.attached}
    for body in robot.bodies:
        if body.kind != "capsules":
            solid, X = body.solid()
            X_link = np.asarray(np.linalg.inv(robot.kinematics.mount[body.link][1])) @ X
            box = np.abs(solid.bounds).max(axis=0)
            parts.append(_Part(body.link, solid.coal, X_link, float(np.linalg.norm(box)), body.name, jaw))
    given = {part.link for part in parts if part.name not in held}
    for part in robot.arm.visuals:
        if part.link in given or (given and not robot.arm.drawn):
            continue
        made = {"box": coal.Box, "cylinder": coal.Cylinder, "sphere": coal.Sphere}[part.shape](*part.size)
        half = {"box": np.array(part.size) / 2, "cylinder": np.array([part.size[0], part.size[-1] / 2]),
                "sphere": np.array(part.size)}[part.shape]  # fmt: skip
        parts.append(_Part(part.link, made, part.X_link_visual, float(np.linalg.norm(half)), part.link, jaw))
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
    found = np.empty((len(q), len(parts), 4, 4))
    for jaw in dict.fromkeys(part.jaw for part in parts):
        mine = [k for k, part in enumerate(parts) if part.jaw == jaw]
        names = list(dict.fromkeys(parts[k].link for k in mine))
        rows = (robot.arm.link_poses(row, jaw) for row in q)
        links = robot.X_WB @ np.array([[row[name] for name in names] for row in rows])
        place = [names.index(parts[k].link) for k in mine]
        found[:, mine] = links[:, place] @ np.array([parts[k].X_link_part for k in mine])
    return found


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
