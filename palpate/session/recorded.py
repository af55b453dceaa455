"""Loads the scene of a record and locates its files."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from palpate.base.errors import SceneError
from palpate.record.reader import Record
from palpate.record.snapshots import BodyTrack, Track, topic_of
from palpate.scene.model import ObjectSection
from palpate.scene.scene import Scene
from palpate.session.run_folder import SCENE
from palpate.world.bodies import BodySection


def recorded_scene(record: Record) -> Scene:
    """The scene of a record.

    A mesh, grid or arm model file is first looked up at its path in the ``scene.yaml`` next to the record. If that file
    no longer exists, the path in the record is used, relative to the record's folder. A record can therefore be moved
    together with its files.

    Raises:
        SceneError: the record's scene cannot be read.
    """
    scene = Scene.parse(record.scene, str(record.path))
    try:
        original = Scene.load(record.path.with_name(SCENE))
        arm_files = {side: original.arm_path(side) for side in ("leader", "follower")}
        files = {obj.name: original.path_of(i) for i, obj in enumerate(original.objects) if obj.file is not None}
    except SceneError:
        return scene
    objects = tuple(
        obj.model_copy(update={obj.source: str(files[obj.name])})
        if obj.file is not None and obj.name in files and files[obj.name].is_file()
        else obj
        for obj in scene.objects
    )
    objects = tuple(_with_volume(obj, original) for obj in objects)
    bodies = tuple(_with_meshes(body, original) for body in scene.bodies)
    sections = {
        side: getattr(scene.arms, side).model_copy(update={"model": str(file)})
        for side, file in arm_files.items()
        if file is not None and file.is_file()
    }
    arms = scene.arms.model_copy(update=sections)
    return scene.model_copy(update={"objects": objects, "bodies": bodies, "arms": arms})


def body_track(record: Record) -> BodyTrack | None:
    """Poses of the rigid bodies of a run over time; of several pairs, one record of the run holds them.

    Args:
        record: a record of the run.
    """
    return next((track for one in _of_run(record) if (track := one.bodies) is not None), None)


def shape_track(record: Record, name: str) -> Track | None:
    """Displacements of a soft object's vertices over time, in the order of `rest_shape` (palpate/scene/soft.py); None
    if the record holds none. Of several pairs that press the object, one record of the run holds it.

    Args:
        record: a record of the run.
        name: of the object.
    """
    return next((track for one in _of_run(record) if (track := one.snapshots(topic_of(name))) is not None), None)


def _of_run(record: Record) -> Iterator[Record]:
    """The record, then those of the other pairs of its run."""
    yield record
    folder = record.path.parent
    others = sorted(folder.parent.glob("*/record.mcap")) if (folder.parent / SCENE).is_file() else []
    yield from (Record.open(path) for path in others if path.parent != folder)


def _with_meshes(body: BodySection, original: Scene) -> BodySection:
    """The body with its mesh files where the scene next to the record has them."""
    there = next((one for one in original.bodies if one.name == body.name), body)
    meshes = [part.mesh for part in there.parts if part.mesh is not None]
    found = meshes and all(Path(mesh).is_file() for mesh in meshes)
    return body.model_copy(update={"parts": there.parts}) if found else body


def _with_volume(obj: ObjectSection, original: Scene) -> ObjectSection:
    """The object with the file of its tetrahedra where the scene next to the record has it."""
    there = next((one.tissue for one in original.objects if one.name == obj.name), None)
    if obj.tissue is None or there is None or there.volume is None or not Path(there.volume).is_file():
        return obj
    return obj.model_copy(update={"tissue": obj.tissue.model_copy(update={"volume": there.volume})})
