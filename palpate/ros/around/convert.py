"""Numbers to messages."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.arrays import Array

WORLD = "palpate_world"
"""Name of the frame W of the scene."""


def point(p: Array) -> Any:
    """(3,) as geometry_msgs/Point."""
    from geometry_msgs.msg import Point

    return Point(x=float(p[0]), y=float(p[1]), z=float(p[2]))


def vector(p: Array) -> Any:
    """(3,) as geometry_msgs/Vector3."""
    from geometry_msgs.msg import Vector3

    return Vector3(x=float(p[0]), y=float(p[1]), z=float(p[2]))


def pose(p: Array, wxyz: Array) -> Array:
    """Position (3,) and quaternion (4,) w x y z as a matrix (4, 4); no turn where the quaternion is none."""
    X = np.eye(4)
    X[:3, 3] = p
    if np.linalg.norm(wxyz) > 0.5:
        X[:3, :3] = Rotation.from_quat(np.asarray(wxyz)[[1, 2, 3, 0]]).as_matrix()
    return X


def transform(parent: str, child: str, X: Array, stamp: Any) -> Any:
    """(4, 4) as geometry_msgs/TransformStamped."""
    from geometry_msgs.msg import Quaternion, Transform, TransformStamped
    from std_msgs.msg import Header

    x, y, z, w = (float(c) for c in Rotation.from_matrix(X[:3, :3]).as_quat())
    turned = Transform(translation=vector(X[:3, 3]), rotation=Quaternion(x=x, y=y, z=z, w=w))
    return TransformStamped(header=Header(stamp=stamp, frame_id=parent), child_frame_id=child, transform=turned)


def latched() -> Any:
    """Quality of service of what a late listener must hear, too."""
    from rclpy.qos import DurabilityPolicy, QoSProfile

    return QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
