"""What a record holds at a low rate beside its signals: the shape of soft objects, the joints of the endoscope arm, the
poses of rigid bodies, and frames of sensors.

A shape is `std_msgs/Int16MultiArray`: the displacement of every vertex from rest in units of `QUANTUM`, rows x y z, in
the object's frame O. The joints are `sensor_msgs/JointState`, the poses are frames on /tf, and a frame of a sensor is
`sensor_msgs/PointCloud2` with the pose of the camera on /tf. The record's compression
makes the shapes small, since most of a surface is at rest.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.record.cdr import Cdr

RATE = 25.0
"""Rate of the snapshots [Hz]: smooth to the eye."""
QUANTUM = 2e-5
"""Unit of a stored displacement [m]: the vertex is at most 0.87 of it away, half a unit along each axis."""
POINTS = "sensor_msgs/msg/PointCloud2"
SHAPE, JOINTS = "std_msgs/msg/Int16MultiArray", "sensor_msgs/msg/JointState"
CAMERA = "/scene/camera/joints"
SHAPES, SENSORS = "/scene/shape/", "/sensors/"
FRAMES = "/tf"
BODY, SENSOR = "palpate_body_", "palpate_sensor_"
"""Begin of the name of a body's frame, and of a sensor's."""
CLOUD_QUANTUM = 2.0**-15
"""Unit to which the points of a sensor are rounded [m]: 0.03 mm, so that they need half the space."""
_FARTHEST = 32767 * QUANTUM  # largest displacement [m]
_HEAD = 4  # bytes before the body of a message


def topic_of(name: str) -> str:
    """Topic of a soft object's shape; characters that a ROS name cannot have become underscores."""
    return SHAPES + _ros_name(name)


def cloud_topic(name: str) -> str:
    """Topic of the frames of the sensor that an object is the cloud of."""
    return f"{SENSORS}{_ros_name(name)}/points"


def _ros_name(name: str) -> str:
    return "".join(c if c.isascii() and (c.isalnum() or c == "_") else "_" for c in name)


@dataclass(frozen=True)
class Snapshot:
    """One message."""

    t: float  # of the newest tick [s]
    topic: str
    data: bytes


def shape_message(moved: Array) -> bytes:
    """The message of displacements (n, 3) [m]; those beyond 0.65 m are stored as 0.65 m."""
    units = np.rint(np.clip(np.nan_to_num(moved), -_FARTHEST, _FARTHEST) / QUANTUM).astype("<i2")
    message = Cdr().number("I", 2).text("vertex").number("I", len(units), units.size)
    message.text("axis").number("I", 3, 3).number("I", 0, units.size)
    return bytes(message) + units.tobytes()


def shape_of(message: bytes) -> npt.NDArray[np.int16]:
    """Displacements (n, 3) in units of `QUANTUM` of a message of `shape_message`.

    Raises ValueError for a message of another layout.
    """
    count = int(np.frombuffer(message, "<u4", 1, len(shape_message(np.empty((0, 3)))) - 4)[0])
    return np.frombuffer(message, "<i2", count, len(message) - 2 * count).reshape(-1, 3)


def cloud_message(
    t: float,
    frame: str,
    size: tuple[int, int],
    fields: list[tuple[str, int, int, int]],
    step: int,
    data: npt.NDArray[np.uint8],
) -> bytes:
    """The message of a cloud, measured at a time [s].

    Args:
        t: time.
        frame: name of the camera's frame.
        size: rows and columns.
        fields: name, offset, datatype and count of each field of a point.
        step: size of a point [bytes].
        data: the points.
    """
    rows, columns = size
    sec, nanosec = divmod(round(1e9 * t), 10**9)
    message = Cdr().number("i", sec).number("I", nanosec).text(frame).number("I", rows, columns, len(fields))
    for name, offset, datatype, count in fields:
        message.text(name).number("I", offset).number("B", datatype).number("I", count)
    message.number("B", 0).number("I", step, step * columns, data.size)
    return bytes(message) + data.tobytes() + b"\x00"  # not dense: a camera does not see everything


def joints_message(t: float, names: tuple[str, ...], q: Array) -> bytes:
    """The message of joint positions q (n,) at a time [s]."""
    before, after = _around_joints(names, len(q))
    stamp = struct.pack("<iI", *divmod(round(1e9 * t), 10**9))
    return before[:_HEAD] + stamp + before[_HEAD + len(stamp) :] + q.astype("<f8").tobytes() + after


@cache
def _around_joints(names: tuple[str, ...], n: int) -> tuple[bytes, bytes]:
    """The bytes of a message before and after the positions, with a stamp of zero."""
    message = Cdr().number("i", 0).number("I", 0).text("").number("I", len(names))
    for name in names:
        message.text(name)
    message.number("I", n).number("d", *[0.0] * n)
    end = message.end
    whole = bytes(message.number("I", 0).number("I", 0))
    return whole[: end - 8 * n], whole[end:]


def joints_of(message: bytes) -> Array:
    """Joint positions (n,) of a message of `joints_message`."""
    body, at = memoryview(message)[_HEAD:], 8
    length = int(np.frombuffer(body, "<u4", 1, at)[0])
    at = -(-(at + 4 + length) // 4) * 4
    count = int(np.frombuffer(body, "<u4", 1, at)[0])
    at += 4
    for _ in range(count):
        at = -(-at // 4) * 4
        at += 4 + int(np.frombuffer(body, "<u4", 1, at)[0])
    at = -(-at // 4) * 4
    count = int(np.frombuffer(body, "<u4", 1, at)[0])
    return np.frombuffer(body, "<f8", count, -(-(at + 4) // 8) * 8).astype(float)


@dataclass(frozen=True)
class Track:
    """A quantity over time, from its snapshots."""

    t: Array
    """(k,) ascending [s]."""
    values: Any
    """(k, ...) in `unit`: an array, or what reads one of them at a time and becomes an array of all."""
    unit: float = 1.0

    def at(self, t: float) -> Array:
        """The value at a time [s], linear between two snapshots and constant before the first and after the last."""
        after = int(np.searchsorted(self.t, t))
        before = max(after - 1, 0)
        after = min(after, len(self.t) - 1)
        span = float(self.t[after] - self.t[before])
        share = 0.0 if span <= 0.0 else min(max((t - float(self.t[before])) / span, 0.0), 1.0)
        first, second = np.asarray(self.values[before], float), np.asarray(self.values[after], float)
        return np.asarray(self.unit * ((1.0 - share) * first + share * second))

    @property
    def rate(self) -> float:
        """Snapshots per second; zero for a single one."""
        gaps = [b - a for a, b in pairwise(self.t.tolist())]
        return 1.0 / float(np.median(gaps)) if gaps else 0.0


@dataclass(frozen=True)
class BodyTrack:
    """Poses of rigid bodies over time."""

    names: tuple[str, ...]
    track: Track
    """Values (k, n, 7): positions [m] and quaternions w x y z in W, those of a body without changes of sign."""

    def at(self, t: float) -> dict[str, Array]:
        """Position [m] and unit quaternion w x y z (7,) of each body at a time [s]."""
        found = self.track.at(t)
        found[:, 3:] /= np.maximum(np.linalg.norm(found[:, 3:], axis=1, keepdims=True), 1e-9)
        return dict(zip(self.names, found, strict=True))
