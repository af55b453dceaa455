"""A simulated depth camera on ROS 2: cloud, depth image, camera_info and the camera's frame."""

from __future__ import annotations

import array
import os
import time
from typing import Any

import numpy as np

from palpate.base.errors import SceneError
from palpate.record.ticks import as_ticks
from palpate.ros.around.convert import WORLD, latched, transforms
from palpate.scene.rig import build
from palpate.scene.scene import Scene
from palpate.sensing import messages
from palpate.sensing.make import make
from palpate.sensing.ros_cloud import import_rclpy
from palpate.sensing.simulated import SimulatedCameraSource


class CameraNode:
    """Publishes a simulated camera of a scene under `prefix`: `depth/points`, `depth/image_rect_raw` (metres) and
    `depth/camera_info`, with the quality of service for sensor data; the frame of the camera on /tf_static, or on /tf
    if a tracker moves it. The objects move as the scene says; the instrument rests at its start.

    Args:
        scene: the scene.
        name: the camera, a key of the scene's section `sensors`; the first simulated one when empty.
        prefix: first part of the topics.
        network: communicate with other machines; otherwise only within this one.

    Raises:
        SceneError: the scene has no such camera. MissingExtraError: ROS 2 is not installed.
    """

    def __init__(self, scene: Scene, name: str = "", prefix: str = "/camera", network: bool = False) -> None:
        simulated = [key for key, one in scene.sensors.items() if one.simulated is not None]
        if (name or "") not in ("", *simulated) or not simulated:
            mend = f"simulated cameras: {', '.join(simulated) or 'none; add sensors: {camera: {simulated: {}}}'}"
            raise SceneError(f"there is no simulated camera {name!r}", where=scene.where("sensors"), mend=mend)
        self.name = name or simulated[0]
        self.rate = scene.sensors[self.name].rate  #: [Hz]
        self.frame = f"palpate_sensor_{self.name}"  #: name of the optical frame
        self.topic = f"{prefix.rstrip('/')}/depth/points"
        self._rig = build(scene)
        self._row = np.zeros_like(np.asarray(self._rig.simulation().latest()).reshape(1, -1))
        self._t = 0.0
        source = make(self._rig, self.name, self._latest)
        assert isinstance(source, SimulatedCameraSource)
        self._source = source
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SUBNET" if network else "LOCALHOST"
        self._open(import_rclpy(), prefix.rstrip("/"))
        self.frames = 0  #: number of published frames

    def _open(self, rclpy: Any, prefix: str) -> None:
        from rclpy.context import Context
        from rclpy.qos import qos_profile_sensor_data
        from sensor_msgs.msg import CameraInfo, Image, PointCloud2
        from tf2_msgs.msg import TFMessage

        self._rclpy, self._context = rclpy, Context()
        rclpy.init(context=self._context)
        self._node = rclpy.create_node(f"palpate_camera_{os.getpid()}", context=self._context, enable_rosout=False)
        make_publisher = self._node.create_publisher
        self._cloud = make_publisher(PointCloud2, self.topic, qos_profile_sensor_data)
        self._image = make_publisher(Image, f"{prefix}/depth/image_rect_raw", qos_profile_sensor_data)
        self._info = make_publisher(CameraInfo, f"{prefix}/depth/camera_info", qos_profile_sensor_data)
        live = any(s.tracker is not None for s in self._rig.scene.frames)
        self._tf = make_publisher(TFMessage, "/tf" if live else "/tf_static", 10 if live else latched())
        self._is_live, self._is_told = live, False

    def run(self, duration: float | None = None) -> None:
        """Publish until the duration [s] is over, or until Ctrl-C."""
        began = time.monotonic()
        while duration is None or time.monotonic() - began < duration:
            self._t = time.monotonic() - began
            self.step(self._t)
            time.sleep(max(0.0, (self.frames + 1) / self.rate - (time.monotonic() - began)) % (1.0 / self.rate) + 1e-4)

    def step(self, t: float) -> None:
        """Publish the frame of the time t [s] if its time has come."""
        self._t = t
        frame = self._source.latest(t)
        if frame is None:
            return
        stamp = self._node.get_clock().now().to_msg()
        if self._is_live or not self._is_told:
            from tf2_msgs.msg import TFMessage

            self._tf.publish(TFMessage(transforms=transforms([(WORLD, self.frame, frame.X_WC)], stamp)))
            self._is_told = True
        self._cloud.publish(self._cloud_message(stamp))
        self._publish_image(stamp)
        self.frames += 1

    def close(self) -> None:
        """Remove the node from the network."""
        self._node.destroy_node()
        self._rclpy.shutdown(context=self._context)

    def _latest(self) -> Any:
        tick = as_ticks(self._row)[0]
        tick["t"] = self._t
        return tick

    def _header(self, stamp: Any) -> Any:
        from std_msgs.msg import Header

        return Header(stamp=stamp, frame_id=self.frame)

    def _cloud_message(self, stamp: Any) -> Any:
        from sensor_msgs.msg import PointCloud2, PointField

        picture = self._source.picture
        assert picture is not None
        fields, step, data = messages.fields_of(picture.points, picture.colors)
        rows, columns = picture.depth.shape
        made = PointCloud2(header=self._header(stamp), height=rows, width=columns, point_step=step, is_dense=False)
        made.row_step = step * columns
        made.fields = [PointField(name=n, offset=o, datatype=k, count=c) for n, o, k, c in fields]
        made.data = array.array("B", data.tobytes())
        return made

    def _publish_image(self, stamp: Any) -> None:
        from sensor_msgs.msg import CameraInfo, Image

        picture, lens = self._source.picture, self._source.camera.lens
        assert picture is not None
        image = Image(header=self._header(stamp), height=lens.rows, width=lens.columns, encoding="32FC1")
        image.step = 4 * lens.columns
        image.data = array.array("B", np.ascontiguousarray(picture.depth).tobytes())
        self._image.publish(image)
        info = CameraInfo(header=self._header(stamp), height=lens.rows, width=lens.columns)
        info.distortion_model, info.d = "plumb_bob", [0.0] * 5
        info.k, info.r = lens.K.ravel().tolist(), np.eye(3).ravel().tolist()
        info.p = np.c_[lens.K, np.zeros(3)].ravel().tolist()
        self._info.publish(info)
