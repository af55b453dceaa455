"""The objects of a scene as surfaces in the world."""

from __future__ import annotations

import sys
import warnings
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TypeAlias, TypeGuard

import numpy as np
from numpy.typing import NDArray

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.errors import CloudError, MeshError, PalpateWarning, SceneError, SurfaceError
from palpate.scene import materials, placing
from palpate.scene.clouds import CloudSection
from palpate.scene.model import ObjectSection
from palpate.scene.scene import Scene
from palpate.scene.trackers import TrackerSection
from palpate.world import mesh, surfaces


def is_mesh(body: mesh.Mesh | surfaces.Surface) -> TypeGuard[mesh.Mesh]:
    """True for a mesh; does not import meshes for a scene without any."""
    return isinstance(body.core, _core.Mesh)


@dataclass(frozen=True)
class PlacedSurface:
    """A surface placed in the world."""

    body: mesh.Mesh | surfaces.Surface  # both have vertices and triangles for drawing
    X_WO: Array  # (4, 4)

    def nearest(self, points_W: Array) -> tuple[Array, Array]:
        """Nearest surface points [m] and outward normals in W, both (n, 3), of points (n, 3) in W [m]."""
        R, p = self.X_WO[:3, :3], self.X_WO[:3, 3]
        _, q, n = self.body.core.nearest(np.ascontiguousarray((points_W - p) @ R))
        return q @ R.T + p, n @ R.T

    @cached_property
    def bounds(self) -> Array:
        """Lowest and highest corner (2, 3) of the drawn surface in W [m]."""
        if is_mesh(self.body) and np.array_equal(self.X_WO[:3, :3], np.eye(3)):
            return np.stack([self.body.core.report.lowest, self.body.core.report.highest]) + self.X_WO[:3, 3]
        v = self.body.vertices @ self.X_WO[:3, :3].T + self.X_WO[:3, 3]
        return np.stack([v.min(axis=0), v.max(axis=0)])

    def drawable(self, most: int) -> tuple[Array, NDArray[np.int32]]:
        """Vertices (n, 3) in O [m] and triangles (m, 3) of a surface of about `most` triangles or fewer, to draw."""
        if len(self.body.triangles) <= most:
            return self.body.vertices, self.body.triangles
        from palpate.world.mesh.coarse import drawable

        key = self.body.key if is_mesh(self.body) else ""
        return drawable(self.body.vertices, self.body.triangles, most, key)

    @property
    def top(self) -> Array:
        """A point (3,) in W high above the centre [m]."""
        low, high = self.bounds
        middle = 0.5 * (low + high)
        return np.array([middle[0], middle[1], high[2] + float(np.linalg.norm(high - low))])


_CLOUD_SPEED, _CLOUD_ACCELERATION = 0.5, 50.0  # [m/s], [m/s^2] of a surface between two frames
_CLOUD_GAIN = 60.0  # of its motion: it takes a new velocity within 4 ms [1/s]

Bodies: TypeAlias = "dict[str, mesh.Mesh | surfaces.Surface]"
"""Surfaces shared by scenes, keyed by the values that define them."""


def placed(scene: Scene, bodies: Bodies | None = None) -> list[PlacedSurface]:
    """Read or generate the surface of every object, and place it in W.

    Args:
        scene: the scene that contains the objects.
        bodies: surfaces shared with other scenes; equal surfaces are reused and new ones are added.

    Raises:
        MeshError, SurfaceError: a file cannot be used. SceneError: a path contains an unset variable.
    """
    shared = {} if bodies is None else bodies
    found = []
    for i, X_WO in enumerate(placing.object_poses(scene)):
        key = _surface_key(scene, i)
        if key not in shared:
            body = _body(scene, i)
            shared[key] = body if scene.objects[i].tissue is None else _filled(scene, i, body)
        found.append(PlacedSurface(shared[key], X_WO))
    return found


def _surface_key(scene: Scene, index: int) -> str:
    """Text of all values that define the surface of an object; equal texts mean equal surfaces."""
    obj = scene.objects[index]
    file = None
    if obj.file is not None:
        path = scene.path_of(index)
        with suppress(OSError):  # reading the file later reports that it is missing
            state = path.stat()
            file = (str(path.resolve()), state.st_size, state.st_mtime_ns)
    selected = (obj.unit, obj.label, obj.threshold, obj.noise)
    return repr((obj.name, obj.source, getattr(obj, obj.source), file, selected, obj.triangles, obj.tissue))


