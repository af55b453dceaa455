"""Pictures of the remote camera: sources at the follower's end, and the sender over the reliable channel.

A picture is sent only if those before have arrived in time and the bandwidth allows it. Any other picture is dropped:
none waits, so the delay of those that are shown is that of the network.
"""

from __future__ import annotations

import base64
import binascii
import contextlib
import io
import itertools
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from palpate.base import limits
from palpate.base.errors import PalpateError

LARGEST = 256 * 1024
"""Largest picture that is sent [bytes]."""
BANDWIDTH = 4e6
"""Default of the largest mean rate [bit/s]."""
RATE = 15.0
"""Pictures per second of a folder [Hz]."""
_START, _END = b"\xff\xd8", b"\xff\xd9"  # markers of a JPEG picture
_PATIENCE = 5.0  # for a camera that does not answer [s]
_PAUSE = 1.0  # before a camera is asked again, and longest saving of bandwidth [s]
_SLACK = 0.15  # by which a picture may arrive later than the fastest one before others wait for it [s]


@dataclass(frozen=True)
class Picture:
    """A picture of the remote camera."""

    jpeg: bytes
    t: float
    """When it was captured, on the clock of the follower's end [s]."""


class VideoSource(Protocol):
    """A camera: pictures as they are captured."""

    def pictures(self, stopped: threading.Event, tell: Callable[[str], None]) -> Iterator[Picture]:
        """Yield each picture at its time, until stopped. `tell` takes words for the user about missing pictures."""


def is_jpeg(data: bytes) -> bool:
    """True for a whole JPEG picture that may be sent."""
    return len(data) <= LARGEST and data.startswith(_START) and data.rstrip(b"\0\r\n").endswith(_END)


class Folder:
    """The JPEG files of a folder in the order of their names, again and again at a fixed rate.

    Raises:
        PalpateError: the folder has no JPEG file, or one that is damaged or too large.
    """

    def __init__(self, path: Path, rate: float = RATE) -> None:
        self._files = sorted(one for end in ("*.jpg", "*.jpeg") for one in path.glob(end))
        self._dt = 1.0 / rate
        if not self._files:
            raise PalpateError(f"{path}: no picture", why="a video is the *.jpg files of a folder in their order",
                               mend="give such a folder, or the address of a camera: http://...")  # fmt: skip
        for file in self._files:
            try:
                fits = is_jpeg(limits.read_bytes(file, LARGEST))
            except OSError as error:
                raise PalpateError(
                    f"{file}: cannot be read ({error.strerror})", mend="give a folder of files"
                ) from None
            except PalpateError:  # it is too large
                fits = False
            if not fits:
                raise PalpateError(f"{file}: no JPEG picture of at most {LARGEST // 1024} KiB",
                                   mend="write smaller pictures, e.g. of 640 x 480 pixels")  # fmt: skip

    def pictures(self, stopped: threading.Event, tell: Callable[[str], None]) -> Iterator[Picture]:
        """Yield the files in turn."""
        due = time.monotonic()
        for file in itertools.cycle(self._files):
            if stopped.wait(max(due - time.monotonic(), 0.0)):
                return
            due = max(due + self._dt, time.monotonic())
            try:
                data = limits.read_bytes(file, LARGEST)
            except (OSError, PalpateError) as error:  # it has gone, or another one lies in its place
                tell(f"picture {file}: {error}")
                continue
            yield Picture(data, time.monotonic())


class Mjpeg:
    """A camera that serves motion JPEG over HTTP (multipart/x-mixed-replace), as most network cameras, ustreamer and
    ROS's web_video_server do. A picture is captured when its last byte arrives. A camera that ends is asked again.
    """

    def __init__(self, address: str) -> None:
        self._address = address

    def pictures(self, stopped: threading.Event, tell: Callable[[str], None]) -> Iterator[Picture]:
        """Yield the pictures of the camera."""
        while not stopped.is_set():
            try:
                with urllib.request.urlopen(self._address, timeout=_PATIENCE) as answer:
                    for data in parts(answer):
                        if stopped.is_set():
                            return
                        yield Picture(data, time.monotonic())
                tell(f"camera {self._address}: it has ended its stream, and is asked again")
            except (OSError, ValueError) as error:
                tell(f"camera {self._address}: {error}; it is asked again")
            stopped.wait(_PAUSE)


