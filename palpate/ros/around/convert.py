"""Converts arrays to ROS messages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.so3 import quaternions

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


def transforms(edges: Sequence[tuple[str, str, Array]], stamp: Any) -> list[Any]:
    """Parent, child and pose (4, 4) of each frame as geometry_msgs/TransformStamped; poses must be finite.

    All rotations are converted at once, which takes half the time of one by one.
    """
    from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
    from std_msgs.msg import Header

    if not edges:
        return []
    poses = np.array([X for _, _, X in edges])
    rows = np.hstack([poses[:, :3, 3], quaternions(poses[:, :3, :3])]).tolist()  # position, then w x y z
    return [
        TransformStamped(
            header=Header(stamp=stamp, frame_id=parent),
            child_frame_id=child,
            transform=Transform(translation=Vector3(x=px, y=py, z=pz), rotation=Quaternion(x=x, y=y, z=z, w=w)),
        )
        for (parent, child, _), (px, py, pz, w, x, y, z) in zip(edges, rows, strict=True)
    ]


def is_heard(publisher: Any) -> bool:
    """Whether anybody subscribes to a topic: messages that are made 30 times a second cost a tenth of a core."""
    return bool(publisher.get_subscription_count())


def latched() -> Any:
    """Quality of service for messages that late subscribers also receive."""
    from rclpy.qos import DurabilityPolicy, QoSProfile

    return QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
