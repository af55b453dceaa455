"""Sessions: one scene, run in lockstep or in real time, and recorded (`palpate.Session`)."""

from palpate.session.live import LiveSession
from palpate.session.loop import Loop
from palpate.session.pairs import PairsSession
from palpate.session.session import Session
from palpate.session.state import State

__all__ = ["LiveSession", "Loop", "PairsSession", "Session", "State"]
