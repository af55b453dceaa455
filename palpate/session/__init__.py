"""Sessions: a scene runs in lockstep or in real time, alone, in a batch, across a network, and as a task."""

from __future__ import annotations

from typing import TYPE_CHECKING

from palpate.base import lazy

if TYPE_CHECKING:
    from palpate.session.haptics import Haptics
    from palpate.session.loop import Loop
    from palpate.session.pairs import PairsSession
    from palpate.session.session import Session
    from palpate.session.state import State

__all__ = ["Haptics", "Loop", "PairsSession", "Session", "State"]

_HOMES = {
    "Haptics": "haptics",
    "Loop": "loop",
    "PairsSession": "pairs",
    "Session": "session",
    "State": "state",
}

__getattr__ = lazy.names(__name__, _HOMES)
