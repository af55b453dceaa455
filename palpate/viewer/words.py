"""The state of a session in words that a newcomer understands."""

from __future__ import annotations

from palpate.record.ticks import Ticks

_WORDS: list[tuple[int, str]] = [
    (1 << 4, "a number was not finite: the force ramps to zero"),
    (1 << 2, "the leader is silent: the force ramps to zero"),
    (1 << 3, "the follower is silent: the force ramps to zero"),
    (1 << 8, "not following: the instrument stands still"),
    (1 << 7, "clutched: the hand moves freely, the instrument stays"),
    (1 << 0, "force capped at {cap:g} N"),
    (1 << 1, "force rises no faster than its cap allows"),
    (1 << 5, "a motor is at its torque limit"),
    (1 << 6, "the instrument cannot reach further: it holds"),
    (1 << 9, "the handle slips out of the hand's grip"),
]


def in_words(tick: Ticks, force_cap: float, paused: bool = False) -> list[str]:
    """What a tick's status bits say, the gravest first; `touching` or `free` when there is nothing to say.

    force_cap: the cap of the scene [N].
    """
    status = int(tick["status"])
    said = [words.format(cap=force_cap) for bit, words in _WORDS if status & bit]
    if paused:
        said.insert(0, "paused: simulated time stands still")
    return said or ["touching" if float(tick["contacts"]) > 0 else "free"]
