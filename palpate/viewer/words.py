"""Describes the state of a session in words."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from palpate.record import withheld
from palpate.record.ticks import STATUS, Ticks

_NOT_FOLLOWING = STATUS["not_following"][0]


def follows(ticks: Ticks) -> NDArray[np.bool_]:
    """True for each of the ticks (n,) in which the instrument follows the hand."""
    return np.asarray((ticks["status"].astype(np.uint64) & np.uint64(_NOT_FOLLOWING)) == 0)


def in_words(
    tick: Ticks, force_cap: float, paused: bool = False, near: Callable[[Ticks], str] | None = None, over: bool = False
) -> list[str]:
    """Descriptions of a tick's status bits, the gravest first, and of what withholds a force; `touching`, or `free`
    and what is nearest, when there is nothing to say.

    force_cap: force cap of the scene [N]. near: says which object is nearest, and where the hand must move.
    over: the run has ended, which is why the instrument does not follow.
    """
    status = int(tick["status"])
    if over:
        status &= ~_NOT_FOLLOWING
    limits = {"force_capped": f" at {force_cap:g} N"}
    said = [words + limits.get(name, "") for name, (bit, words) in STATUS.items() if status & bit]
    said += withheld.in_words(tick)
    if over:
        said.insert(0, "the run has ended")
    if paused:
        said.insert(0, "paused: simulated time stands still")
    if said or float(tick["contacts"]) > 0:
        return said or ["touching"]
    where = "" if near is None else near(tick)
    return [f"free: {where}" if where else "free"]
