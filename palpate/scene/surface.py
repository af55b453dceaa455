"""The objects of a scene as surfaces in the world."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from palpate import _core, surfaces
from palpate.arrays import Array
from palpate.errors import SceneError
from palpate.mesh import Mesh
from palpate.scene import materials
from palpate.scene.scene import Scene


@dataclass(frozen=True)
class Surface:
    """A surface placed in the world."""

    body: Mesh | surfaces.Surface  # both have vertices and triangles to be drawn
    X_WO: Array  # (4, 4)

    def nearest(self, points_W: Array) -> tuple[Array, Array]:
        """Nearest surface points and outward normals in W, both (n, 3)."""
        R, p = self.X_WO[:3, :3], self.X_WO[:3, 3]
        _, q, n = self.body.core.nearest(np.ascontiguousarray((points_W - p) @ R))
        return q @ R.T + p, n @ R.T

    @property
    def bounds(self) -> Array:
        """(2, 3): lowest and highest corner in W of what is drawn [m]."""
        v = self.body.vertices @ self.X_WO[:3, :3].T + self.X_WO[:3, 3]
        return np.stack([v.min(axis=0), v.max(axis=0)])

    @property
    def top(self) -> Array:
        """A point high above the middle."""
        low, high = self.bounds
        middle = 0.5 * (low + high)
        return np.array([middle[0], middle[1], high[2] + float(np.linalg.norm(high - low))])


Bodies = dict[str, Mesh | surfaces.Surface]
"""Surfaces that scenes share, by what they are made of."""


def placed(scene: Scene, bodies: Bodies | None = None) -> list[Surface]:
    """Every object's surface, read or made, placed in W.

    Args:
        scene: whose objects are wanted.
        bodies: surfaces of other scenes, taken from here where they are the same; new ones are added.

    Raises:
        MeshError, SurfaceError: a file cannot be used. SceneError: its path names an unknown variable.
    """
    shared = {} if bodies is None else bodies
    found = []
    for i, thing in enumerate(scene.objects):
        key = _made_of(scene, i)
        if key not in shared:
            shared[key] = _body(scene, i)
        found.append(Surface(shared[key], thing.pose.matrix()))
    return found


def _made_of(scene: Scene, index: int) -> str:
    """What the surface of an object depends on; equal texts mean equal surfaces."""
    thing = scene.objects[index]
    file = None
    if thing.file is not None:
        path = scene.path_of(index)
        with suppress(OSError):  # a missing file is refused when it is read
            state = path.stat()
            file = (str(path.resolve()), state.st_size, state.st_mtime_ns)
    return repr((thing.name, thing.source, getattr(thing, thing.source), file, thing.unit, thing.triangles))


def snapshot(scene: Scene, surfaces_W: list[Surface]) -> _core.Snapshot:
    """The world as the core sees it."""
    objects = []
    for thing, placed_one in zip(scene.objects, surfaces_W, strict=True):
        objects.append(
            _core.Object(
                thing.name,
                placed_one.body.core,
                placed_one.X_WO,
                materials.material(thing),
                materials.regions(thing),
                materials.motion(thing, placed_one.bounds.mean(axis=0)),
                is_virtual=thing.presence != "real",
                is_real=thing.presence != "virtual",
            )
        )
    return _core.Snapshot(objects)


def _body(scene: Scene, index: int) -> Mesh | surfaces.Surface:
    thing = scene.objects[index]
    if thing.mesh is not None:
        return Mesh.load(scene.path_of(index), thing.unit)
    if thing.sdf is not None:
        return surfaces.DistanceGrid.load(scene.path_of(index), thing.unit)
    if thing.shape is None:
        made: surfaces.Surface = getattr(thing, thing.source).make(thing.name)
        return made
    from palpate import shapes

    make = {"organ": shapes.organ, "gallbladder": shapes.gallbladder}[thing.shape]
    try:
        return Mesh(*make(thing.triangles), name=thing.name)
    except ValueError as error:
        raise SceneError(str(error), where=scene.where("objects", index), mend="change triangles") from None
