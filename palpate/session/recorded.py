"""Loads the scene of a record and locates its files."""

from __future__ import annotations

from pathlib import Path

from palpate.errors import SceneError
from palpate.record.reader import Record
from palpate.record.snapshots import Track, topic_of
from palpate.scene.model import ObjectSection
from palpate.scene.scene import Scene
from palpate.session.run_folder import SCENE


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
    sections = {
        side: getattr(scene.arms, side).model_copy(update={"model": str(file)})
        for side, file in arm_files.items()
        if file is not None and file.is_file()
    }
    return scene.model_copy(update={"objects": objects, "arms": scene.arms.model_copy(update=sections)})


def shape_track(record: Record, name: str) -> Track | None:
    """Displacements of a soft object's vertices over time, in the order of `rest_shape` (palpate/scene/soft.py); None
    if the record holds none. Of several pairs that press the object, one record of the run holds it.

    Args:
        record: a record of the run.
        name: of the object.
    """
    folder = record.path.parent
    others = sorted(folder.parent.glob("*/record.mcap")) if (folder.parent / SCENE).is_file() else []
    records = (record, *(Record.open(path) for path in others if path.parent != folder))
    return next((track for one in records if (track := one.snapshots(topic_of(name))) is not None), None)


def _with_volume(obj: ObjectSection, original: Scene) -> ObjectSection:
    """The object with the file of its tetrahedra where the scene next to the record has it."""
    there = next((one.tissue for one in original.objects if one.name == obj.name), None)
    if obj.tissue is None or there is None or there.volume is None or not Path(there.volume).is_file():
        return obj
    return obj.model_copy(update={"tissue": obj.tissue.model_copy(update={"volume": there.volume})})
