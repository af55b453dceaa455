"""Interface of trackers: an optical tracker, a localiser on a network, or a simulation."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

from palpate.base.arrays import Array


@dataclass(frozen=True)
class Sighting:
    """A pose of a tool as a tracker reports it, not yet checked."""

    tool: str
    X: Array
    """pose (4, 4) of the tool in the tracker's frame [m]"""
    t: float
    """time of the measurement by the tracker's clock [s]"""
    error: float = math.nan
    """rms residual of the marker's spheres [m]; NaN if the tracker does not report it"""
    valid: bool = True
    """False if the tracker itself marks the pose as invalid"""
    why: str = ""
    """why it is invalid, in words"""

    def at(self, t: float) -> Sighting:
        """The same sighting by another clock, at the time t [s]."""
        return replace(self, t=t)


class Tracker(Protocol):
    """A source of sightings."""

    def poll(self, now: float) -> list[Sighting]:
        """Sightings since the last call, in their order; never waits. now: time of the session [s]."""
        ...

    def close(self) -> None:
        """End the connection."""
        ...


@runtime_checkable
class Hearing(Protocol):
    """A tracker that says what it knows about a tool that is not seen."""

    def heard(self, tool: str) -> str:
        """The state of the connection, and what arrives instead, in words; may be empty."""
        ...
