"""Rerun: every signal as a series, and the objects, the tool, its path and its force in 3-D."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from palpate.errors import PalpateError
from palpate.export.bag_ticks import BagTicks
from palpate.export.demonstration import ArmOfRun, Demonstration
from palpate.export.frames import ArmFrames, frames_of
from palpate.export.options import Options
from palpate.export.tables import Table, tables, told
from palpate.record.reader import Record

FORCE_SCALE = 0.012
"""Length of a force arrow [m/N], as in the surgeon's view."""
_GREEN, _GREY, _SKIN = (40, 210, 80), (120, 120, 130), (190, 120, 110)


def write(runs: Sequence[Demonstration], folder: Path, options: Options) -> dict[str, Any]:
    """Write an .rrd file for each arm; `rerun FILE` shows it.

    Raises:
        PalpateError: rerun-sdk is not installed.
    """
    rr = _library()
    arms = [arm for run in runs for arm in run.arms]
    written = []
    for table, arm in zip(tables(runs, options), arms, strict=True):
        file = folder / f"{table.name}.rrd"
        rows = _write(rr, file, table, arm, options.fps)
        written.append((table, file, rows))
    return told(written)


def _library() -> Any:
    try:
        import rerun
    except ImportError:
        mend = "pip install rerun-sdk (0.7 GB; no extra of palpate holds it)"
        raise PalpateError("rerun-sdk is not installed", mend=mend) from None
    return rerun


def _write(rr: Any, file: Path, table: Table, arm: ArmOfRun, fps: int) -> int:
    stream = rr.RecordingStream("palpate", recording_id=table.name)
    stream.save(file)
    _objects(rr, stream, arm.ticks)
    _tool(rr, stream, frames_of(arm.ticks, min(fps, int(arm.ticks.rate))))
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


def _objects(rr: Any, stream: Any, ticks: Record | BagTicks) -> None:
    """The objects of the scene of a record at rest; none if the record has no scene, or its files are gone."""
    if not isinstance(ticks, Record):
        return
    from palpate.scene.surface import placed
    from palpate.session.recorded import recorded_scene

    try:
        scene = recorded_scene(ticks)
        surfaces = placed(scene)
    except PalpateError:
        return
    for section, one in zip(scene.objects, surfaces, strict=True):
        vertices = one.body.vertices @ one.X_WO[:3, :3].T + one.X_WO[:3, 3]
        mesh = rr.Mesh3D(vertex_positions=vertices, triangle_indices=one.body.triangles, albedo_factor=(*_SKIN, 255))
        stream.log(f"world/{rr.escape_entity_path_part(section.name)}", mesh, static=True)


def _tool(rr: Any, stream: Any, frames: ArmFrames) -> None:
    time = [rr.TimeColumn("t", duration=frames.t)]
    tip, force = frames.pose[:, :3], FORCE_SCALE * np.nan_to_num(frames.wrench[:, :3])
    stream.log("world/path", rr.LineStrips3D([tip], colors=[_GREY]), static=True)
    pose = rr.Transform3D.columns(translation=tip, quaternion=frames.pose[:, 3:])
    stream.send_columns("world/tool", time, pose)
    stream.log("world/tool", rr.Points3D([[0.0, 0.0, 0.0]], radii=[0.002], colors=[_GREY]), static=True)
    stream.send_columns("world/force", time, rr.Arrows3D.columns(origins=tip, vectors=force))
    stream.log("world/force", rr.Arrows3D.from_fields(colors=[_GREEN], radii=[0.0006]), static=True)
