"""Messages of a record in addition to its signals: frames, models of the arms and meshes, for 3-D viewers.

Standard messages of ROS 2, so that Foxglove's 3-D panel and RViz show the run without Palpate: /tf and /tf_static,
`std_msgs/String` with the URDF of each arm, and `visualization_msgs/MarkerArray` with arms and objects.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from palpate.arrays import Array, so3
from palpate.record.cdr import Cdr
from palpate.record.ticks import Ticks

RATE = 25.0
"""Rate of /tf [Hz]: smooth to the eye, and small beside the signals."""
WORLD = "palpate_world"
"""Name of frame W on /tf, as in Palpate's ROS 2 nodes."""
TF, MARKERS, TEXT = "tf2_msgs/msg/TFMessage", "visualization_msgs/msg/MarkerArray", "std_msgs/msg/String"


class Extra(Protocol):
    """What a record holds in addition to its signals."""

    topics: dict[str, str]
    """Message type of each topic, except /tf."""

    def first(self) -> list[tuple[str, bytes]]:
        """Topic and serialised message of what does not change."""
        ...

    def transforms(self, tick: Ticks) -> dict[tuple[str, str], Array]:
        """Pose (4, 4) [m] of each child frame in its parent, by (parent, child); always the same frames."""
        ...


def transform_message(poses: Mapping[tuple[str, str], Array], time_ns: int = 0) -> bytes:
    """A `tf2_msgs/TFMessage` with the pose (4, 4) of each child in its parent, by (parent, child)."""
    return TransformTemplate(tuple(poses)).message(np.array(list(poses.values())).reshape(-1, 4, 4), time_ns)


class TransformTemplate:
    """Serialises a `tf2_msgs/TFMessage` of constant frames: names are laid out once, numbers are filled in."""

    def __init__(self, frames: tuple[tuple[str, str], ...]) -> None:
        message = Cdr().number("I", len(frames))
        self._places: list[tuple[int, int]] = []  # of stamp and pose [bytes]
        for parent, child in frames:
            message.number("i", 0)
            stamp = message.end - 4
            message.number("I", 0).text(parent).text(child).pose(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
            self._places.append((stamp, message.end - 56))
        self._bytes = bytes(message)

    def message(self, poses: Array, time_ns: int) -> bytes:
        """The message for poses (n, 4, 4) at a time [ns]."""
        data = bytearray(self._bytes)
        quat = so3.quaternions(poses[:, :3, :3]) if len(poses) else np.zeros((0, 4))
        for (stamp, place), X, (w, x, y, z) in zip(self._places, poses, quat, strict=True):
            struct.pack_into("<iI", data, stamp, *divmod(time_ns, 10**9))
            struct.pack_into("<7d", data, place, *X[:3, 3], x, y, z, w)
        return bytes(data)


@dataclass(frozen=True)
class Marker:
    """A `visualization_msgs/Marker` that stays for ever and follows its frame."""

    frame: str
    namespace: str
    kind: int
    """1: cube, 2: sphere, 3: cylinder along z, 11: list of triangles."""
    color: tuple[float, float, float, float]
    """Red, green, blue, opacity, from 0 to 1."""
    X: Array = field(default_factory=lambda: np.eye(4))
    """(4, 4) pose in the frame [m]."""
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Lengths along the axes [m]; 1 for triangles."""
    points: Array = field(default_factory=lambda: np.zeros((0, 3)))
    """(3 m, 3) corners of the triangles [m]."""


def marker_message(markers: list[Marker]) -> bytes:
    """A `visualization_msgs/MarkerArray`."""
    message = Cdr().number("I", len(markers))
    for number, one in enumerate(markers):
        message.number("i", 0).number("I", 0).text(one.frame).text(one.namespace).number("i", number, one.kind, 0)
        message.pose(one.X[:3, 3], so3.quaternions(one.X[None, :3, :3])[0]).number("d", *one.scale)
        message.number("f", *one.color).number("i", 0).number("I", 0).number("B", 1)  # lifetime for ever, frame locked
        message.points(one.points).number("I", 0)  # no colours of points
        message.text("").number("i", 0).number("I", 0).text("").text("").number("I", 0)  # no texture
        message.number("I", 0).text("").text("").text("").number("I", 0).number("B", 0)  # no uv, text, mesh file
    return bytes(message)


def text_message(text: str) -> bytes:
    """A `std_msgs/String`."""
    return bytes(Cdr().text(text))
