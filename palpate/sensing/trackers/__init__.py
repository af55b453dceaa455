"""Trackers: sources of live poses, the gate that decides which are trusted, and the objects that follow them."""

from palpate.sensing.trackers.gate import Gate, Limits
from palpate.sensing.trackers.simulated import SimulatedTracker
from palpate.sensing.trackers.tracker import Sighting, Tracker

__all__ = ["Gate", "Limits", "Sighting", "SimulatedTracker", "Tracker"]
