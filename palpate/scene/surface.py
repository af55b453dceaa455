"""The objects of a scene as surfaces in the world."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.errors import SceneError
from palpate.mesh import Mesh
from palpate.scene.scene import Scene

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Surface:
    """A mesh placed in the world."""

    mesh: Mesh
    X_WO: Array  # (4, 4)

    def nearest(self, points_W: Array) -> tuple[Array, Array]:
        """Nearest surface points and outward normals in W, both (n, 3)."""
        R, p = self.X_WO[:3, :3], self.X_WO[:3, 3]
        _, q, n, _ = self.mesh.closest((points_W - p) @ R)
        return q @ R.T + p, n @ R.T

    @property
    def bounds(self) -> Array:
        """(2, 3): lowest and highest corner in W [m]."""
        v = self.mesh.vertices @ self.X_WO[:3, :3].T + self.X_WO[:3, 3]
        return np.stack([v.min(axis=0), v.max(axis=0)])

    @property
    def top(self) -> Array:
        """A point high above the middle."""
        low, high = self.bounds
        middle = 0.5 * (low + high)
        return np.array([middle[0], middle[1], high[2] + float(np.linalg.norm(high - low))])


def surfaces(scene: Scene) -> list[Surface]:
    """Every object's mesh, read or made, placed in W.

    Raises:
        MeshError: a mesh cannot be used. SceneError: its path names an unknown variable.
    """
    return [Surface(_mesh(scene, i), thing.pose.matrix()) for i, thing in enumerate(scene.objects)]


def snapshot(scene: Scene, placed: list[Surface]) -> _core.Snapshot:
    """The world as the core sees it."""
    objects = []
    for thing, placed_one in zip(scene.objects, placed, strict=True):
        material = _core.Material(np.array(thing.stiffness), np.array(thing.damping), thing.friction)
        objects.append(_core.Object(thing.name, placed_one.mesh.core, placed_one.X_WO, material))
    return _core.Snapshot(objects)


def _mesh(scene: Scene, index: int) -> Mesh:
    thing = scene.objects[index]
    if thing.shape is None:
        return Mesh.load(scene.mesh_path(index), thing.unit)
    from palpate import shapes

    make = {"organ": shapes.organ, "gallbladder": shapes.gallbladder}[thing.shape]
    try:
        return Mesh(*make(thing.triangles), name=thing.name)
    except ValueError as error:
        raise SceneError(str(error), where=scene.where("objects", index), mend="change triangles") from None
