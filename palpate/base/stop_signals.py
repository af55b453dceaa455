"""Ctrl-C, SIGTERM and SIGHUP: one handler for a command, which remembers that a signal came.

Python drops an exception that a signal handler raises inside a finaliser or a callback of the import system. A run that
relied on the exception would then go on without its owner. So what waits or runs asks `came` first.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

_ENDS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_PERIOD = 0.2  # [s] between two looks at the signals
_raised = threading.Event()  # a signal was answered by an exception, which may have been dropped
_at_once = threading.Event()  # SIGTERM or SIGHUP came: nobody waits for more than the record


@contextmanager
def handled() -> Iterator[None]:
    """Context in which the three signals raise KeyboardInterrupt and are remembered, except those that are ignored."""
    before = {s: signal.signal(s, _raise) for s in _ENDS if signal.getsignal(s) is not signal.SIG_IGN}
    try:
        yield
    finally:
        for s, handler in before.items():
            signal.signal(s, handler)
        _raised.clear()  # what this process runs next is another command
        _at_once.clear()


def came() -> bool:
    """True if a signal has ended this command, even if its exception was dropped."""
    return _raised.is_set()


def wait(event: threading.Event, look: Callable[[], None] = lambda: None) -> None:
    """Wait for an event, and call `look` meanwhile. Raises KeyboardInterrupt if a signal ends the command before it."""
    while not event.wait(_PERIOD):
        look()
        if came():
            raise KeyboardInterrupt


def ends_at_once() -> bool:
    """True after SIGTERM or SIGHUP: only what was recorded is still written."""
    return _at_once.is_set()


@contextmanager
def deferred(interrupted: threading.Event) -> Iterator[None]:
    """Context in which the handled signals set the event, between two batches of ticks, instead of raising.

    The event is set from the start if a signal has come before.
    """
    interrupted.clear()
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def take(number: int, _: FrameType | None) -> None:
        _note(number)
        interrupted.set()

    before = {s: signal.signal(s, take) for s in _ENDS if callable(signal.getsignal(s))}
    if came():
        interrupted.set()
    try:
        yield
    finally:
        for s, handler in before.items():
            signal.signal(s, handler)


def _raise(number: int, _: FrameType | None) -> None:
    _note(number)
    _raised.set()
    raise KeyboardInterrupt


def _note(number: int) -> None:
    if number != signal.SIGINT:
        _at_once.set()
