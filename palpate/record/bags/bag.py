"""The ROS 2 bag of a CRTK session."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from palpate.base.errors import RecordError
from palpate.record.bags.reading import read
from palpate.record.bags.tracks import Contents


@dataclass
class Bag(Contents):
    """A CRTK session read from a bag."""

    @classmethod
    def open(cls, path: str | Path) -> Bag:
        """Read a rosbag2: its folder, an ``.mcap`` or a ``.db3``.

        Raises:
            RecordError: the bag is missing or damaged, or no arm in it has CRTK topics.
            MissingExtraError: the library rosbags is not installed.
        """
        bag = cls(**vars(read(Path(path))))
        if not any(len(a.pose.t) or len(a.q.t) for a in bag.arms.values()):
            names = ", ".join(t.name for t in bag.topics[:6]) or "none"
            raise RecordError(
                "no arm in this bag has CRTK topics: there is no measured_cp and no measured_js",
                where=str(bag.path),
                why=f"its topics: {names}{', ...' if len(bag.topics) > 6 else ''}",
                mend="record the arm's topics: ros2 bag record -a",
            )
        return bag

    @cached_property
    def pair(self) -> tuple[str, str | None]:
        """Names of the leader and its follower.

        The names of teleoperation topics decide (``MTMR_PSM1``). Without them, the leader is the arm with commanded
        wrenches, then the first MTM by name; the follower is the first PSM. A bag of one arm has no follower.
        """
        moved = [n for n, a in self.arms.items() if len(a.pose.t) or len(a.q.t)]
        for event in self.events:
            first, _, second = event.topic.strip("/").split("/")[0].partition("_")
            if first in moved and second in moved:
                return first, second
        leaders = sorted(moved, key=lambda n: (not len(self.arms[n].wrench.t), not n.startswith("MTM"), n))
        followers = [n for n in moved if n.startswith("PSM") and n != leaders[0]]
        return leaders[0], followers[0] if followers else None
