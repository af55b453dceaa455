"""Sessions: a scene runs in lockstep or in real time, alone, in a batch, across a network, and as a task."""

from palpate.session.live import LiveSession
from palpate.session.loop import Loop
from palpate.session.pairs import PairsSession
from palpate.session.session import Session
from palpate.session.state import State

__all__ = ["LiveSession", "Loop", "PairsSession", "Session", "State"]