def snapshot(scene: Scene, surfaces_W: list[PlacedSurface]) -> _core.Snapshot:
    """Objects, materials and motions for the core."""
    follow = placing.tracked(scene, placing.graph(scene)) if scene.trackers else {}
    objects = []
    for i, (obj, one) in enumerate(zip(scene.objects, surfaces_W, strict=True)):
        live = live_options(scene.trackers[follow[obj.name]], one) if obj.name in follow else None
        if obj.cloud is not None and obj.cloud.sensor is not None:
            if obj.motion or obj.frame != "world" or not np.array_equal(one.X_WO, np.eye(4)):
                what = f"{obj.name!r} is the cloud of a sensor: it has no pose, frame and motion"
                raise SceneError(what, where=scene.where("objects", i), mend="leave them out; the sensor sees motion")
            live = cloud_options(obj.cloud)
        motion = materials.motion(obj, one.bounds.mean(axis=0))
        objects.append(core_object(obj, one, motion, live))
    return _core.Snapshot(objects)


def cloud_options(section: CloudSection) -> _core.LiveOptions:
    """Limits of the motion of a sensor's cloud between its frames; it only translates."""
    patience, fade = section.patience, section.fade
    return _core.LiveOptions(_CLOUD_SPEED, 1.0, _CLOUD_ACCELERATION, patience, fade, gain=_CLOUD_GAIN)


def live_options(section: TrackerSection, placed: PlacedSurface) -> _core.LiveOptions:
    """Limits of the motion of an object that follows a tracker; it turns about the centre of its bounding box."""
    vertices = placed.body.vertices
    p_OC = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    turn = float(np.radians(section.turn_deg))
    return _core.LiveOptions(section.speed, turn, section.acceleration, section.max_age, section.fade, p_OC)


def core_object(
    obj: ObjectSection,
    placed: PlacedSurface,
    motion: _core.Motion,
    live: _core.LiveOptions | None = None,
) -> _core.Object:
    """An object for the core: its surface and rest pose, material, regions, and its motion or limits of live motion."""
    return _core.Object(
        obj.name,
        placed.body.core,
        placed.X_WO,
        materials.material(obj),
        materials.regions(obj),
        motion,
        is_virtual=obj.presence != "real",
        is_real=obj.presence != "virtual",
        live=live,
    )


def _body(scene: Scene, index: int) -> mesh.Mesh | surfaces.Surface:
    obj = scene.objects[index]
    if obj.file is not None or obj.cloud is not None:
        return _from_file(scene, index)
    if obj.shape is None:
        made: surfaces.Surface = getattr(obj, obj.source).make(obj.name)
        return made
    from palpate.world import shapes

    make = {"organ": shapes.organ, "gallbladder": shapes.gallbladder, "duodenum": shapes.duodenum}[obj.shape]
    try:
        return mesh.Mesh(*make(obj.triangles), name=obj.name)
    except ValueError as error:
        raise SceneError(str(error), where=scene.where("objects", index), mend="change triangles") from None


def _filled(scene: Scene, index: int, body: mesh.Mesh | surfaces.Surface) -> surfaces.Surface:
    """The soft body that fills a closed surface."""
    obj, where = scene.objects[index], scene.where("objects", index, "tissue")
    section = obj.tissue
    assert section is not None
    around = body if is_mesh(body) else mesh.Mesh(body.vertices, body.triangles, name=obj.name)
    path = None if section.volume is None else scene.path_to(section.volume, where)
    try:
        volume = section.tetrahedra(around, path, obj.unit or "mm", lambda line: print(line, file=sys.stderr))
        made = section.make(volume, obj.name)
    except (MeshError, SurfaceError) as error:
        why = "; ".join(part for part in (error.where, error.why) if part)
        raise type(error)(error.what, where=where, why=why, mend=error.mend) from None
    if what := section.floating(volume, obj.name):
        mend = "tissue.fixed: balls or boxes that hold it; or tissue.springs"
        warnings.warn(PalpateWarning(what, where=where, mend=mend), stacklevel=3)
    return made


def _from_file(scene: Scene, index: int) -> mesh.Mesh | surfaces.Surface:
    obj = scene.objects[index]
    path = scene.path_of(index) if obj.file is not None else Path()
    try:
        if obj.cloud is not None:
            return obj.cloud.make(obj.name, path, obj.unit)
        if obj.mesh is not None:
            from palpate.world.mesh.denoise import denoise

            return denoise(mesh.Mesh.load(path, obj.unit, label=obj.label, threshold=obj.threshold), obj.noise)
        return surfaces.DistanceGrid.load(path, obj.unit or "mm")
    except (CloudError, MeshError, SurfaceError) as error:
        why = "; ".join(part for part in (error.where, error.why) if part)
        where = scene.where("objects", index, obj.source)
        raise type(error)(error.what, where=where, why=why, mend=error.mend) from None
