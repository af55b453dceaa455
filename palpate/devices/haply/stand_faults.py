"""What goes wrong with the stand-in of Haply's service, as a script or a test orders it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from queue import SimpleQueue

from palpate.base.errors import DeviceError

FAULTS = {
    "late": "each answer comes VALUE seconds late (0.02); the force of a message acts when it arrives",
    "slow": "each message takes VALUE seconds (0.02), one after the other: it acts, and is answered, at the end",
    "hang": "the service reads and answers nothing",
    "disconnect": "all connections break, without a word",
    "malformed": "answers are no valid JSON, or have values of another kind",
    "sleep": "the grip falls asleep: its orientation stands still",
    "battery": "the battery of the grip is nearly empty",
    "ebrake": "the emergency brake locks the device: forces have no effect",
    "stall": "the service reports a stalled motor",
    "unplug": "the device vanishes from the messages",
    "uncalibrated": "the device says that it is not calibrated, and its positions are mirrored",
    "duplicate": "the grip is named twice, as a Ruko grip is",
}
"""What a script can do, in words."""


@dataclass(frozen=True)
class Fault:
    """Something that goes wrong from a time on, for a time."""

    name: str
    value: float = 0.0
    start: float = 0.0
    """Time after the start of the service [s]."""
    length: float = float("inf")
    """How long it lasts [s]."""
    device: str = ""
    """Id of the only device that it concerns; empty: all of them."""

    @classmethod
    def parse(cls, text: str) -> Fault:
        """``hang``, ``late=0.02``, ``hang@5`` (from 5 s on), ``sleep@5+2`` (for 2 s), ``unplug:04C3`` (one device).

        Raises:
            DeviceError: there is no such fault, or a number cannot be read.
        """
        head, _, when = text.partition("@")
        name, _, value = head.partition("=")
        name, _, device = name.partition(":")
        start, _, length = when.partition("+")
        if name not in FAULTS:
            raise DeviceError(f"there is no fault {name!r}", mend=f"one of {', '.join(FAULTS)}, e.g. hang@5+2")
        try:
            made = cls(name, float(value or 0.02), float(start or 0.0), float(length or "inf"), device)
        except ValueError:
            made = None
        if made is None or not (0.0 <= made.value < 1e6 and 0.0 <= made.start < 1e9 and made.length > 0.0):
            mend = "write NAME[:DEVICE][=VALUE][@SECONDS[+SECONDS]], with numbers of at least 0"
            raise DeviceError(f"fault {text!r} cannot be read", mend=mend)
        return made


class LateAnswers:
    """Sends answers after a time of their own, in their order, while its owner goes on to read.

    Args:
        send: sends one answer.
    """

    def __init__(self, send: Callable[..., None]) -> None:
        self._send = send
        self._queue: SimpleQueue[tuple[float, tuple[object, ...]]] = SimpleQueue()
        self._waiting, self._lock = 0, threading.Lock()

    def send(self, after: float, *answer: object) -> None:
        """Send an answer after this time [s], and after those before it; without any wait from this thread.

        Raises:
            OSError: the connection is broken.
        """
        with self._lock:
            first = self._waiting == 0
            if first and after <= 0.0:
                self._send(*answer)
                return
            self._waiting += 1
            self._queue.put((time.monotonic() + after, answer))
        if first:
            threading.Thread(target=self._work, daemon=True).start()

    def _work(self) -> None:
        while True:
            due, answer = self._queue.get()
            time.sleep(max(0.0, due - time.monotonic()))
            with suppress(OSError):  # the client has gone
                self._send(*answer)
            with self._lock:
                self._waiting -= 1
                if self._waiting == 0:
                    return
