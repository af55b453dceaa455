"""Orders to a planned motion that is executed outside of a session: pause, resume, stop, abort, and the speed."""

from __future__ import annotations

from enum import Enum

from palpate.planning.ahead import require_speed


class Phase(Enum):
    """What an execution does."""

    MOVING = "moving"
    PAUSED = "paused"
    STOPPED = "stopped"
    ABORTED = "aborted"
    DONE = "done"


_OPEN = (Phase.MOVING, Phase.PAUSED)  # the motion has neither ended nor begun to end


class Orders:
    """The phase of one motion, and the orders that change it.

    Args:
        speed: pace, 1: as planned; 0 < speed <= 1.

    Raises:
        PlanningError: the speed is outside of its range.
    """

    def __init__(self, speed: float) -> None:
        self.phase, self.reason = Phase.MOVING, ""
        self._speed = require_speed(speed)

    @property
    def speed(self) -> float:
        """Pace of the motion, 1: as planned."""
        return self._speed

    @speed.setter
    def speed(self, value: float) -> None:
        self._speed = require_speed(value)

    @property
    def over(self) -> bool:
        """True when the motion has ended for good."""
        return self.phase in (Phase.DONE, Phase.STOPPED, Phase.ABORTED)

    def pause(self) -> None:
        """Come to rest; `resume` goes on."""
        if self.phase is Phase.MOVING:
            self.phase = Phase.PAUSED

    def resume(self) -> None:
        """Go on after a pause, if the remaining motion is still free."""
        if self.phase is Phase.PAUSED:
            self.phase = Phase.MOVING

    def stop(self) -> None:
        """Come to rest for good."""
        if self.phase in _OPEN:
            self.phase = Phase.STOPPED

    def abort(self, reason: str) -> None:
        """Come to rest for good, because something is wrong; the first reason is kept."""
        if self.phase in _OPEN:
            self.phase, self.reason = Phase.ABORTED, reason
