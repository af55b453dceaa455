"""The energy ledger in words: energy that each object took from the hand, and energy that `stability` withheld."""

from __future__ import annotations

from html import escape

import numpy as np

from palpate.record.ticks import SIGNALS
from palpate.report.run import Run
from palpate.report.summary import energy

_KEPT = {
    "energy_cut": "the caps",
    "energy_passivity": "the passivity controller",
    "energy_low_pass": "the low-pass",
    "energy_coupling": "the virtual coupling",
}
_NOTHING = 1e-6  # [J]


def words(run: Run) -> str:
    """Text above the figure of the ledger."""
    sentences = [
        "The energy that the rendered force took from the hand, and where it went. While the first curve is above "
        "zero, the surface has returned no more energy than it took. The rest is the energy that springs, damping and "
        "caps do not explain: friction of the surface, and small errors of sampling."
    ]
    source = run.ticks["energy_source"]
    most = np.abs(source).max(axis=0) if len(source) else np.zeros(SIGNALS["energy_source"].size)
    taken = [f"{_name(run, k, len(most))} {energy(float(source[-1, k]))}"
             for k in np.flatnonzero(most > _NOTHING).tolist()]  # fmt: skip
    if taken:
        sentences.append(f"Energy taken by the end, before limits and filters: {', '.join(taken)}.")
    kept = [f"{who} {energy(float(run.ticks[name][-1]))}" for name, who in _KEPT.items()
            if np.abs(run.ticks[name]).max(initial=0.0) > _NOTHING]  # fmt: skip
    if kept:
        sentences.append(f"Energy withheld: {', '.join(kept)}.")
    acting = run.digest.status["passivity"]
    if acting:
        seconds = acting / run.record.rate
        sentences.append(f"The passivity controller reduced the force for {seconds:.2f} s.")
    return " ".join(sentences)


def _name(run: Run, k: int, sources: int) -> str:
    """Name of energy source k: the objects by index, then guidance, then the sum of all others."""
    names = run.object_names
    if k >= sources - 2:
        return "all others" if k == sources - 1 else "guidance"
    return escape(names[k]) if k < len(names) else str(k)
