"""Stamps of recorded messages: when a value was measured, which is not when the recorder received it."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array

MOST_OFFSET = 0.2
"""Offset of stamps from the times of reception above which it is told [s]."""
_ANOTHER_CLOCK = 3600.0  # an offset that no delay explains [s]


def offset_words(topic: str, offset: float | None) -> str:
    """What is told about the stamps of a topic; empty if they agree with the times of reception.

    Args:
        topic: name of the topic.
        offset: median of stamp minus time of reception [s].
    """
    if offset is None or abs(offset) <= MOST_OFFSET:
        return ""
    side = "behind" if offset < 0.0 else "ahead of"
    far = abs(offset) > _ANOTHER_CLOCK
    mend = "they count from another moment" if far else "compare the clocks of both machines"
    return f"{topic}: its stamps are {abs(offset):.{0 if far else 2}f} s {side} the times of reception: {mend}"


def intervals(t: Array, stamps: Array) -> Array:
    """Intervals between values [s] (n - 1,): by their stamps, where these increase, otherwise by their reception.

    Messages may arrive in bursts. An interval by reception is therefore at least half the median.

    Args:
        t: (n,) times of reception [s].
        stamps: (n,) times of measurement [s]; NaN without one.
    """
    received, stamped = np.diff(t), np.diff(stamps)
    if not len(received):
        return received
    found = np.maximum(received, max(0.5 * float(np.median(received)), 1e-6))
    rising = stamped > 0.0
    return np.where(rising, stamped, found)
