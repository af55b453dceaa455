"""The sources of clouds of a scene's section `sensors`."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import CloudError, FrameError, SceneError
from palpate.record.ticks import Ticks
from palpate.scene.rig import Rig
from palpate.sensing.source import CloudSource


def make(rig: Rig, name: str, latest: Callable[[], Ticks]) -> CloudSource:
    """The source `name` of a rig.

    Args:
        rig: the rig, whose frames carry the camera.
        name: a key of the scene's section `sensors`.
        latest: the newest tick, by which a simulated camera sees the objects and the instrument.

    Raises:
        SceneError: there is no such sensor, its frame is unknown, or its recording cannot be read.
        MissingExtraError: a part that the sensor needs is not installed.
    """
    scene = rig.scene
    if name not in scene.sensors:
        names = ", ".join(scene.sensors) or "none"
        raise SceneError(f"there is no sensor {name!r}", where=scene.where("sensors"), mend=f"sensors: {names}")
    section, where = scene.sensors[name], scene.where("sensors", name)
    X_WC = camera_pose(rig, name)
    if section.simulated is not None:
        from palpate.sensing.simulated import SimulatedCameraSource
        from palpate.sensing.world import SeenWorld

        world = SeenWorld(rig, latest, section.simulated.instrument)
        return SimulatedCameraSource(world, section.simulated, section.rate, X_WC, scene.seed)
    if section.replay is not None:
        from palpate.sensing.replay import ReplaySource

        path = scene.path_to(section.replay, where)
        try:
            return ReplaySource(path, section.rate, section.unit, section.topic, X_WC, section.repeat)
        except CloudError as error:
            why = "; ".join(part for part in (error.where, error.why) if part)
            raise SceneError(error.what, where=where, why=why, mend=error.mend) from None
    from palpate.sensing.ros_cloud import RosCloudSource

    return RosCloudSource(section.topic or "", None if section.by_tf else X_WC)


def camera_pose(rig: Rig, name: str) -> Callable[[], Array]:
    """Function of the present pose X_WC (4, 4) of a sensor by the frames of the rig [m].

    Raises:
        SceneError: the sensor's frame does not exist.
    """
    section = rig.scene.sensors[name]
    X_FC = np.eye(4) if section.pose is None else section.pose.matrix()
    try:
        rig.frames.pose(section.frame)
    except FrameError as error:
        raise SceneError(error.what, where=rig.scene.where("sensors", name, "frame"), mend=error.mend) from None
    return partial(_pose, rig, section.frame, X_FC)


def _pose(rig: Rig, frame: str, X_FC: Array) -> Array:
    return np.asarray(rig.frames.pose(frame).X @ X_FC)
