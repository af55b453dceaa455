"""Trackers: sources of live poses, the gate that decides which are trusted, and the objects that follow them."""

from palpate.trackers.gate import Gate, Limits
from palpate.trackers.simulated import SimulatedTracker
from palpate.trackers.tracker import Sighting, Tracker

__all__ = ["Gate", "Limits", "Sighting", "SimulatedTracker", "Tracker"]
