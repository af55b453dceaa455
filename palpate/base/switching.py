"""How soon threads have the interpreter: one wish of all sessions of a process, which come and go in any order."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable

_lock = threading.Lock()
_asked: list[float] = []  # [s]
_before = 0.0  # the interval before the first that asks [s]


def ask(seconds: float) -> Callable[[], None]:
    """Let threads wait at most so long for the interpreter, until the returned function is called.

    The shortest time asked for holds. When nobody asks any more, the interval is as before.
    """
    global _before
    with _lock:
        if not _asked:
            _before = sys.getswitchinterval()
        _asked.append(seconds)
        sys.setswitchinterval(min([_before, *_asked]))
    withdrawn = threading.Event()

    def withdraw() -> None:
        with _lock:
            if withdrawn.is_set():
                return
            withdrawn.set()
            _asked.remove(seconds)
            sys.setswitchinterval(min([_before, *_asked]))

    return withdraw
