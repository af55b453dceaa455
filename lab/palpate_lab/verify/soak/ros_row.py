"""A row of counts of `palpate soak ros`."""

from __future__ import annotations

from dataclasses import dataclass

RATE = 500.0
"""Rate of robot and node [Hz]."""
PARTS = ("haptics", "guardian", "robot")
"""Processes whose memory is recorded."""


@dataclass
class Row:
    """Counts of a segment, from its start until `t_s`."""

    segment: int
    t_s: float
    wrenches: int
    states: int
    left_out: int
    guarded: int
    touches: int
    lines: int
    load: float
    memory_MB: dict[str, float]
    ended: bool = False
    """True if a process has ended by itself."""
