"""What the pairs of a session have in common: the console and the endoscope arm of one operator."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from palpate.scene.live_targets import PERIOD
from palpate.session.console import Console, Hand
from palpate.session.pair import PairSession
from palpate.session.periodic import every

if TYPE_CHECKING:
    from palpate.session.camera import CameraArm


class OperatorSeat:
    """One console and one camera for the hands of all pairs.

    Args:
        exchange: exchanges the followers of both hands (`Console.swap`).
    """

    def __init__(self, exchange: Callable[[], None]) -> None:
        self._hands: list[Hand] = []
        self._pairs: tuple[PairSession, ...] = ()
        self.console = Console(self._hands, exchange)
        self.camera: CameraArm | None = None
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def take(self, pairs: Sequence[PairSession]) -> None:
        """Take these pairs instead of the present ones; a camera that has moved stays where it is."""
        self._pairs = tuple(pairs)
        self._hands[:] = [weakref.proxy(pair) for pair in pairs]
        before, placed = self.camera, pairs[0].rig.ecm
        if placed is not None:
            from palpate.session.camera import CameraArm

            self.camera = CameraArm(placed, [pair.rig.arms.X_WL for pair in pairs], pairs)
            if before is not None:
                self.camera.move_to(before.q)
        for pair in pairs:
            pair.console = self.console

    def steer(self) -> None:
        """Let the hands move the camera for one `PERIOD` while the camera pedal is pressed."""
        if self.camera is not None:
            self.camera.steer([pair.latest() for pair in self._pairs], PERIOD)

    def start(self) -> None:
        """Steer the camera in a thread of its own, until `stop`."""
        if self.camera is not None and self._thread is None:
            self._stop.clear()
            self._thread = every(PERIOD, self.steer, self._stop, "camera", self._pairs[0].note)

    def stop(self) -> None:
        """End the thread."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
