"""Play a record back at the pace it was made."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np

from palpate.record.reader import Record
from palpate.record.ticks import Ticks


def play(
    record: Record,
    *,
    rate: float = 30.0,
    speed: float = 1.0,
    start: float = 0.0,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> Iterator[Ticks]:
    """Yield the ticks of each frame when their time has come.

    A viewer that draws too slowly gets longer slices, never a growing delay; no tick is left out.

    Args:
        record: the run.
        rate: frames per second [Hz].
        speed: 1 as recorded, 2 twice as fast, 0.5 at half the pace.
        start: seconds into the run to begin at [s].
        clock: seconds from any origin [s]; for tests.
        sleep: waits that many seconds; for tests.

    Yields:
        (k,) of `TICK`, k >= 1: the ticks since the last frame, the newest last.

    Raises:
        ValueError: rate or speed is not positive.
    """
    if not (rate > 0.0 and speed > 0.0):
        raise ValueError(f"rate and speed are positive. Got: rate {rate} Hz, speed {speed}")
    times = record.ticks["t"] - record.ticks["t"][0]
    done = int(np.searchsorted(times, start))
    began = clock() - (times[done] / speed if done < len(times) else 0.0)
    while done < len(times):
        due = int(np.searchsorted(times, (clock() - began) * speed + 1e-9, side="right"))
        shown = clock() - began
        if due > done:
            yield record.ticks[done:due]
            done = due
        if done < len(times):
            next_frame = min(max(times[done] / speed, shown + 1.0 / rate), times[-1] / speed)
            sleep(max(0.0, began + next_frame - clock()))
