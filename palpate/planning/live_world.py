"""The world of a scene that runs: moving organs, tracked objects and clouds of sensors where they are now."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.planning import geometry
from palpate.planning.problem import Problem
from palpate.planning.robot import Robot
from palpate.planning.world import Obstacle, World
from palpate.record import live
from palpate.record.ticks import Ticks
from palpate.scene import materials, placing
from palpate.scene.rig import Rig

if TYPE_CHECKING:
    from palpate import _tissue

STILL = 1e-4
"""An object that moved by less since its last pose counts as at rest [m]."""
Clouds = Callable[[], Mapping[str, tuple["_tissue.PointSurface", float]]]
"""Newest surfaces of sensors in O by the name of their object, with the spacing of their points [m]."""
Pose = Callable[[Ticks], Array | None]
Neighbour = tuple[Robot, Callable[[], Array]]


class LiveWorld:
    """The obstacles of a problem at the newest tick of a run.

    Args:
        problem: the problem, whose obstacles are those of the scene at rest.
        rig: the rig of the run.
        clouds: asks for the newest surfaces of sensors; None: no object is the cloud of a sensor.
        neighbours: the instruments of other pairs, with what returns their newest joints (n,) [rad, m].
    """

    def __init__(
        self, problem: Problem, rig: Rig, clouds: Clouds | None = None, neighbours: Sequence[Neighbour] = ()
    ) -> None:
        self._world, self._clouds = problem.world, clouds
        self._poses = _poses(rig)
        for robot, joints in neighbours:
            self._poses |= _led(robot, joints)
        self._seen: dict[str, _tissue.PointSurface] = {}

    @property
    def changes(self) -> bool:
        """True if an obstacle of this scene can move or change."""
        return bool(self._poses)

    def at(self, tick: Ticks) -> World:
        """The world at a tick; the same one as long as nothing has moved by more than `STILL`."""
        world = self._world
        for name, (surface, spacing) in (self._clouds() if self._clouds is not None else {}).items():
            if self._seen.get(name) is not surface:
                self._seen[name] = surface
                points = surface.averaged()[0]
                X_WO = self._poses[name](tick)
                world = _with_cloud(world, name, points, spacing, np.eye(4) if X_WO is None else X_WO)
        for one in world.obstacles:
            X_WO = self._poses[one.name](tick) if one.name in self._poses else None
            if X_WO is not None and _moved(one.solid.bounds, one.X_WO, X_WO) > STILL:
                world = world.moved(one.name, X_WO)
        self._world = world
        return world


def _with_cloud(world: World, name: str, points: Array, spacing: float, X_WO: Array) -> World:
    """The world with the newest frame of a sensor as an obstacle."""
    kept = replace(world, obstacles=tuple(one for one in world.obstacles if one.name != name))
    return kept.with_added([Obstacle(name, geometry.cloud(points, spacing), X_WO)]) if len(points) else kept


def _poses(rig: Rig) -> dict[str, Pose]:
    """How the pose of each object that can move is read from a tick, by name."""
    found: dict[str, Pose] = {}
    scene = rig.scene
    follow = placing.tracked(scene, placing.graph(scene)) if scene.trackers else {}
    slot = 0
    for obj, placed in zip(scene.objects, rig.surfaces, strict=True):
        if obj.name in follow or (obj.cloud is not None and obj.cloud.sensor is not None):
            found[obj.name] = _tracked(slot)
            slot += 1
        elif obj.motion:
            found[obj.name] = _waving(materials.motion(obj, placed.bounds.mean(axis=0)), placed.X_WO)
    return found


def _led(robot: Robot, joints: Callable[[], Array]) -> dict[str, Pose]:
    """How the poses of the bodies of an instrument that a hand moves are found."""

    @lru_cache(maxsize=1)
    def placed(q: bytes) -> Array:
        return np.asarray(robot.placed(np.frombuffer(q)[None]).X_W[0])

    def pose(index: int, X: Array) -> Pose:
        return lambda tick: placed(np.ascontiguousarray(joints(), dtype=np.float64).tobytes())[index] @ X

    return {f"{robot.name}/{body.name}": pose(i, body.solid()[1]) for i, body in enumerate(robot.bodies)}


def _tracked(slot: int) -> Pose:
    return lambda tick: live.object_pose(tick, slot)


def _waving(motion: _core.Motion, X_WO: Array) -> Pose:
    return lambda tick: np.asarray(motion.pose(X_WO, float(tick["t"])))


def _moved(bounds: Array, before: Array, after: Array) -> float:
    """Largest motion of a corner of a box (2, 3) in O between two poses [m]."""
    low, high = bounds
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    change = (after - before)[:3]
    return float(np.linalg.norm(corners @ change[:, :3].T + change[:, 3], axis=1).max())
