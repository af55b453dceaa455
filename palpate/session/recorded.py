"""The scene of a record, its files found again."""

from __future__ import annotations

from palpate.errors import SceneError
from palpate.record.reader import Record
from palpate.scene.scene import Scene
from palpate.session.run_folder import SCENE


def recorded_scene(record: Record) -> Scene:
    """The scene of a record.

    A mesh or grid file, or an arm's model file, is taken from where the ``scene.yaml`` beside the record says it lay;
    where there is nothing any more, from where the record names it, seen from its own folder: so a record that moves
    may take its files along.

    Raises:
        SceneError: the record's scene cannot be read.
    """
    scene = Scene.parse(record.scene, str(record.path))
    try:
        there = Scene.load(record.path.with_name(SCENE))
        arm_files = {side: there.arm_path(side) for side in ("leader", "follower")}
        lay = {thing.name: there.path_of(i) for i, thing in enumerate(there.objects) if thing.file is not None}
    except SceneError:
        return scene
    objects = tuple(
        thing.model_copy(update={thing.source: str(lay[thing.name])})
        if thing.file is not None and thing.name in lay and lay[thing.name].is_file()
        else thing
        for thing in scene.objects
    )
    sections = {
        side: getattr(scene.arms, side).model_copy(update={"model": str(file)})
        for side, file in arm_files.items()
        if file is not None and file.is_file()
    }
    return scene.model_copy(update={"objects": objects, "arms": scene.arms.model_copy(update=sections)})
