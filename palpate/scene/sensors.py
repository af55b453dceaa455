"""Section of the scene file for depth cameras: simulated, replayed, or on ROS 2."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, model_validator

from palpate.base.values import NotNegative, Pose, Positive, Section
from palpate.scene.stability import Share

Pixels = Annotated[int, Field(strict=True, ge=8, le=2048)]


class SimulatedCameraSection(Section):
    """A simulated depth camera that sees the real objects of the scene, and the follower's instrument in front of them.

    The errors are those of a Kinect; noise and steps grow with the square of the depth (docs/camera.md).
    """

    columns: Pixels = 640
    """width of the image [pixel]"""
    rows: Pixels = 480
    """height of the image [pixel]"""
    width_deg: Annotated[Positive, Field(lt=170.0)] = 62.7
    """horizontal angle of view [deg]"""
    near: Positive = 0.2
    """smallest measured depth [m]"""
    far: Annotated[Positive, Field(le=20.0)] = 4.0
    """largest measured depth [m]"""
    noise_mm: Annotated[NotNegative, Field(le=100.0)] = 1.425
    """standard deviation of the depth at 1 m [mm]"""
    step_mm: Annotated[NotNegative, Field(le=100.0)] = 2.85
    """step between neighbouring depth values at 1 m; 0: no steps [mm]"""
    dropout: Share = 0.01
    """fraction of the pixels without a measurement [-]"""
    flying: Share = 0.3
    """fraction of the pixels at a rim that lie between the object and what is behind it [-]"""
    instrument: bool = True
    """true: the camera also sees the follower, which hides what is behind it"""

    @model_validator(mode="after")
    def _check(self) -> SimulatedCameraSection:
        if self.near >= self.far:
            raise ValueError(f"near {self.near:g} m is not below far {self.far:g} m | give e.g. near: 0.2, far: 4")
        return self


def _topic(value: str) -> str:
    if re.fullmatch(r"(/[A-Za-z_]\w*)+", value):
        return value
    raise ValueError(f"{value!r} is not a topic | write an absolute name, such as /camera/depth/points")


class SensorSection(Section):
    """A depth camera: simulated, a recording, or a ROS 2 topic of sensor_msgs/PointCloud2."""

    simulated: SimulatedCameraSection | None = None
    """a simulated camera in the same process"""
    replay: str | None = None
    """instead: a folder of .pcd or .ply files, or a rosbag2 (.mcap, .db3 or its folder), relative to the scene file"""
    topic: Annotated[str, AfterValidator(_topic)] | None = None
    """instead: a topic of PointCloud2, such as /camera/depth/points; with replay: the topic in the bag"""
    unit: Literal["mm", "cm", "m", "in"] | None = None
    """unit of replayed files that state none"""
    repeat: bool = False
    """true: a recording begins again when it ends"""
    rate: Annotated[Positive, Field(le=120.0)] = 30.0
    """frames per second of a simulated camera, and of replayed files [Hz]"""
    pose: Pose | None = None
    """X_FC: pose of the camera's optical frame (z forward, x right, y down) in `frame`; for a topic without pose and
    frame, the transforms on /tf from palpate_world to the frame of the messages give it"""
    frame: str = "world"
    """frame of the scene's frames in which pose is given; with a frame and without pose, the camera is at that frame"""

    @model_validator(mode="after")
    def _check(self) -> SensorSection:
        given = [key for key in ("simulated", "replay") if getattr(self, key) is not None]
        if len(given) == 2 or not (given or self.topic) or (given == ["simulated"] and self.topic):
            count = " and ".join([*given, *(["topic"] if self.topic else [])]) or "no source"
            raise ValueError(
                f"{count} given | give one of simulated: {{}}, replay: FOLDER and topic: /camera/depth/points"
            )
        return self

    @property
    def by_tf(self) -> bool:
        """True if the pose of the camera comes from /tf."""
        return self.topic is not None and self.replay is None and self.pose is None and self.frame == "world"


def with_topics(data: Any) -> Any:
    """Values of a scene in which ``cloud: {topic: NAME}`` of an object has become a sensor with this name."""
    if not isinstance(data, dict) or not isinstance(data.get("objects"), (list, tuple)):
        return data
    objects, sensors = [], {}
    for obj in data["objects"]:
        cloud = obj.get("cloud") if isinstance(obj, dict) else None
        topic = cloud.get("topic") if isinstance(cloud, dict) else None
        if isinstance(topic, str) and isinstance(cloud, dict) and not {"file", "sample", "sensor"} & set(cloud):
            sensors[topic] = {"topic": topic}
            rest = {key: value for key, value in cloud.items() if key != "topic"}
            objects.append(obj | {"cloud": rest | {"sensor": topic}})
        else:
            objects.append(obj)
    given = data.get("sensors") or {}
    return data | {"objects": objects, "sensors": sensors | given} if sensors and isinstance(given, dict) else data
