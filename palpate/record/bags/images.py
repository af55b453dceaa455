"""Pictures of the cameras in a ROS 2 bag: sensor_msgs/Image or CompressedImage, with their CameraInfo."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.base.errors import MissingExtraError, RecordError
from palpate.record.bags.library import open_bag

_IMAGES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
_INFO = "sensor_msgs/msg/CameraInfo"
_CHANNELS = {"rgb8": (3, "rgb"), "bgr8": (3, "bgr"), "8UC3": (3, "bgr"), "rgba8": (4, "rgb"), "bgra8": (4, "bgr"),
             "mono8": (1, "mono"), "8UC1": (1, "mono")}  # fmt: skip
_CODECS = {b"\xff\xd8": "mjpeg", b"\x89P": "png"}
_MODELS = {"plumb_bob": "opencv_radtan", "rational_polynomial": "opencv_rational", "equidistant": "opencv_fisheye"}
_MOST = 8192  # pixels of a side
_SAME = 1e-6  # [s] times that count as equal


@dataclass(frozen=True)
class Shot:
    """A picture of a camera."""

    picture: NDArray[np.uint8]
    """(h, w, 3) red, green, blue."""
    stamp: int
    """Its stamp, in nanoseconds since 1970; the time of reception if it has none [ns]."""


def cameras(path: Path) -> dict[str, str]:
    """Topics with pictures by the side of the endoscope, ``left`` and ``right``; a single camera is ``left``.

    Of several topics of a side, `image_raw` comes before others. Depth pictures are left out.
    """
    with open_bag(path) as reader:
        found = sorted(
            (c.topic for c in reader.connections if c.msgtype in _IMAGES and "depth" not in c.topic),
            key=lambda name: ("image_raw" not in name, name),
        )
    sided = {side: [n for n in found if re.search(rf"(^|[/_]){side}([/_]|$)", n)] for side in ("left", "right")}
    if not any(sided.values()):
        return {"left": found[0]} if found else {}
    return {side: names[0] for side, names in sided.items() if names}


def intrinsics(path: Path, topics: dict[str, str]) -> dict[str, Any]:
    """Intrinsics of each side [pixels] and the distance of the eyes [m], as far as the bag holds a CameraInfo."""
    wanted = {_info_of(topic): side for side, topic in topics.items()}
    found: dict[str, Any] = {}
    with open_bag(path) as reader:
        there = [c for c in reader.connections if c.topic in wanted and c.msgtype == _INFO]
        for connection, _, data in reader.messages(connections=there) if there else ():
            side = wanted[connection.topic]
            if f"endoscope.{side}" in found:
                continue
            info = reader.deserialize(data, connection.msgtype)
            found[f"endoscope.{side}"] = {
                "fx": float(info.k[0]), "fy": float(info.k[4]), "cx": float(info.k[2]), "cy": float(info.k[5]),
                "width": int(info.width), "height": int(info.height),
                "distortion_model": _MODELS.get(info.distortion_model, str(info.distortion_model)),
                "distortion": [float(one) for one in info.d],
            }  # fmt: skip
            if side == "right" and info.p[0] and info.p[3]:
                found["baseline_m"] = -float(info.p[3]) / float(info.p[0])
            if len({key for key in found if key != "baseline_m"}) == len(topics):
                break
    return found


def shots(path: Path, topics: dict[str, str], times: Sequence[float]) -> Iterator[dict[str, Shot]]:
    """The newest picture of each side that had been received at rising times since the start of the bag [s].

    Before the first picture of a side, that one is given. A topic without pictures ends the iteration.

    Raises:
        RecordError: a picture cannot be decoded.
    """
    side_of = {topic: side for side, topic in topics.items()}
    decoder, newest, taken = _Shots(path), {}, 0  # type: _Shots, dict[str, tuple[Any, int]], int
    with open_bag(path) as reader:
        wanted = [c for c in reader.connections if c.topic in side_of]
        for connection, time, data in reader.messages(connections=wanted):
            t = 1e-9 * (time - reader.start_time)
            while taken < len(times) and times[taken] < t - _SAME and len(newest) == len(side_of):
                yield {side: decoder.shot(side, *one) for side, one in newest.items()}
                taken += 1
            newest[side_of[connection.topic]] = reader.deserialize(data, connection.msgtype), time
        for _ in range(taken, len(times) if len(newest) == len(side_of) else 0):
            yield {side: decoder.shot(side, *one) for side, one in newest.items()}


def _info_of(topic: str) -> str:
    """Topic of the CameraInfo beside a topic of pictures."""
    return topic.removesuffix("/compressed").rsplit("/", 1)[0] + "/camera_info"


class Decoder:
    """Makes pictures of messages of sensor_msgs/Image and CompressedImage, from a bag or a live topic.

    Args:
        where: where the messages come from, for errors.
    """

    def __init__(self, where: str) -> None:
        self._where = where
        self._codecs: dict[str, Any] = {}

    def rgb(self, message: Any) -> NDArray[np.uint8]:
        """The picture (h, w, 3) of a message.

        Raises:
            RecordError: it cannot be decoded. MissingExtraError: it is packed, and av is not installed.
        """
        try:
            return self._raw(message) if hasattr(message, "encoding") else self._packed(bytes(message.data))
        except (RecordError, MissingExtraError):
            raise
        except Exception as error:  # damaged pictures make the codecs raise many types of exception
            why = f"{type(error).__name__}: {error}"
            raise RecordError("a picture cannot be decoded", where=self._where, why=why) from error

    def _raw(self, message: Any) -> NDArray[np.uint8]:
        if message.encoding not in _CHANNELS:
            mend = f"convert the topic to one of {', '.join(_CHANNELS)}"
            raise RecordError(f"pictures of the encoding {message.encoding!r}", where=self._where, mend=mend)
        channels, order = _CHANNELS[message.encoding]
        self._require_size(message.width, message.height)
        rows = np.asarray(message.data, dtype=np.uint8).reshape(message.height, message.step)
        picture = rows[:, : channels * message.width].reshape(message.height, message.width, channels)
        return (
            np.repeat(picture, 3, axis=2)
            if order == "mono"
            else picture[:, :, :3][:, :, :: 1 if order == "rgb" else -1]
        )

    def _packed(self, data: bytes) -> NDArray[np.uint8]:
        try:
            import av
        except ImportError:
            raise MissingExtraError("av, which reads packed pictures,", "learning") from None
        name = _CODECS.get(data[:2])
        if name is None:
            what = f"packed pictures that begin with {data[:4]!r}"
            raise RecordError(what, where=self._where, mend="record JPEG or PNG, or the raw topic")
        codec = self._codecs.setdefault(name, av.CodecContext.create(name, "r"))
        frame = codec.decode(av.Packet(data))[0]  # type: ignore[attr-defined, unused-ignore]
        self._require_size(frame.width, frame.height)
        return np.asarray(frame.to_ndarray(format="rgb24"), dtype=np.uint8)

    def _require_size(self, width: int, height: int) -> None:
        if not (0 < width <= _MOST and 0 < height <= _MOST):
            raise RecordError(f"a picture of {width} x {height} pixels", where=self._where, mend=f"at most {_MOST}")


class _Shots:
    """Decodes messages; a message that is shown again is decoded once."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._decoders: dict[str, Decoder] = {}
        self._last: dict[str, tuple[Any, Shot]] = {}

    def shot(self, side: str, message: Any, time: int) -> Shot:
        if side not in self._last or self._last[side][0] is not message:
            stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            decoder = self._decoders.setdefault(side, Decoder(f"{self._path}, {side}"))
            picture = decoder.rgb(message)
            even = picture[: picture.shape[0] // 2 * 2, : picture.shape[1] // 2 * 2]  # a film has even sides
            self._last[side] = message, Shot(np.ascontiguousarray(even), stamp or time)
        return self._last[side][1]
