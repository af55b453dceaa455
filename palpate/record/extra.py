"""Messages of a record in addition to its signals: frames, models of the arms and meshes, for 3-D viewers.

Standard messages of ROS 2, so that Foxglove's 3-D panel and RViz show the run without Palpate: /tf and /tf_static,
`std_msgs/String` with the URDF of each arm, and `visualization_msgs/MarkerArray` with arms and objects.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array, so3
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

    def transforms(self, ticks: Ticks) -> dict[tuple[str, str], Array]:
        """Poses (n, 4, 4) [m] of each child frame in its parent at ticks (n,), by (parent, child).

        The frames are always the same, and there is at least one tick.
        """
        ...


def transform_message(poses: Mapping[tuple[str, str], Array], time_ns: int = 0) -> bytes:
    """A `tf2_msgs/TFMessage` with the pose (4, 4) of each child in its parent, by (parent, child)."""
    stacked = np.array(list(poses.values())).reshape(1, -1, 4, 4)
    return TransformTemplate(tuple(poses)).messages(stacked, np.array([time_ns]))[0]


def poses_of(message: bytes) -> dict[str, Array]:
    """Position [m] and quaternion w x y z (7,) of each child of a message of `transform_message`.

    Raises ValueError for a message of another layout.
    """
    body, at = memoryview(message)[4:], 4
    found: dict[str, Array] = {}

    def text() -> str:
        nonlocal at
        at = -(-at // 4) * 4
        (length,) = np.frombuffer(body, "<u4", 1, at).tolist()
        at += 4 + length
        return bytes(body[at - length : at - 1]).decode()

    for _ in range(int(np.frombuffer(body, "<u4", 1, 0)[0])):
        at = -(-at // 4) * 4 + 8  # the stamp
        text()
        child = text()
        at = -(-at // 8) * 8
        p, (x, y, z, w) = np.frombuffer(body, "<f8", 3, at), np.frombuffer(body, "<f8", 4, at + 24)
        found[child] = np.r_[p, w, x, y, z]
        at += 56
    return found


class TransformTemplate:
    """Serialises `tf2_msgs/TFMessage`s of constant frames: names are laid out once, numbers are filled in."""

    def __init__(self, frames: tuple[tuple[str, str], ...]) -> None:
        message = Cdr().number("I", len(frames))
        self._stamps: list[int] = []  # position of each frame's time [bytes]
        self._poses: list[int] = []  # and of its pose
        for parent, child in frames:
            message.number("i", 0)
            self._stamps.append(message.end - 4)
            message.number("I", 0).text(parent).text(child).pose(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
            self._poses.append(message.end - 56)
        self._bytes = np.frombuffer(bytes(message), np.uint8)

    def messages(self, poses: Array, times_ns: NDArray[np.integer]) -> list[bytes]:
        """The message of each of the poses (n, frames, 4, 4) at its time (n,) [ns]."""
        data = np.tile(self._bytes, (len(poses), 1))
        times = np.stack(np.divmod(times_ns, 10**9), axis=1).astype("<u4").view(np.uint8)
        numbers = np.concatenate([poses[..., :3, 3], np.roll(so3.quaternions(poses[..., :3, :3]), -1, axis=-1)], -1)
        filled = np.ascontiguousarray(numbers, "<f8").view(np.uint8)  # x y z, then the quaternion x y z w
        for k, (stamp, place) in enumerate(zip(self._stamps, self._poses, strict=True)):
            data[:, stamp : stamp + 8] = times
            data[:, place : place + 56] = filled[:, k]
        return [row.tobytes() for row in data]


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
