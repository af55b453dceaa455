"""Recorded streams of clouds: a folder of files, or a ROS 2 bag with sensor_msgs/PointCloud2."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import CloudError, RecordError
from palpate.record.bags.library import open_bag
from palpate.sensing import messages
from palpate.sensing.source import CloudFrame
from palpate.world.clouds import PointCloud
from palpate.world.clouds.files import DEPTH_IMAGES

_FILES = (".pcd", ".ply", ".npz", ".xyz")


class ReplaySource:
    """Frames of a recording, at the times at which they were recorded.

    Args:
        path: folder with clouds, which follow each other by name, or a bag (.mcap, .db3 or its folder).
        rate: frames per second of files [Hz]; a bag has its own stamps.
        unit: unit of files that state none.
        topic: topic of a bag with several clouds.
        X_WC: pose (4, 4) of the camera in W [m].
        repeat: True: begin again at the end; otherwise the stream falls silent.

    Raises:
        CloudError: there is no cloud, or the first one cannot be read.
        MissingExtraError: a bag is read without rosbags.
    """

    def __init__(
        self,
        path: Path,
        rate: float = 30.0,
        unit: str | None = None,
        topic: str | None = None,
        X_WC: Callable[[], Array] = lambda: np.eye(4),
        repeat: bool = False,
    ) -> None:
        if not path.exists():
            raise CloudError("the recording does not exist", where=str(path), mend="check the path")
        if path.is_dir() and ((path / "depth.txt").is_file() or any(path.glob("*.png")) or (path / "depth").is_dir()):
            raise CloudError("a folder of depth images is no recording of clouds", where=str(path), mend=DEPTH_IMAGES)
        files = sorted(f for f in path.iterdir() if f.suffix.lower() in _FILES) if path.is_dir() else []
        if files:
            self._begin: Callable[[], Iterator[CloudFrame]] = lambda: _of_files(files, rate, unit)
        elif path.is_dir() or path.suffix in (".mcap", ".db3"):
            self._begin = lambda: _of_bag(path, topic)
        else:
            kinds = ", ".join((*_FILES, ".mcap", ".db3"))
            raise CloudError("not a recording", where=str(path), mend=f"give a folder with clouds, or a bag: {kinds}")
        self._X_WC, self._repeat, self._period = X_WC, repeat, 1.0 / rate
        self._frames = self._begin()
        first = next(self._frames, None)
        if first is None:
            raise CloudError("the recording has no cloud", where=str(path), mend="record sensor_msgs/PointCloud2")
        self._ahead: CloudFrame | None = first
        self._t0: float | None = None  # time of the session at the recording's time zero

    def latest(self, now: float) -> CloudFrame | None:
        """The newest frame whose time has come; frames that were late are left out.

        Raises:
            CloudError: the next frame is damaged; the recording ends there.
        """
        if self._t0 is None:
            self._t0 = now
        due = None
        while self._ahead is not None and self._ahead.t <= now - self._t0 + 1e-9:
            due, self._ahead = self._ahead, None
            self._ahead = next(self._frames, None)
            if self._ahead is None and self._repeat:
                self._t0 += due.t + self._period
                self._frames = self._begin()
                self._ahead = next(self._frames, None)
                break
        return None if due is None else CloudFrame(due.points, now, self._X_WC(), due.colors)

    def close(self) -> None:
        """Close the recording."""
        self._frames = iter(())
        self._ahead = None


def _of_files(files: list[Path], rate: float, unit: str | None) -> Iterator[CloudFrame]:
    for k, file in enumerate(files):
        cloud = PointCloud.load(file, unit)  # type: ignore[arg-type]
        yield CloudFrame(cloud.points, k / rate, colors=cloud.colors)


def _of_bag(path: Path, topic: str | None) -> Iterator[CloudFrame]:
    """Frames of a bag; their times count from the first one, by the stamps in their headers."""
    try:
        with open_bag(path) as bag:
            chosen = [c for c in bag.connections if c.msgtype == "sensor_msgs/msg/PointCloud2"]
            names = sorted({c.topic for c in chosen})
            chosen = [c for c in chosen if topic is None or c.topic == topic]
            if not chosen or (topic is None and len(names) > 1):
                what = f"{len(names)} topics have clouds" if topic is None else f"there are no clouds on {topic}"
                raise CloudError(what, where=str(path), mend=f"name one by topic: {', '.join(names) or 'none'}")
            start = None
            for connection, received, raw in bag.messages(chosen):
                message: Any = bag.deserialize(raw, connection.msgtype)
                stamp = message.header.stamp
                t = stamp.sec + 1e-9 * stamp.nanosec or 1e-9 * received
                start = t if start is None else start
                decoded = messages.decode(message)
                yield CloudFrame(decoded.points, t - start, colors=decoded.colors)
    except RecordError as error:
        raise CloudError(error.what, where=error.where, why=error.why, mend="record it again") from None
