"""Signals that end a run: they are noticed between two batches of ticks, never during a write."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def deferred(interrupted: threading.Event) -> Iterator[None]:
    """Context in which Ctrl-C (and SIGTERM and SIGHUP, if handled) sets the event instead of raising."""
    interrupted.clear()
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handled = [s for s in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP) if callable(signal.getsignal(s))]
    before = {s: signal.signal(s, lambda *_: interrupted.set()) for s in handled}
    try:
        yield
    finally:
        for s, handler in before.items():
            signal.signal(s, handler)
