"""Rerun: every signal as a series, and the objects, the tool, its path and its force in 3-D."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.base.arrays import Array
from palpate.base.errors import PalpateError
from palpate.export.bag_ticks import BagTicks
from palpate.export.demonstration import ArmOfRun, Demonstration
from palpate.export.frames import ArmFrames, frames_of
from palpate.export.options import Options
from palpate.export.tables import Table, tables, told
from palpate.record.reader import Record
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate.scene.surface import PlacedSurface
from palpate.session.recorded import recorded_scene

FORCE_SCALE = 0.012
"""Length of a force arrow [m/N], as in the surgeon's view."""
_GREEN, _GREY, _SKIN = (40, 210, 80), (120, 120, 130), (190, 120, 110)


def write(runs: Sequence[Demonstration], folder: Path, options: Options, scene: Scene | None = None) -> dict[str, Any]:
    """Write an .rrd file for each arm; `rerun FILE` shows it.

    Args:
        runs: the runs.
        folder: an empty folder.
        options: options of the export.
        scene: the scene with the objects and the base of the follower; that of each run when left out.

    Raises:
        PalpateError: rerun-sdk is not installed. SceneError: the given scene cannot be set up.
    """
    rr = _library()
    arms = [arm for run in runs for arm in run.arms]
    written = []
    for table, arm in zip(tables(runs, options), arms, strict=True):
        file = folder / f"{table.name}.rrd"
        rows = _write(rr, file, table, arm, options.fps, scene)
        written.append((table, file, rows))
    return told(written)


def _library() -> Any:
    try:
        import rerun
    except ImportError:
        mend = "pip install rerun-sdk (0.7 GB; no extra of palpate holds it)"
        raise PalpateError("rerun-sdk is not installed", mend=mend) from None
    return rerun


def _write(rr: Any, file: Path, table: Table, arm: ArmOfRun, fps: int, scene: Scene | None) -> int:
    stream = rr.RecordingStream("palpate", recording_id=table.name)
    stream.save(file)
    shown = _scene_of(arm) if scene is None else build(scene, until=0.0)
    for section, one in () if shown is None else zip(shown.scene.objects, shown.surfaces, strict=True):
        _object(rr, stream, section.name, one)
    X_WB = shown.arms.X_WB if shown is not None and isinstance(arm.ticks, BagTicks) else np.eye(4)
    _tool(rr, stream, frames_of(arm.ticks, min(fps, int(arm.ticks.rate))), X_WB)
    rows = 0
    for ticks in table.blocks():
        time = [rr.TimeColumn("t", duration=ticks["t"])]
        for signal in table.signals[1:]:
            values = np.asarray(ticks[signal.name], dtype=np.float64)
            stream.send_columns(f"{signal.stage}/{signal.name}", time, rr.Scalars.columns(scalars=values))
        rows += len(ticks)
    stream.flush()
    stream.disconnect()
    return rows


def _scene_of(arm: ArmOfRun) -> Rig | None:
    """The scene of a record or bag, set up; None if it has none, or its files are gone."""
    ticks = arm.ticks
    try:
        if isinstance(ticks, Record):
            return build(recorded_scene(ticks), until=0.0)
        return build(Scene.parse(ticks.scene, arm.name), until=0.0) if ticks.scene else None
    except PalpateError:
        return None


def _object(rr: Any, stream: Any, name: str, one: PlacedSurface) -> None:
    """An object of the scene at rest."""
    vertices = one.body.vertices @ one.X_WO[:3, :3].T + one.X_WO[:3, 3]
    mesh = rr.Mesh3D(vertex_positions=vertices, triangle_indices=one.body.triangles, albedo_factor=(*_SKIN, 255))
    stream.log(f"world/{rr.escape_entity_path_part(name)}", mesh, static=True)


def _tool(rr: Any, stream: Any, frames: ArmFrames, X_WA: Array) -> None:
    """The tool, its path and its force, of poses in axes whose pose in W is X_WA (4, 4)."""
    time = [rr.TimeColumn("t", duration=frames.t)]
    tip, turn = frames.pose[:, :3] @ X_WA[:3, :3].T + X_WA[:3, 3], Rotation.from_matrix(X_WA[:3, :3])
    force = FORCE_SCALE * np.nan_to_num(frames.wrench[:, :3]) @ X_WA[:3, :3].T
    known = np.isfinite(frames.pose).all(axis=1)
    quaternions = np.full((len(frames), 4), np.nan)
    quaternions[known] = (turn * Rotation.from_quat(frames.pose[known, 3:])).as_quat()
    stream.log("world/path", rr.LineStrips3D([tip], colors=[_GREY]), static=True)
    pose = rr.Transform3D.columns(translation=tip, quaternion=quaternions)
    stream.send_columns("world/tool", time, pose)
    stream.log("world/tool", rr.Points3D([[0.0, 0.0, 0.0]], radii=[0.002], colors=[_GREY]), static=True)
    stream.send_columns("world/force", time, rr.Arrows3D.columns(origins=tip, vectors=force))
    stream.log("world/force", rr.Arrows3D.from_fields(colors=[_GREEN], radii=[0.0006]), static=True)