def parts(stream: io.BufferedIOBase | Any) -> Iterator[bytes]:
    """The pictures of a stream of motion JPEG; parts that are none are left out.

    Raises:
        ValueError: the stream is none of motion JPEG.
    """
    buffer = bytearray()
    while chunk := stream.read1(65536):
        buffer += chunk
        while (begin := buffer.find(_START)) >= 0 and (end := buffer.find(_END, begin)) >= 0:
            # A picture may hold a smaller one; the part ends where a boundary or the next picture follows.
            while (
                buffer[end + 2 : end + 4] not in (b"\r\n", b"--", _START, b"")
                and (later := buffer.find(_END, end + 2)) >= 0
            ):
                end = later
            data = bytes(buffer[begin : end + 2])
            del buffer[: end + 2]
            if is_jpeg(data):
                yield data
        if len(buffer) > 4 * LARGEST:
            raise ValueError("no pictures of motion JPEG, or larger ones than are sent")


def source(text: str) -> VideoSource:
    """The source that is meant: the address of a camera, or a folder.

    Raises:
        PalpateError: it is neither.
    """
    if text.startswith(("http://", "https://")):
        return Mjpeg(text)
    if not Path(text).is_dir():
        raise PalpateError(f"--video {text}: there is no such folder",
                           mend="give a folder of *.jpg files, http://..., ros:/TOPIC or scene")  # fmt: skip
    return Folder(Path(text))


class Sender:
    """Sends the pictures of a source to whoever is connected.

    Args:
        video: the source.
        send: sends a message; False while nobody is connected.
        bandwidth: largest mean rate [bit/s].
        tell: takes words for the user about pictures that are missing; the same words once.
    """

    def __init__(
        self, video: VideoSource, send: Callable[[dict[str, Any]], bool], bandwidth: float = BANDWIDTH,
        tell: Callable[[str], None] = lambda words: None,
    ) -> None:  # fmt: skip
        self._video, self._send, self._rate = video, send, bandwidth / 8.0
        self._tell, self._told = tell, ""
        self._room, self._last = 0.0, time.monotonic()  # bytes that may be sent
        self._flight: dict[int, float] = {}  # numbers and times of pictures that have not arrived
        self._fastest, self._number = float("inf"), 0
        self._lock, self._stopped = threading.Lock(), threading.Event()
        self.sent = self.dropped = 0  #: pictures

    def run(self) -> None:
        """Send until `stop`."""
        for picture in self._video.pictures(self._stopped, self._once):
            if self._may(len(picture.jpeg)) and self._deliver(picture):
                self.sent += 1
            else:
                self.dropped += 1

    def _once(self, words: str) -> None:
        if words != self._told:
            self._told = words
            self._tell(words)

    def stop(self) -> None:
        """End `run`."""
        self._stopped.set()

    def seen(self, number: object) -> None:
        """The picture of this number has arrived."""
        with self._lock:
            began = self._flight.pop(number, None) if isinstance(number, int) else None
            if began is not None:
                self._fastest = min(self._fastest, time.monotonic() - began)

    def forget(self) -> None:
        """The operator's end has left: nothing is under way."""
        with self._lock:
            self._flight.clear()
            self._fastest = float("inf")

    def _may(self, size: int) -> bool:
        now = time.monotonic()
        self._room = min(self._room + (now - self._last) * self._rate, _PAUSE * self._rate)
        self._last = now
        with self._lock:
            oldest = min(self._flight.values(), default=now)
        known = self._fastest < float("inf")
        late = now - oldest > self._fastest + _SLACK if known else now > oldest  # the first one is waited for
        return not late and self._room >= size

    def _deliver(self, picture: Picture) -> bool:
        number = self._number = self._number + 1
        with self._lock:
            self._flight[number] = time.monotonic()
        text = base64.b64encode(picture.jpeg).decode()
        with contextlib.suppress(OSError):
            if self._send({"video": number, "t": picture.t, "jpeg": text}):
                self._room -= len(text)
                return True
        with self._lock:
            self._flight.pop(number, None)
        return False


def received(message: dict[str, Any]) -> Picture | None:
    """The picture of a message; None unless it is a whole one."""
    try:
        data, t = base64.b64decode(str(message["jpeg"]), validate=True), float(message["t"])
    except (KeyError, ValueError, TypeError, binascii.Error):
        return None
    return Picture(data, t) if is_jpeg(data) and abs(t) < 1e12 else None
