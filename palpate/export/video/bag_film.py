"""Films what the cameras of a ROS 2 bag saw, at every frame of an episode."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from palpate.base.errors import RecordError
from palpate.export.bag_ticks import BagTicks
from palpate.export.demonstration import Demonstration
from palpate.export.episode import Episode
from palpate.export.video.film import EYES, Clip, Eye, films
from palpate.record.bags import images


class BagFilm:
    """The cameras of a bag.

    Args:
        run: a run of a bag.

    Raises:
        RecordError: the bag has no pictures.
    """

    def __init__(self, run: Demonstration) -> None:
        bag = run.arms[0].ticks
        assert isinstance(bag, BagTicks)
        self.path, self._start = run.path, bag.start
        self._topics = images.cameras(run.path)
        if not self._topics:
            mend = "record a topic of sensor_msgs/Image or CompressedImage, or export it without --video"
            raise RecordError("the bag has no pictures", where=str(run.path), mend=mend)

    @property
    def intrinsics(self) -> dict[str, Any]:
        """Intrinsics of each camera and the distance of the eyes, as far as the bag has a CameraInfo."""
        return images.intrinsics(self.path, self._topics)

    def shoot(self, episode: Episode, folder: Path, fps: int) -> dict[str, Clip]:
        """Write the film of each eye into a folder, by the name of its feature, with the stamps of its pictures.

        Raises:
            RecordError: a picture cannot be decoded, has another size than the first, or a topic has none.
        """
        sides: list[Eye] = [side for side in EYES if side in self._topics]
        stamps: dict[Eye, list[int]] = {side: [] for side in sides}
        times = (episode.arms[0].frames.t + self._start).tolist()
        shots = images.shots(self.path, self._topics, times)
        first = next(shots, None)
        if first is None:
            raise RecordError(f"no picture in {', '.join(self._topics.values())}", where=str(self.path))
        sizes = {side: first[side].picture.shape[:2] for side in sides}

        def pictures() -> Iterator[dict[Eye, Any]]:
            for shot in chain([first], shots):
                for side in sides:
                    if shot[side].picture.shape[:2] != sizes[side]:
                        what = f"pictures of {side} change their size: {sizes[side]}, {shot[side].picture.shape[:2]}"
                        raise RecordError(what, where=str(self.path), mend="cut the bag, or leave --video out")
                    stamps[side].append(shot[side].stamp)
                yield {side: shot[side].picture for side in sides}

        clips = films(pictures(), {side: folder / f"{side}.mp4" for side in sides}, sizes, fps)
        return {
            name: replace(clip, stamps=np.array(stamps[side], dtype=np.int64))
            for side, (name, clip) in zip(sides, clips.items(), strict=True)
        }

    def close(self) -> None:
        """Nothing to release."""
