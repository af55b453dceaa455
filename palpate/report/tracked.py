"""Tracked frames of a run: how long each was tracked, how old its pose became, and how far it moved."""

from __future__ import annotations

import html
from collections.abc import Sequence

import numpy as np

from palpate.base.arrays import Array
from palpate.record import live
from palpate.record.ticks import Ticks

WORDS = (
    "Frames that a tracker moved, and the age of their last good pose. While a frame is lost, the objects in it stand "
    "still and their force fades."
)


class Tracked:
    """Accumulates how the frames of a run were tracked.

    Args:
        frames: number of tracked frames.
    """

    SIGNALS = ("tracked_status", "tracked_age", "tracked_p")
    """Signals that the ticks must have if there are frames."""

    def __init__(self, frames: int) -> None:
        self._good, self._bad = np.zeros(frames, int), np.zeros(frames, int)
        self._oldest, self._away = np.zeros(frames), np.zeros(frames)
        self._first: list[Array | None] = [None] * frames

    def add(self, ticks: Ticks) -> None:
        """Add further ticks (n,)."""
        for k in range(len(self._good)):
            status, age = ticks["tracked_status"][:, k], ticks["tracked_age"][:, k]
            good = int((status == live.STATUS.index("tracked")).sum())
            self._good[k] += good
            self._bad[k] += len(ticks) - good
            self._oldest[k] = max(self._oldest[k], float(age[np.isfinite(age)].max(initial=0.0)))
            p = ticks["tracked_p"][status != live.STATUS.index("not seen yet"), 3 * k : 3 * k + 3]
            if not len(p):
                continue
            first = self._first[k] = p[0].copy() if self._first[k] is None else self._first[k]
            self._away[k] = max(self._away[k], float(np.linalg.norm(p - first, axis=1).max()))

    def table(self, frames: Sequence[str], rate: float) -> str:
        """HTML table of the frames with these names, at a tick rate [Hz]."""
        lines = []
        for k, name in enumerate(frames):
            times = f"{self._good[k] / rate:.2f} s", f"{self._bad[k] / rate:.2f} s", f"{self._oldest[k]:.2f} s"
            cells = "".join(f'<td class="value">{one}</td>' for one in (*times, f"{1e3 * self._away[k]:.1f} mm"))
            lines.append(f"<tr><td>{html.escape(name)}</td>{cells}</tr>")
        names = ("frame", "tracked", "not tracked", "oldest pose", "farthest from its first place")
        head = "".join(f"<th>{name}</th>" for name in names)
        return f'<div class="scroll"><table class="signals"><tr>{head}</tr>{"".join(lines)}</table></div>'


def table(ticks: Ticks, frames: Sequence[str], rate: float) -> str:
    """HTML table of the tracked frames.

    Args:
        ticks: (n,) ticks of the run.
        frames: names of the tracked frames, in the scene's order.
        rate: tick rate [Hz].
    """
    tracked = Tracked(len(frames))
    tracked.add(ticks)
    return tracked.table(frames, rate)
