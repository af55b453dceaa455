"""Summary of a bag, for the terminal and for `--json`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from rich.table import Table

from palpate.base.arrays.peaks import sustained_held
from palpate.record.bags.bag import Bag
from palpate.record.bags.stamps import intervals
from palpate.record.bags.tracks import ArmTracks

STALE = 0.03
"""Age above which a commanded wrench that is not renewed counts as left on [s]."""
_LEAST_FORCE = 1e-3  # smaller forces count as zero [N]


@dataclass(frozen=True)
class ArmSummary:
    """Figures of one arm; the names contain the units."""

    peak_force_N: float
    peak_50ms_N: float  # largest mean over 50 ms, which noise does not raise
    steepest_N_per_s: float  # largest rate of the commanded force
    held_s: float  # time during which a force stayed on without being renewed
    peak_speed_m_s: float
    wrenches: int
    poses: int


@dataclass(frozen=True)
class TopicSummary:
    """Statistics of one topic."""

    topic: str
    type: str
    count: int
    rate_Hz: float
    longest_gap_s: float
    stamp_zero: int  # messages that their sender marked as invalid
    not_finite: int  # messages with a number that is not finite
    stamp_offset_s: float | None  # median of stamp minus time of reception; None without stamps


@dataclass(frozen=True)
class BagSummary:
    """Summary of a bag, as docs/json.md describes it."""

    bag: str
    duration_s: float
    leader: str
    follower: str | None
    arms: dict[str, ArmSummary]
    topics: list[TopicSummary]
    events: int
    notes: list[str]
    report: str | None = None  # path of the page, if one was written


def summary_of(bag: Bag) -> BagSummary:
    """The summary of a bag."""
    return BagSummary(
        bag=str(bag.path),
        duration_s=bag.duration,
        leader=bag.pair[0],
        follower=bag.pair[1],
        arms={name: _arm(arm, bag.duration) for name, arm in bag.arms.items()},
        topics=[TopicSummary(t.name, t.type, t.count, t.rate, t.gap, t.silent, t.bad, t.offset) for t in bag.topics],
        events=len(bag.events),
        notes=bag.notes,
    )


def _arm(arm: ArmTracks, end: float) -> ArmSummary:
    force, t = arm.wrench.values[:, :3], arm.wrench.t
    size = np.linalg.norm(force, axis=1)
    steps = np.linalg.norm(np.diff(force, axis=0), axis=1) / intervals(t, arm.wrench.stamps)
    unrenewed = np.diff(np.append(t, end))
    left_on = unrenewed[(size > _LEAST_FORCE) & (unrenewed > STALE)].sum()
    moved = np.linalg.norm(np.diff(arm.pose.values[:, :3], axis=0), axis=1) / intervals(arm.pose.t, arm.pose.stamps)
    return ArmSummary(
        peak_force_N=float(size.max(initial=0.0)),
        peak_50ms_N=sustained_held(t, size, end),
        steepest_N_per_s=float(steps.max(initial=0.0)),
        held_s=float(left_on),
        peak_speed_m_s=float(moved.max(initial=0.0)),
        wrenches=len(t),
        poses=len(arm.pose.t),
    )


def table(bag: Bag) -> Table:
    """Table of the arms for the terminal."""
    out = Table(title=f"{bag.duration:.2f} s, {len(bag.topics)} topics", title_justify="left", box=None)
    for column in ("arm", "poses", "wrenches", "peak force", "held 50 ms", "steepest", "force left on", "top speed"):
        out.add_column(column, justify="left" if column == "arm" else "right")
    for name, s in summary_of(bag).arms.items():
        out.add_row(
            name, str(s.poses), str(s.wrenches), f"{s.peak_force_N:.2f} N", f"{s.peak_50ms_N:.2f} N",
            f"{s.steepest_N_per_s:.0f} N/s", f"{s.held_s:.2f} s", f"{s.peak_speed_m_s:.3f} m/s",
        )  # fmt: skip
    return out
