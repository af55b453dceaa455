"""Residuals of an equation, each judged by a second way of computing the same quantity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from palpate.base.arrays import Array
from palpate.base.plotting.style import CAP, FORCE, INK, MUTED, TOOL, Canvas
from palpate_lab.reproduce.item import Drawing, Outcome, Values, Verdict

_SMALLEST = 1e-18  # residuals of exactly zero are drawn here


@dataclass(frozen=True)
class Check:
    """Residuals of one statement."""

    what: str
    """The statement, e.g. ``M(q)``."""
    second: str
    """The second way of computing it."""
    residuals: Array
    """Absolute difference of both ways at each pose or sample (n,); 0 is perfect."""
    tolerance: float
    unit: str = "1"

    @property
    def worst(self) -> float:
        """Largest residual."""
        return float(np.max(self.residuals))

    @property
    def holds(self) -> bool:
        """True if every residual is finite and within the tolerance."""
        return bool(np.isfinite(self.residuals).all()) and self.worst <= self.tolerance


def outcome(
    checks: Sequence[Check], paper: str, why: str, *, verdict: Verdict | None = None, more: Values | None = None
) -> Outcome:
    """The outcome of an equation: it agrees if every check holds, unless a verdict is given.

    A check that fails makes the verdict "differs", whatever was given, and is named.
    """
    failed = [check for check in checks if not check.holds]
    if failed:
        names = "; ".join(f"{c.what} by {c.worst:.2g} {c.unit} (tolerance {c.tolerance:.2g})" for c in failed)
        verdict, why = "differs", f"Not within the tolerance: {names}. {why}"
    rows = [
        {
            "statement": c.what, "second_way": c.second, "samples": len(c.residuals), "largest_residual": c.worst,
            "median_residual": float(np.median(c.residuals)), "tolerance": c.tolerance, "unit": c.unit,
        }
        for c in checks
    ]  # fmt: skip
    return Outcome(
        verdict or "agrees",
        {"residuals": {c.what: c.worst for c in checks}, **(more or {})},
        paper,
        why,
        rows,
        [Drawing("", "Residuals of all samples; the mark is the tolerance.", lambda canvas: draw(checks, canvas))],
        _table(checks),
    )


def draw(checks: Sequence[Check], canvas: Canvas) -> Figure:
    """One row of dots for each check on a logarithmic axis, with its tolerance."""
    figure = Figure(figsize=(0.82 * canvas.width, 0.75 + 0.5 * len(checks)), layout="constrained")
    axes = figure.subplots()
    rng = np.random.default_rng(0)
    for row, check in enumerate(checks):
        x = np.maximum(np.abs(check.residuals), _SMALLEST)
        y = row + rng.uniform(-0.18, 0.18, len(x))
        axes.plot(x, y, ".", ms=3, color=TOOL if check.holds else FORCE, alpha=0.6)
        axes.plot([check.tolerance] * 2, [row - 0.33, row + 0.33], color=CAP, lw=1.8)
        label = f"{check.what}\n{check.second}"
        axes.annotate(label, (0.0, row), xycoords=("axes fraction", "data"), xytext=(-6, 0),
                      textcoords="offset points", ha="right", va="center", fontsize=7, color=INK)  # fmt: skip
    axes.set(xscale="log", ylim=(len(checks) - 0.5, -0.5), yticks=[])
    low = min(float(np.maximum(np.abs(c.residuals), _SMALLEST).min()) for c in checks)
    axes.set_xlim(0.3 * low, 30.0 * max(max(c.tolerance, c.worst) for c in checks))
    axes.set_xlabel("residual, each in its own unit (table); mark: tolerance", color=MUTED)
    return figure


def _table(checks: Sequence[Check]) -> str:
    from html import escape

    lines = "".join(
        f"<tr><td>{escape(c.what)}</td><td>{escape(c.second)}</td><td class=value>{len(c.residuals)}</td>"
        f"<td class=value>{c.worst:.2g}</td><td class=value>{c.tolerance:.2g}</td>"
        f"<td>{escape('' if c.unit == '1' else c.unit)}</td></tr>"
        for c in checks
    )
    head = (
        "<tr><th>statement</th><th>second way</th><th>samples</th><th>largest residual</th><th>tolerance</th>"
        "<th>unit</th></tr>"
    )
    return f'<div class="scroll"><table>{head}{lines}</table></div>'
