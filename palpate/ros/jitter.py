"""Tolerances for a leader's states, chosen at the start of a session from how regularly they arrive.

The offset of the leader's clock and the jitter of its states are measured apart: a clock that is wrong is a fault, and
no tolerance grows because of it.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.ros import causes

SECONDS = 1.0
"""Duration of the measurement [s]; half of it for a regular stream."""
FIND = 3.2
"""Longest wait for the first state [s]: a publisher of Fast DDS announces itself every 3 s."""
NAMED = 5e-3
"""Smallest offset of a clock that is told [s]."""
MARGIN = 2.0
"""Tolerance over the longest gap that was measured [-]."""
PART = 0.1
"""Parts of the measurement, of which each has its longest pause [s]."""
REPEATED = 3
"""Number of parts with a pause that make it jitter: one pause, as of a program that starts, touches two at most."""
LARGEST = 0.06
"""Largest tolerance [s]. A force may rest this long on an old state, and an arm moves by 6 mm at 0.1 m/s meanwhile."""


@dataclass(frozen=True)
class Jitter:
    """How regularly states arrived."""

    states: int
    rate: float
    """Mean rate [Hz]."""
    gap: float
    """Longest time between two arrivals, or between the ages of two stamps, that came back [s]."""
    offset: float = 0.0
    """Offset of the sender's clock; negative: behind, or a constant delay [s]."""
    longest: float = 0.0
    """Longest of these times, whether it came back or not [s]."""


def measure(native: Any, context: Any, topic: str, least: float) -> Jitter | None:
    """Listen to a topic of poses for `SECONDS`, or half as long to a regular one; None if none arrives within `FIND`.

    Args:
        native: the compiled module.
        context: ROS context.
        topic: full name of the topic.
        least: smallest tolerance [s]. A stream counts as regular if its tolerance would be half of this at most.
    """
    meter = native.StreamMeter(context, topic)
    end = time.monotonic() + FIND
    while not meter.rows():
        if time.monotonic() > end:
            return None
        time.sleep(0.01)
    for part in (0.5, 0.5):
        time.sleep(part * SECONDS)
        found = jitter(np.array(meter.rows()), time.monotonic())
        if MARGIN * found.longest <= 0.5 * least:
            break
    return found


def jitter(rows: Array, now: float) -> Jitter:
    """The jitter of recorded arrivals.

    Args:
        rows: arrival on the monotonic clock and age of the stamp of each state (n, 2) [s], n >= 1; an age is NaN where
            the stamp is zero, as of an arm without power.
        now: end of the record on the monotonic clock [s].
    """
    arrivals, ages = rows[:, 0], rows[:, 1]
    gaps = np.diff(np.append(arrivals, max(now, arrivals[-1])))
    valid = ages[np.isfinite(ages)]
    usual = float(np.quantile(valid, 0.1)) if len(valid) else 0.0  # a few of another source do not count
    later = np.nan_to_num(ages, nan=usual) - usual
    pauses = np.maximum(gaps, np.where(np.abs(later) < LARGEST, later, 0.0))
    part = ((arrivals - arrivals[0]) / PART).astype(int)
    longest = sorted((float(pauses[part == k].max()) for k in np.unique(part)), reverse=True)
    again = longest[min(REPEATED, len(longest)) - 1]
    return Jitter(len(rows), len(rows) / max(float(now - arrivals[0]), 1e-9), again, -usual, longest[0])


def tolerance(measured: Jitter | None, least: float) -> tuple[float, str]:
    """The silence after which the leader counts as silent [s], and a sentence for the user; empty if it is `least`.

    Args:
        measured: the jitter; None: no state arrived.
        least: the scene's `stability.stale_after` [s], which is never made smaller.
    """
    if measured is None:
        return least, ""
    wanted = MARGIN * measured.gap
    chosen = max(least, min(wanted, LARGEST))
    if chosen == least and wanted <= least:
        return least, ""
    words = f"the leader's states pause for up to {1e3 * measured.gap:.0f} ms: "
    if wanted > LARGEST:
        return chosen, (
            f"{words}a silence of {1e3 * chosen:.0f} ms takes the force away, longer ones are not tolerated. "
            "Mend: end other programs, or allow SCHED_FIFO (docs/ros2-network.md)"
        )
    return chosen, f"{words}a silence of {1e3 * chosen:.0f} ms takes the force away, instead of {1e3 * least:.0f} ms"


def offset_words(offset: float, most: float) -> str:
    """A sentence on the offset of the leader's clock; empty if it is small.

    Args:
        offset: positive: ahead of this machine's clock [s].
        most: largest age of a stamp that is trusted [s].
    """
    if abs(offset) < NAMED:
        return ""
    late = "" if offset > 0.0 else " (or its states take as long to arrive)"
    what = f"the leader's clock {causes.offset(offset)}{late}"
    held = "no force" if abs(offset) > most else "within what is allowed"
    return f"{what}: {held} ({causes.duration(most)}). Mend: synchronise both machines (chrony, NTP)"
