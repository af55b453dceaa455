"""Places objects and arm bases in W by the frames of a scene."""

from __future__ import annotations

from functools import partial

from palpate import _core
from palpate.base.arrays import Array, rigid
from palpate.base.errors import FrameError, SceneError
from palpate.scene.scene import Scene
from palpate.world.frames import Edge, FrameGraph, FrameSection
from palpate.world.frames.graph import WORLD

ARMS = ("leader", "follower")


def graph(scene: Scene) -> FrameGraph:
    """The graph of the scene's list ``frames``, without arms and objects.

    Raises:
        SceneError: a pose, its file, or the tree is invalid; the message gives the line of the entry.
    """
    edges = []
    for i, section in enumerate(scene.frames):
        from palpate.world.frames import files

        where = scene.where("frames", i)
        try:
            edges.append(files.edge(section, partial(scene.path_to, where=where)))
        except FrameError as error:
            raise _at(scene, i, error) from None
    try:
        return FrameGraph(edges)
    except FrameError as error:
        named = [i for i, section in enumerate(scene.frames) if f"frame {section.child!r}" in error.what]
        raise _at(scene, named[-1] if named else None, error) from None


def whole_graph(scene: Scene, X_WL: Array, X_WB: Array) -> FrameGraph:
    """The graph of the scene with the bases of both arms (X_WL, X_WB (4, 4) [m]) and all objects.

    Raises:
        SceneError: as for `graph`.
    """
    made = graph(scene)
    for side, X_WA in zip(ARMS, (X_WL, X_WB), strict=True):
        parent = getattr(scene.arms, side).frame
        X = rigid.inverse(made.pose(parent).X) @ X_WA
        given = parent != WORLD or getattr(scene.arms, side).base is not None
        made.add(Edge(parent, side, X, source=f"arms.{side}" if given else f"arms.{side}, automatic"))
    for obj in scene.objects:
        made.add(Edge(obj.frame, obj.name, obj.pose.matrix(), source=f"objects, {obj.source}"))
    return made


def object_poses(scene: Scene) -> list[Array]:
    """X_WO (4, 4) [m] of every object at the start.

    Raises:
        SceneError: an object names an unknown frame, or the frames are invalid.
    """
    found = graph(scene) if scene.frames else FrameGraph()
    poses = []
    for i, obj in enumerate(scene.objects):
        X_WF = _pose(scene, found, obj.frame, "objects", i, "frame")
        poses.append(X_WF @ obj.pose.matrix() if obj.frame != WORLD else obj.pose.matrix())
    return poses


def base_pose(scene: Scene, side: str) -> Array | None:
    """Pose (4, 4) of an arm's base in W [m]; None if it is placed automatically.

    Raises:
        SceneError: the frame is unknown, or moves while a session runs.
    """
    section = getattr(scene.arms, side)
    base: Array | None = section.base.matrix() if section.base is not None else None
    if section.frame == WORLD:
        return base
    found = graph(scene)
    X_WF = _pose(scene, found, section.frame, "arms", side, "frame")
    if found.is_live(section.frame):
        raise SceneError(
            f"arms.{side}: frame {section.frame!r} moves while a session runs, and an arm's base does not",
            where=scene.where("arms", side, "frame"),
            mend="name a frame at rest, such as the tracker's, and give the base there: palpate frames SCENE --of "
            f"{section.frame} --reference FRAME prints where it is",
        )
    return X_WF if base is None else X_WF @ base


def tracked_frames(scene: Scene) -> list[FrameSection]:
    """Entries of the scene's list ``frames`` that a tracker moves, in its order, which is that of their records.

    Raises:
        SceneError: there are more than the loop can record.
    """
    found = [section for section in scene.frames if section.tracker is not None]
    _require_room(scene, len(found), "frames")
    return found


def _require_room(scene: Scene, n: int, kind: str) -> None:
    if n > _core.MAX_LIVE:
        what = f"{n} {kind} follow trackers; at most {_core.MAX_LIVE} are possible"
        raise SceneError(what, where=scene.where("trackers"), mend="remove some, or put them into several scenes")


def tracked(scene: Scene, frames: FrameGraph) -> dict[str, str]:
    """Objects that move with a tracked frame, in the scene's order, each with the name of the tracker nearest to it.

    Raises:
        SceneError: an object has a motion as well, or there are more objects than the loop can move.
    """
    by_child = {section.child: section for section in scene.frames if not section.check}
    found = {}
    for i, obj in enumerate(scene.objects):
        name = obj.frame
        if frames.is_live(name) and obj.motion:
            what = f"object {obj.name!r} follows the tracked frame {name!r} and has a motion"
            raise SceneError(
                what, where=scene.where("objects", i, "motion"), mend="remove motion, or name another frame"
            )
        while name != frames.root:
            section: FrameSection = by_child[name]
            if section.tracker is not None:
                found[obj.name] = section.tracker
                break
            name = section.parent
    _require_room(scene, len(found), "objects")
    return found


def _pose(scene: Scene, found: FrameGraph, name: str, *place: str | int) -> Array:
    try:
        return found.pose(name).X
    except FrameError as error:
        spelled = scene.where(*place)
        raise SceneError(error.what, where=spelled, why=error.why, mend=error.mend) from None


def _at(scene: Scene, index: int | None, error: FrameError) -> SceneError:
    where = scene.where("frames") if index is None else scene.where("frames", index)
    why = "; ".join(part for part in (error.where, error.why) if part)
    return SceneError(error.what, where=where, why=why, mend=error.mend)


def inlined(scene: Scene, found: FrameGraph) -> list[FrameSection]:
    """The scene's frames with the content of their files, so that a record does not depend on them."""
    made = []
    for section, edge in zip(scene.frames, _edges(scene, found), strict=True):
        pose = {"matrix": edge.X.tolist()}
        data = section.model_dump() | {"pose": pose, "file": None, "sigma_mm": None, "sigma_deg": None}
        data |= {"covariance": edge.covariance.tolist() if edge.covariance.any() else None}
        made.append(FrameSection.model_validate(data | {"source": edge.source, "stamp": edge.stamp}))
    return made


def _edges(scene: Scene, found: FrameGraph) -> list[Edge]:
    checks = iter(d.edge for d in found.disagreements())
    return [next(checks) if s.check else found.edge(s.child) for s in scene.frames]
