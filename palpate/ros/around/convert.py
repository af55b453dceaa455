"""Converts arrays to ROS messages."""

from __future__ import annotations

from typing import Any

from palpate.arrays import Array
from palpate.arrays.so3 import quaternions

WORLD = "palpate_world"
"""ROS name of the world frame W."""


def point(p: Array) -> Any:
    """(3,) as geometry_msgs/Point."""
    from geometry_msgs.msg import Point

    return Point(x=float(p[0]), y=float(p[1]), z=float(p[2]))


def vector(p: Array) -> Any:
    """(3,) as geometry_msgs/Vector3."""
    from geometry_msgs.msg import Vector3

    return Vector3(x=float(p[0]), y=float(p[1]), z=float(p[2]))


def transform(parent: str, child: str, X: Array, stamp: Any) -> Any:
    """(4, 4) as geometry_msgs/TransformStamped."""
    from geometry_msgs.msg import Quaternion, Transform, TransformStamped
    from std_msgs.msg import Header

    w, x, y, z = (float(c) for c in quaternions(X[:3, :3]))
    pose = Transform(translation=vector(X[:3, 3]), rotation=Quaternion(x=x, y=y, z=z, w=w))
    return TransformStamped(header=Header(stamp=stamp, frame_id=parent), child_frame_id=child, transform=pose)


def latched() -> Any:
    """Quality of service for messages that late subscribers also receive."""
    from rclpy.qos import DurabilityPolicy, QoSProfile

    return QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
