"""Phrases of the page on printed intervals."""

from __future__ import annotations

from palpate.arrays.intervals import proportion
from phrases.values import Result, Tie


def share(found: float, ends: tuple[float, float]) -> str:
    """A share with its Clopper-Pearson interval [%]."""
    low, high = ends
    return f"{100 * found:.1f} ({100 * low:.0f}-{100 * high:.0f})"


def coverage_rows(found: Result) -> list[str]:
    out = []
    for r in found["rows"]:
        cover = "refused" if r["cover"] is None else share(r["cover"], r["cover_95"])
        bias = "-" if r["bias"] is None else f"{r['bias']:.2g}"
        told = share(r["told"], proportion(r["told"], r["trials"]))
        out.append(f"| {r['command']} | {r['description']} | {r['trials']} | {cover} | {bias} | {told} |")
    return out


def coverage_sum(found: Result) -> list[str]:
    rows = found["rows"]
    return [f"Of {len(rows)} rows {sum(r['met'] for r in rows)} meet what is asked"]


TIES = [Tie("coverage.md", "coverage", (coverage_rows, coverage_sum))]
