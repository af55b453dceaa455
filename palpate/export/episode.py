"""One demonstration as frames: what a data set for robot learning holds of a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.base.errors import RecordError
from palpate.export.bag_ticks import BagTicks
from palpate.export.demonstration import Demonstration
from palpate.export.frames import ArmFrames, frames_of
from palpate.record.reader import Record
from palpate.session.recorded import body_track


@dataclass(frozen=True)
class ArmOfEpisode:
    """One pair of leader and follower with its frames."""

    name: str
    """Name of the follower in lower case: psm1."""
    leader: str
    """Name of the leader in lower case: mtmr."""
    tool: str
    """Instrument: model of the follower."""
    joints: tuple[str, ...]
    """Names of the follower's joints, without the jaw."""
    leader_joints: tuple[str, ...]
    """Names of the leader's joints, without the gripper."""
    frames: ArmFrames


@dataclass(frozen=True)
class Episode:
    """One demonstration."""

    name: str
    task: str
    arms: tuple[ArmOfEpisode, ...]
    stamps: NDArray[np.int64]
    """(n,) time of each frame: of the wall clock for a run in real time, else since the start of the run [ns]."""
    failed: bool = False
    """True if the run had a fault, or its task was not done."""
    bodies: tuple[str, ...] = ()
    """Names of the rigid bodies that move."""
    places: Array | None = None
    """(n, m, 7) their positions [m] and quaternions w x y z in W; None without bodies."""
    foreign: bool = False
    """True for a bag of other software, whose poses are in the base of each arm."""

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.stamps)


def episode_of(run: Demonstration, fps: int, task: str = "") -> Episode:
    """Reduce a run to frames.

    Raises:
        RecordError: its arms have different numbers of ticks, or fewer ticks per second than frames.
    """
    arms = tuple(
        ArmOfEpisode(
            arm.name,
            arm.leader,
            arm.model("follower") or arm.name,
            tuple(arm.joint_names("follower")),
            tuple(arm.joint_names("leader")),
            frames_of(arm.ticks, fps, str(run.path)),
        )
        for arm in run.arms
    )
    lengths = {len(arm.frames) for arm in arms}
    if len(lengths) > 1:
        told = ", ".join(f"{arm.name} {len(arm.frames)}" for arm in arms)
        what = f"the pairs of the run have different numbers of frames: {told}"
        raise RecordError(what, where=str(run.path), mend="export the record of each pair alone")
    started = run.arms[0].ticks.started
    begin = 0 if started is None else round(started.timestamp() * 1e9)
    stamps = begin + np.rint(1e9 * arms[0].frames.t).astype(np.int64)
    names, places = _bodies(run, arms[0].frames.t)
    foreign = isinstance(run.arms[0].ticks, BagTicks)
    return Episode(run.name, task or run.task, arms, stamps, bool(run.faults), names, places, foreign)


def _bodies(run: Demonstration, times: Array) -> tuple[tuple[str, ...], Array | None]:
    """Names (m,) and places (n, m, 7) of the rigid bodies at times (n,) [s]."""
    first = run.arms[0].ticks
    track = body_track(first) if isinstance(first, Record) else None
    if track is None:
        return (), None
    return track.names, np.array([list(track.at(t).values()) for t in times.tolist()])
