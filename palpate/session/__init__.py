"""A session: one scene, run in lockstep or in real time, recorded while it runs (`palpate.Session`)."""

from palpate.session.session import Session, State

__all__ = ["Session", "State"]
