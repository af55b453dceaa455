"""Contacts between tool spheres and objects: spring force and duration of each pair."""

from __future__ import annotations

import html
from collections.abc import Sequence

import numpy as np

from palpate.record.ticks import SIGNALS, Ticks


class Touched:
    """Accumulates the contact pairs of a run."""

    def __init__(self) -> None:
        self._pairs: dict[tuple[int, int], tuple[float, float, int]] = {}  # largest, sum of forces [N], ticks

    def add(self, ticks: Ticks) -> None:
        """Add further ticks (n,)."""
        valid = np.arange(SIGNALS["touch_sphere"].size) < ticks["contacts"][:, None]  # (n, touches)
        if not valid.any():
            return
        pairs = np.stack([ticks["touch_sphere"][valid], ticks["touch_object"][valid]], axis=1).astype(np.int64)
        force = ticks["touch_force"][valid]
        kinds, which = np.unique(pairs, axis=0, return_inverse=True)
        for k, (s, o) in enumerate(kinds.tolist()):
            felt = force[which.reshape(-1) == k]
            most, total, count = self._pairs.get((s, o), (-np.inf, 0.0, 0))
            self._pairs[s, o] = (max(most, float(felt.max())), total + float(felt.sum()), count + len(felt))

    def table(self, spheres: Sequence[str], objects: Sequence[str], rate: float) -> str:
        """HTML table of the contact pairs, the largest force first; arguments as for `table`."""
        if not self._pairs:
            return "<p>Nothing was touched.</p>"
        found = [
            (most, total / count, count / rate, html.escape(f"{_name(spheres, s)} \u00d7 {_name(objects, o)}"))
            for (s, o), (most, total, count) in self._pairs.items()
        ]
        lines = [
            f'<tr><td>{name}</td><td class="value">{most:.3f} N</td><td class="value">{mean:.3f} N</td>'
            f'<td class="value">{seconds:.2f} s</td></tr>'
            for most, mean, seconds, name in sorted(found, reverse=True)
        ]
        head = "<tr><th>sphere \u00d7 object</th><th>largest spring force</th><th>mean</th><th>contact time</th></tr>"
        return f'<div class="scroll"><table class="signals">{head}{"".join(lines)}</table></div>'


def table(ticks: Ticks, spheres: Sequence[str], objects: Sequence[str], rate: float) -> str:
    """HTML table of the contact pairs of a run, the largest force first.

    Args:
        ticks: (n,) ticks of the run.
        spheres: names of the tool's spheres, the one at the tip first; a sphere without a name is shown by its index.
        objects: names of the objects; likewise.
        rate: tick rate [Hz].
    """
    touched = Touched()
    touched.add(ticks)
    return touched.table(spheres, objects, rate)


def _name(names: Sequence[str], k: int) -> str:
    return names[k] if k < len(names) else str(k)
