"""A depth camera on ROS 2: a topic of sensor_msgs/PointCloud2, with the camera's pose from the scene or from /tf."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from palpate.base import dds_security
from palpate.base.arrays import Array, so3
from palpate.base.errors import CloudError, MissingExtraError, PalpateError
from palpate.base.node_thread import NodeThread, remove, silence
from palpate.sensing import messages
from palpate.sensing.source import CloudFrame
from palpate.sensing.tf_tree import TfTree

WORLD = "palpate_world"
"""Name of the world frame W on /tf."""


class RosCloudSource:
    """The newest cloud of a topic, received with the quality of service for sensor data.

    The node listens in its own thread, on this machine unless the environment says otherwise
    (ROS_AUTOMATIC_DISCOVERY_RANGE), in the domain of the environment (ROS_DOMAIN_ID).

    Args:
        topic: name of the topic.
        X_WC: pose (4, 4) of the camera in W [m]; None: from /tf, from palpate_world to the frame of each message.

    Raises:
        MissingExtraError: ROS 2 is not installed. PalpateError: the name of the topic is invalid.
    """

    def __init__(self, topic: str, X_WC: Callable[[], Array] | None = None) -> None:
        rclpy = import_rclpy()
        from rclpy.context import Context

        self._X_WC, self._tf = X_WC, TfTree()
        self._newest: tuple[Any, float] | None = None  # message, time of arrival by the monotonic clock
        self.fault = ""  #: why the last message was not used
        self._topic = topic
        context = Context()
        rclpy.init(context=context)
        name = f"palpate_camera_{os.getpid()}_{id(self):x}"
        self._node: Any = rclpy.create_node(name, context=context, enable_rosout=False)
        try:
            self._subscribe(topic)
        except BaseException:
            remove(self._node, context)
            raise
        self._thread = NodeThread(self._node, context, "palpate-ros-cloud")
        self._thread.start()

    def latest(self, now: float) -> CloudFrame | None:
        """The newest message as a frame; its stamp becomes the time of its arrival by the session's clock.

        A message that cannot be used, or whose frame has no transform, is left out; `fault` says why.
        """
        taken, self._newest = self._newest, None
        if taken is None:
            return None
        message, arrived = taken
        header = message.header
        t = header.stamp.sec + 1e-9 * header.stamp.nanosec
        X_WC = self._tf.pose(header.frame_id, WORLD, t) if self._X_WC is None else self._X_WC()
        if X_WC is None:
            self.fault = f"no transform from {WORLD} to {header.frame_id!r} on /tf"
            return None
        try:
            decoded = messages.decode(message)
        except CloudError as error:
            self.fault = str(error)
            return None
        self.fault = ""
        return CloudFrame(decoded.points, now - (time.monotonic() - arrived), X_WC, decoded.colors)

    def heard(self) -> str:
        """Why no frame comes: the last message that was not used, or who publishes the topic."""
        return self.fault or silence(self._node, self._topic, "sensor_msgs/msg/PointCloud2")

    def close(self) -> None:
        """Remove the node from the network. No effect if it is closed."""
        self._thread.stop()

    def _subscribe(self, topic: str) -> None:
        from rclpy.exceptions import InvalidTopicNameException
        from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
        from sensor_msgs.msg import PointCloud2
        from tf2_msgs.msg import TFMessage

        def take(message: Any) -> None:
            self._newest = message, time.monotonic()

        def transforms(message: Any) -> None:
            for one in message.transforms:
                t = one.header.stamp.sec + 1e-9 * one.header.stamp.nanosec
                self._tf.add(one.header.frame_id, one.child_frame_id, _pose(one.transform), t)

        try:
            self._node.create_subscription(PointCloud2, topic, take, qos_profile_sensor_data)
        except InvalidTopicNameException as error:
            why, mend = " ".join(str(error).split()), "write /NAME/depth/points"
            raise PalpateError(f"{topic!r} is not the name of a topic", why=why, mend=mend) from None
        if self._X_WC is None:
            latched = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
            self._node.create_subscription(TFMessage, "/tf", transforms, 100)
            self._node.create_subscription(TFMessage, "/tf_static", transforms, latched)


def _pose(transform: Any) -> Array:
    """geometry_msgs/Transform as (4, 4); NaN if its quaternion is not one."""
    p, q = transform.translation, transform.rotation
    quaternion = np.array([q.w, q.x, q.y, q.z])
    length = float(np.linalg.norm(quaternion))
    if not 0.9 < length < 1.1:
        return np.full((4, 4), np.nan)
    return so3.pose(np.array([p.x, p.y, p.z]), quaternion / length)


def import_rclpy() -> Any:
    """The module rclpy; nodes stay on this machine unless the environment says otherwise.

    Raises:
        MissingExtraError: ROS 2 is not installed.
    """
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    dds_security.enforce()
    try:
        import rclpy
        from sensor_msgs.msg import PointCloud2  # noqa: F401
    except ImportError:
        raise MissingExtraError("ROS 2", "ros") from None
    try:
        from tf2_msgs.msg import TFMessage  # noqa: F401
    except ImportError:  # the wheels of ROS 2 do not contain it
        why = "the ros-* wheels lack this package, which palpate ros compiles on its first use"
        raise PalpateError("the messages of tf2_msgs are not built", why=why, mend="palpate ros setup") from None
    return rclpy
