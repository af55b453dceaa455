"""The thread of the sockets: packets between the network and an end that runs in a real-time loop."""

from __future__ import annotations

import contextlib
import os
import select
import socket
import threading
import time
from collections.abc import Callable

PRIORITY = 20  # of SCHED_FIFO, below every loop
_LONGEST = 0.02  # wait for packets without one to send [s]


class Pump:
    """Reads packets as they arrive, and sends one at a fixed rate.

    Args:
        udp: the socket, which does not block.
        rate: packets to send per second [Hz].
        take: takes what has arrived at the socket.
        send: sends one packet.
    """

    def __init__(self, udp: socket.socket, rate: float, take: Callable[[], None], send: Callable[[], None]) -> None:
        self._udp, self._dt, self._take, self._send = udp, 1.0 / rate, take, send
        self.stopped = threading.Event()  #: ends `run`
        self.cpu = 0.0  #: processor time of the thread [s]

    def run(self) -> None:
        """Pump until `stopped`."""
        with contextlib.suppress(OSError, AttributeError):  # refused: a busy machine delays packets more
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
        begin, due = time.thread_time(), time.monotonic()
        while not self.stopped.is_set():
            wait = due - time.monotonic()
            if wait > 0.0 and select.select([self._udp], [], [], min(wait, _LONGEST))[0]:
                self._take()
            if time.monotonic() >= due:
                self._take()
                self._send()
                due = max(due + self._dt, time.monotonic() - _LONGEST)
        self.cpu = time.thread_time() - begin
