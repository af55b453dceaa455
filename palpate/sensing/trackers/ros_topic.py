"""A tracker on ROS 2: PoseStamped topics, one for each tool, such as CRTK's measured_cp."""

from __future__ import annotations

import math
import os
from collections import deque
from collections.abc import Iterable, Mapping
from contextlib import suppress
from typing import Any

import numpy as np

from palpate.base import dds_security
from palpate.base.arrays import Array
from palpate.base.errors import MissingExtraError, PalpateError
from palpate.base.node_thread import NodeThread, remove, silence
from palpate.sensing.trackers.tracker import Sighting

_MOST = 64  # messages of all tools that wait for the next poll; older ones are dropped


def topics(pattern: str, tools: Iterable[str]) -> dict[str, str]:
    """Topic of each tool: the pattern with ``{tool}`` replaced by its name."""
    return {tool: pattern.replace("{tool}", tool) for tool in tools}


class RosTopicTracker:
    """Poses of geometry_msgs/PoseStamped topics [m]; the stamp zero marks a pose as invalid, as in CRTK.

    The node listens in its own thread, on this machine unless the environment says otherwise
    (ROS_AUTOMATIC_DISCOVERY_RANGE), in the domain of the environment (ROS_DOMAIN_ID).

    Args:
        topics: topic by the tool's name.

    Raises:
        MissingExtraError: ROS 2 is not installed. PalpateError: a topic's name is invalid.
    """

    def __init__(self, topics: Mapping[str, str]) -> None:
        rclpy = _rclpy()
        from rclpy.context import Context

        self._seen: deque[Sighting] = deque(maxlen=_MOST)
        self._topics = dict(topics)
        context = Context()
        rclpy.init(context=context)
        name = f"palpate_tracker_{os.getpid()}_{id(self):x}"
        self._node: Any = rclpy.create_node(name, context=context, enable_rosout=False)
        try:
            for tool, topic in topics.items():
                self._subscribe(tool, topic)
        except BaseException:
            remove(self._node, context)
            raise
        self._thread = NodeThread(self._node, context, "palpate-ros-tracker")
        self._thread.start()

    def poll(self, now: float) -> list[Sighting]:
        """Sightings that arrived since the last call, in their order."""
        found = []
        with suppress(IndexError):
            while True:
                found.append(self._seen.popleft())
        return found

    def heard(self, tool: str) -> str:
        """Why no pose of a tool comes: who publishes its topic."""
        topic = self._topics.get(tool)
        return "" if topic is None else silence(self._node, topic, "geometry_msgs/msg/PoseStamped")

    def close(self) -> None:
        """Remove the node from the network. No effect if it is closed."""
        self._thread.stop()

    def _subscribe(self, tool: str, topic: str) -> None:
        from geometry_msgs.msg import PoseStamped
        from rclpy.exceptions import InvalidTopicNameException
        from rclpy.qos import qos_profile_sensor_data

        def take(message: Any) -> None:
            self._seen.append(sighting(tool, message))

        try:
            self._node.create_subscription(PoseStamped, topic, take, qos_profile_sensor_data)
        except InvalidTopicNameException as error:
            why = " ".join(str(error).split())
            raise PalpateError(
                f"{topic!r} is not the name of a topic", why=why, mend="write /NAME/measured_cp"
            ) from None


def sighting(tool: str, message: Any) -> Sighting:
    """A PoseStamped message as a sighting. The norm of its quaternion stays, so that the gate refuses a wrong one."""
    p, q = message.pose.position, message.pose.orientation
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = _rotation(q.w, q.x, q.y, q.z), (p.x, p.y, p.z)
    t = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
    return Sighting(tool, X, t, math.nan, t > 0.0)


def _rotation(w: float, x: float, y: float, z: float) -> Array:
    """Rotation (3, 3) of a quaternion, times the square of its norm."""
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )


def _rclpy() -> Any:
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    dds_security.enforce()
    try:
        import rclpy
        from geometry_msgs.msg import PoseStamped  # noqa: F401
    except ImportError:
        raise MissingExtraError("ROS 2", "ros") from None
    return rclpy
