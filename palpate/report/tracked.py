"""Tracked frames of a run: how long each was tracked, how old its pose became, and how far it moved."""

from __future__ import annotations

import html
from collections.abc import Sequence

import numpy as np

from palpate.record import live
from palpate.record.ticks import Ticks

WORDS = (
    "Frames that a tracker moved, and the age of their last good pose. While a frame is lost, the objects in it stand "
    "still and their force fades."
)


def table(ticks: Ticks, frames: Sequence[str], rate: float) -> str:
    """HTML table of the tracked frames.

    Args:
        ticks: (n,) ticks of the run.
        frames: names of the tracked frames, in the scene's order.
        rate: tick rate [Hz].
    """
    lines = []
    for k, name in enumerate(frames):
        status, age = ticks["tracked_status"][:, k], ticks["tracked_age"][:, k]
        good = status == live.STATUS.index("tracked")
        p = ticks["tracked_p"][status != live.STATUS.index("not seen yet"), 3 * k : 3 * k + 3]
        away = 1e3 * float(np.linalg.norm(p - p[0], axis=1).max()) if len(p) else 0.0
        oldest = float(age[np.isfinite(age)].max(initial=0.0))
        values = (f"{good.sum() / rate:.2f} s", f"{(~good).sum() / rate:.2f} s", f"{oldest:.2f} s", f"{away:.1f} mm")
        cells = "".join(f'<td class="value">{value}</td>' for value in values)
        lines.append(f"<tr><td>{html.escape(name)}</td>{cells}</tr>")
    names = ("frame", "tracked", "not tracked", "oldest pose", "farthest from its first place")
    head = "".join(f"<th>{name}</th>" for name in names)
    return f'<div class="scroll"><table class="signals"><tr>{head}</tr>{"".join(lines)}</table></div>'
