"""Trackers: sources of live poses, the gate that decides which are trusted, and the objects that follow them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from palpate.base import lazy

if TYPE_CHECKING:
    from palpate.sensing.trackers.gate import Gate, Limits
    from palpate.sensing.trackers.simulated import SimulatedTracker
    from palpate.sensing.trackers.tracker import Sighting, Tracker

__all__ = ["Gate", "Limits", "Sighting", "SimulatedTracker", "Tracker"]

_HOMES = {
    "Gate": "gate",
    "Limits": "gate",
    "SimulatedTracker": "simulated",
    "Sighting": "tracker",
    "Tracker": "tracker",
}

__getattr__ = lazy.names(__name__, _HOMES)
