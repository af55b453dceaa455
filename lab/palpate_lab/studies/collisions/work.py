"""The work of ``palpate study collisions``: a moving instrument, the pairs that touch, and where."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.planning import geometry
from palpate.planning.checker import Checker
from palpate.planning.kinematics import pose_of
from palpate.planning.robot import Robot
from palpate.planning.shapes import Capsule
from palpate.planning.world import World, obstacle
from palpate.world import shapes
from palpate.world.mesh import Mesh
from palpate_lab.studies.collisions.brute import to_triangles

STEPS = 60  # positions of the moving instrument
BRUTE = 2000  # triangles of the organ that brute force is compared on
_POINTS = 64  # contact points kept for a pair
_SAME = 1e-6  # distances from zero at which both methods may differ by rounding [m]
_SEGMENT = 0.03  # half length of the capsule that is compared with brute force [m]
_RADIUS = 0.0042  # its radius, that of the shaft [m]


@dataclass(frozen=True)
class Contact:
    """Contact of a link with a mesh at one position of the instrument."""

    step: int
    pair: tuple[str, str]
    points_W: Array  # (k, 3) [m]
    depths: Array  # (k,) overlap of the link with single triangles [m]


def skeleton(folder: Path) -> Mesh:
    """A rib cage and spine as a segmentation in an .nrrd file, read back as the surface of its label."""
    import nrrd

    spacing = 2.0  # [mm]
    x, y, z = (np.arange(low, high, spacing) for low, high in ((-110, 112), (-90, 92), (-75, 77)))
    voxels = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1)
    bone = np.hypot(voxels[..., 0], voxels[..., 2] + 58.0) < 11.0  # spine, along y
    for k in range(-3, 4):  # ribs: inclined half rings around the trunk
        inclined = voxels[..., 1] - 22.0 * k - 0.25 * (voxels[..., 2] + 20.0)
        ring = np.hypot(voxels[..., 0] / 95.0, (voxels[..., 2] + 5.0) / 60.0)
        bone |= (np.hypot(75.0 * (ring - 1.0), inclined) < 4.5) & (voxels[..., 2] < 38.0)
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "skeleton.nrrd"
    header = {"space": "left-posterior-superior", "space directions": spacing * np.eye(3), "kinds": ["domain"] * 3,
              "space origin": [float(x[0]), float(y[0]), float(z[0])]}  # fmt: skip
    nrrd.write(str(file), bone.astype(np.uint8), header)
    return Mesh.load(file)


def scene(folder: Path, volume: Path | None, label: str | None) -> tuple[Robot, World]:
    """The instrument, an organ and a skeleton from an .nrrd segmentation: the generated one, or a given file."""
    bones = skeleton(folder) if volume is None else Mesh.load(volume, label=label)
    middle = 0.5 * (bones.vertices.min(axis=0) + bones.vertices.max(axis=0))
    place = np.array([0.0, 0.0, -0.02]) if volume is None else -middle
    world = World((obstacle("liver", Mesh(*shapes.organ(), name="liver"), np.eye(4)),
                   obstacle("skeleton", bones, pose_of(place, np.zeros(3)))))  # fmt: skip
    robot = Robot("PSM1", Arm.psm(), pose_of(np.array([-0.03, -0.09, 0.13]), np.zeros(3)))
    return robot, world


def motion(robot: Robot, steps: int) -> Array:
    """Joint positions (steps, 6) of a sweep through the organ and the ribs."""
    s = np.linspace(0.0, 1.0, steps)
    q = np.zeros((steps, 6))
    q[:, 0], q[:, 1] = -0.7 + 1.5 * s, 0.55 * np.sin(2.0 * np.pi * s)
    q[:, 2], q[:, 4] = 0.13 + 0.08 * np.sin(np.pi * s), 0.5 * np.cos(2.0 * np.pi * s)
    return np.asarray(np.clip(q, robot.arm.q_min, robot.arm.q_max))


def contacts(checker: Checker, q: Array, step: int = 0) -> list[Contact]:
    """Every pair "link x mesh" in contact at q (n,), with points and depths."""
    import coal

    request, found = coal.CollisionRequest(), []
    request.num_max_contacts = _POINTS
    result = coal.CollisionResult()
    placed = checker.robot.placed(q[None])
    for i, body in enumerate(checker.robot.bodies):
        solid, X_capsule = geometry.capsule(body.capsule)
        X = placed.X_W[0, i] @ X_capsule
        for o in checker.world.obstacles:
            result.clear()
            if not coal.collide(solid.coal, geometry.transform(X[:3, :3], X[:3, 3]), o.solid.coal, o.transform, request,
                                result):  # fmt: skip
                continue
            all_ = list(result.getContacts())
            points = np.array([contact.pos for contact in all_])
            found.append(Contact(step, (body.name, o.name), points, np.array([-c.penetration_depth for c in all_])))
    return found


def agreement(poses: int, seed: int = 0) -> dict[str, float]:
    """Coal and brute force on random poses of a capsule at a coarse organ: contact, and distance."""
    import coal

    v, t = shapes.organ(BRUTE)
    mesh, corners = geometry.mesh(v, t), v[t]
    rng = np.random.default_rng(seed)
    z = rng.normal(size=(poses, 3))
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    p = v[rng.integers(len(v), size=poses)] + rng.normal(scale=0.02, size=(poses, 3))
    a, b = p - _SEGMENT * z, p + _SEGMENT * z
    solid = geometry.capsule(Capsule(-_SEGMENT * np.eye(3)[2], _SEGMENT * np.eye(3)[2], _RADIUS))[0]
    request, result = coal.CollisionRequest(), coal.CollisionResult()
    ask, answer = coal.DistanceRequest(), coal.DistanceResult()
    still = geometry.transform(np.eye(3), np.zeros(3))
    differ, touching, worst, took = 0, 0, 0.0, 0.0
    for k in range(poses):
        near = np.linalg.norm(corners.mean(axis=1) - p[k], axis=1) < _SEGMENT + 0.05
        exact = float(to_triangles(a[k : k + 1], b[k : k + 1], corners[near]).min(initial=0.05)) - _RADIUS
        X = Capsule(a[k], b[k], _RADIUS).pose()
        moved = geometry.transform(X[:3, :3], X[:3, 3])
        result.clear()
        begin = time.perf_counter()
        touches = coal.collide(solid.coal, moved, mesh.coal, still, request, result) > 0
        took += time.perf_counter() - begin
        touching += touches
        differ += touches != (exact <= 0.0) and abs(exact) > _SAME
        if 0.0 < exact < 0.03:
            answer.clear()
            worst = max(worst, abs(coal.distance(solid.coal, moved, mesh.coal, still, ask, answer) - exact))
    return {"poses": poses, "touching": touching, "disagreements": differ, "worst_distance_error_m": worst,
            "query_mean_us": 1e6 * took / poses}  # fmt: skip


def run(
    folder: Path, volume: Path | None, label: str | None, poses: int
) -> tuple[dict[str, Any], list[Contact], World]:
    """The result with the keys of docs/json, all contacts, and the world."""
    robot, world = scene(folder, volume, label)
    checker = Checker(robot, world)
    found: list[Contact] = []
    times = []
    for step, q in enumerate(motion(robot, STEPS)):
        begin = time.perf_counter()
        found += contacts(checker, q, step)
        times.append(time.perf_counter() - begin)
    pairs: dict[tuple[str, str], list[Contact]] = {}
    for one in found:
        pairs.setdefault(one.pair, []).append(one)
    rows = [{"link": link, "mesh": mesh, "steps": len(every), "points": sum(len(c.depths) for c in every),
             "largest_depth_m": max(float(c.depths.max()) for c in every)}
            for (link, mesh), every in sorted(pairs.items())]  # fmt: skip
    triangles = {o.name: int(o.solid.coal.num_tris) for o in world.obstacles}
    result = {"pairs": rows, "steps": STEPS, "triangles": triangles, "links": len(robot.bodies),
              "query_median_s": float(np.median(times)), "brute_force": agreement(poses)}  # fmt: skip
    return result, found, world
