"""Sentences about faults of messages, with the value that was refused (signal `cause`)."""

from __future__ import annotations

import math
from collections.abc import Callable

from palpate.record.ticks import STATUS

_CAPS = frozenset({"force_capped", "rate_capped", "passivity"})  # they reduce a force, and forbid none


def conditions(status: int) -> list[str]:
    """Conditions of a status that forbid a force, the gravest first; empty if a force is allowed."""
    return [words for name, (bit, words) in STATUS.items() if status & bit and name not in _CAPS]


def offset(seconds: float) -> str:
    """A clock offset in words, e.g. "50 ms behind"; positive: ahead [s]."""
    return f"{duration(abs(seconds))} {'ahead' if seconds > 0.0 else 'behind'}"


def duration(seconds: float) -> str:
    """A time in the unit in which people say it, e.g. "50 ms", "1.0 h"."""
    for size, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min"), (1.0, "s")):
        if seconds >= 2.0 * size or (size == 3600.0 and seconds >= 0.99 * size):
            return f"{seconds / size:.3g} {unit}"
    return f"{1e3 * seconds:.0f} ms" if seconds >= 0.01 else f"{1e3 * seconds:.2g} ms"


def _clock(value: float, limit: float) -> str:
    late = "" if value > 0.0 else " (or its states take as long to arrive)"
    return f"the sender's clock {offset(value)}{late}: {duration(limit)} are allowed; no force. Mend: chrony or NTP"


def _rotation(norm: float, _: float) -> str:
    what = "a quaternion was zero" if norm == 0.0 else f"a quaternion had the norm {norm:.4g} instead of 1"
    return f"{what}: the force goes to zero"


def _far(value: float, limit: float) -> str:
    return (
        f"a position was {value:.4g} m from the origin of its frame (in millimetres?), {limit:g} m are allowed: the "
        "force goes to zero"
    )


_PHRASES: dict[str, Callable[[float, float], str]] = {
    "clock_offset": _clock,
    "not_rotation": _rotation,
    "too_far": _far,
    "bad_stamp": lambda value, _: f"a stamp was {value:g} (not valid): the force goes to zero",
    "clock_jumped": lambda value, _: (
        f"a clock jumped by {duration(abs(value))} {'forwards' if value > 0 else 'back'}: the force goes to zero"
    ),
    "jumped": lambda moved, turned: (
        f"a pose jumped by {1e3 * moved:.1f} mm and {math.degrees(turned):.1f} deg, faster "
        "than any hand: the force goes to zero"
    ),
    "alternating": lambda value, _: (
        f"poses jump to and fro by {1e3 * value:.1f} mm (two sources?): the force goes to zero"
    ),
    "streams_disagree": lambda told, moved: (
        f"measured_cv reports {told:.3f} m/s, the poses move at {moved:.3f} m/s: the force goes to zero"
    ),
    "slow": lambda rate, least: (
        f"the leader reports its state at {rate:.0f} Hz, the cycle needs {least:.0f} Hz: no "
        "force. Mend: --rate, rates.haptic, or a faster publisher"
    ),
    "stalled": lambda value, _: f"the cycle paused for {duration(value)}: the force goes to zero",
    "lagging": lambda value, limit: (
        f"the follower is {1e3 * value:.0f} mm from its goal, {1e3 * limit:.0f} mm are allowed: it is let go"
    ),
}


def sentence(name: str, value: float, other: float) -> str:
    """The fault of a status bit in words.

    Args:
        name: of the bit, as in `STATUS`.
        value: first value of the signal `cause`; NaN: not known.
        other: second value.
    """
    phrase = _PHRASES.get(name)
    return STATUS[name][1] if phrase is None or not math.isfinite(value) else phrase(value, other)
