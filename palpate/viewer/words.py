"""Describes the state of a session in words."""

from __future__ import annotations

from palpate.record import withheld
from palpate.record.ticks import STATUS, Ticks


def in_words(tick: Ticks, force_cap: float, paused: bool = False) -> list[str]:
    """Descriptions of a tick's status bits, the gravest first, and of what withholds a force; `touching` or `free`
    when there is nothing to say.

    force_cap: force cap of the scene [N].
    """
    status = int(tick["status"])
    limits = {"force_capped": f" at {force_cap:g} N"}
    said = [words + limits.get(name, "") for name, (bit, words) in STATUS.items() if status & bit]
    said += withheld.in_words(tick)
    if paused:
        said.insert(0, "paused: simulated time stands still")
    return said or ["touching" if float(tick["contacts"]) > 0 else "free"]
