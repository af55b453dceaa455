"""The remote camera as a topic of ROS 2: sensor_msgs/Image or CompressedImage, sent to the operator as JPEG."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

from palpate import ros
from palpate.base.errors import PalpateError
from palpate.record.bags.images import Decoder
from palpate.ros.background import BackgroundNode
from palpate.session.network.jpeg import packed, require_packer
from palpate.session.network.video import LARGEST, Picture, is_jpeg

KINDS = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
FASTEST = 30.0
"""Largest number of pictures per second that are packed as JPEG [Hz]."""
_FIND = 0.2  # [s] between two looks for a publisher
_SILENT = 3.0  # [s] without a picture after which that is told
_LATEST = 10.0  # [s] age from which a stamp is not believed: the camera's clock is another one


class RosPictures:
    """A topic of pictures, received with the quality of service for sensor data.

    The type of the messages is that of the publisher, which may come later. A JPEG picture passes as it is if it is
    small enough. Others are packed, with half of their pixels along each side as often as needed.

    Args:
        topic: name of the topic.
        network: whether ROS 2 communicates with other machines.

    Raises:
        PalpateError: the name is none of a topic, or ROS 2 is not installed.
        MissingExtraError: nothing here packs pictures as JPEG.
    """

    def __init__(self, topic: str, network: bool = False) -> None:
        require_packer()
        context = ros.load().Context(network=network)  # sets how far discovery reaches
        self._background = BackgroundNode("palpate_pictures", context.domain)
        self._node, self._decoder = self._background.node, Decoder(f"camera {topic}")
        self._topic = self._resolved(topic)
        self._kind = ""
        self._newest: tuple[Any, float] | None = None  # message, and the time of its arrival [s]
        self._came = threading.Event()

    def pictures(self, stopped: threading.Event, tell: Callable[[str], None]) -> Iterator[Picture]:
        """Yield the newest picture whenever one has come, until stopped; then leave the network."""
        self._background.spin()
        heard = due = time.monotonic()
        try:
            while not stopped.wait(max(due - time.monotonic(), 0.0)):
                if not self._kind:
                    self._subscribe()
                if not self._came.wait(_FIND):
                    if time.monotonic() - heard > _SILENT:
                        tell(f"camera {self._topic}: {self._silence()}")
                    continue
                heard = time.monotonic()
                due = heard + 1.0 / FASTEST
                if (picture := self._taken(tell)) is not None:
                    yield picture
        finally:
            self._background.close()

    def _taken(self, tell: Callable[[str], None]) -> Picture | None:
        self._came.clear()
        assert self._newest is not None
        message, arrived = self._newest
        try:
            return Picture(self._jpeg(message), arrived - age(message.header.stamp))
        except PalpateError as error:
            tell(str(error))
            return None

    def _jpeg(self, message: Any) -> bytes:
        if not hasattr(message, "encoding") and is_jpeg(data := bytes(message.data)):
            return data
        picture = self._decoder.rgb(message)
        while len(data := packed(picture)) > LARGEST:
            picture = picture[::2, ::2]
        return data

    def _resolved(self, topic: str) -> str:
        try:
            return str(self._node.resolve_topic_name(topic))
        except Exception as error:  # rclpy raises several types
            self._background.close()
            raise PalpateError(f"{topic!r} is not the name of a topic", why=" ".join(str(error).split()),
                               mend="write ros:/camera/image_raw") from None  # fmt: skip

    def _subscribe(self) -> None:
        """Subscribe as soon as somebody publishes pictures on the topic."""
        kinds = dict(self._node.get_topic_names_and_types()).get(self._topic, [])
        self._kind = next((one for one in kinds if one in KINDS), "")
        if not self._kind:
            return
        from rclpy.qos import qos_profile_sensor_data
        from sensor_msgs.msg import CompressedImage, Image

        kind = Image if self._kind == KINDS[0] else CompressedImage
        self._node.create_subscription(kind, self._topic, self._take, qos_profile_sensor_data)

    def _take(self, message: Any) -> None:
        self._newest = message, time.monotonic()
        self._came.set()

    def _silence(self) -> str:
        kinds = dict(self._node.get_topic_names_and_types()).get(self._topic, [])
        if kinds and not any(one in KINDS for one in kinds):
            return f"it carries {', '.join(kinds)}, and pictures are {' or '.join(KINDS)}"
        return "no picture comes" if self._node.count_publishers(self._topic) else "nobody publishes it"


def age(stamp: Any) -> float:
    """Time since a stamp of the system's clock [s]; 0 for one of another clock."""
    past = time.time() - (stamp.sec + 1e-9 * stamp.nanosec)
    return past if 0.0 <= past <= _LATEST else 0.0
