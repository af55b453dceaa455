"""The energy ledger in words: what each object took from the hand, and what the stage `stability` kept from it."""

from __future__ import annotations

from html import escape

import numpy as np

from palpate.record.ticks import SIGNALS, STATUS
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
    """Below the picture of the ledger."""
    told = [
        "What the rendered force took from the hand, and where it went. The first curve staying above zero means that "
        "the surface never pushed by itself. The rest is what springs, damping and caps do not explain: friction of "
        "the surface, and small errors of sampling."
    ]
    source = run.ticks["energy_source"]
    most = np.abs(source).max(axis=0) if len(source) else np.zeros(SIGNALS["energy_source"].size)
    taken = [f"{_name(run, k, len(most))} {energy(float(source[-1, k]))}"
             for k in np.flatnonzero(most > _NOTHING).tolist()]  # fmt: skip
    if taken:
        told.append(f"Wanted of the hand by the end: {', '.join(taken)}.")
    kept = [f"{who} {energy(float(run.ticks[name][-1]))}" for name, who in _KEPT.items()
            if np.abs(run.ticks[name]).max(initial=0.0) > _NOTHING]  # fmt: skip
    if kept:
        told.append(f"Of it withheld: {', '.join(kept)}.")
    acting = (run.ticks["status"].astype(np.int64) & STATUS["passivity"][0]) != 0
    if acting.any():
        told.append(f"Passivity held the force back for {acting.sum() / run.record.rate:.2f} s.")
    return " ".join(told)


def _name(run: Run, k: int, sources: int) -> str:
    """Objects by their index, then guidance, and last all the rest."""
    names = run.object_names
    if k >= sources - 2:
        return "all the rest" if k == sources - 1 else "guidance"
    return escape(names[k]) if k < len(names) else str(k)
