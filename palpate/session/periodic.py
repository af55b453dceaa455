"""Work beside a loop: a function that is called once a period, in a thread of its own."""

from __future__ import annotations

import threading
from collections.abc import Callable


def every(
    period: float,
    step: Callable[[], object],
    stop: threading.Event,
    name: str,
    failed: Callable[[str], object],
    last: Callable[[], object] | None = None,
) -> threading.Thread:
    """Start a thread that calls a function once a period.

    Args:
        period: time between two calls [s].
        step: the function.
        stop: the thread ends when this is set.
        name: name of the work, for the thread and for messages.
        failed: receives a message if the function raises; the thread then ends, and the loop goes on without it.
        last: called when the thread ends.
    """

    def work() -> None:
        try:
            while not stop.wait(period):
                step()
        except Exception as error:
            failed(f"{name} has stopped: {error}")
        finally:
            if last is not None:
                last()

    thread = threading.Thread(target=work, name=f"palpate-{name}", daemon=True)
    thread.start()
    return thread
