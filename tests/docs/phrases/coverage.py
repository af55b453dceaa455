"""Phrases of the page on printed intervals."""

from __future__ import annotations

from collections import Counter

from palpate.base.arrays.intervals import proportion
from palpate_lab.verify.coverage.run import ASKED, TOLD
from palpate_lab.verify.coverage.trial import RIGHT
from phrases.values import Result, Tie, kept


def share(found: float, ends: tuple[float, float]) -> str:
    """A share with its Clopper-Pearson interval [%]."""
    low, high = ends
    return f"{100 * found:.1f} ({100 * low:.0f}-{100 * high:.0f})"


def coverage_rows(found: Result) -> list[str]:
    out, last = [], ""
    for r in found["rows"]:
        command, last = "" if r["estimate"] == last else f" {r['command']} ", r["estimate"]
        cover = "refused" if r["cover"] is None else share(r["cover"], r["cover_95"])
        bias = "-" if r["bias"] is None else f"{r['bias']:.2g}"
        told = share(r["told"], proportion(r["told"], r["trials"]))
        if r["possible"] is not None:
            told += f" of {100 * r['possible']:.0f}"
        out.append(f"|{command}|{r['description']}|{r['trials']}|{cover}|{bias}|{told}|")
    return out


def coverage_sum(found: Result) -> list[str]:
    rows = found["rows"]
    return [f"Of {len(rows)} rows {sum(r['met'] for r in rows)} meet what is asked"]


def coverage_proof(found: Result) -> list[str]:
    """Which rows prove what is asked, by their intervals, and which have fewer trials."""
    right = [r for r in found["rows"] if r["form"] == RIGHT]
    inside = [r for r in right if ASKED[0] <= r["cover_95"][0] and r["cover_95"][1] <= ASKED[1]]
    wrong = [r for r in found["rows"] if r["form"] != RIGHT and r["bias"] is not None and r["bias"] > 1.0]
    short = [r for r in wrong if proportion(r["told"], r["trials"])[0] < TOLD]
    assert not inside
    fewer: dict[str, list[str]] = {}
    for r in found["rows"]:
        if r["trials"] < found["trials"]:
            sizes = fewer.setdefault(r["command"], [])
            sizes.extend({str(r["trials"])} - set(sizes))
    shortest = ", ".join(f"`{command}` ({' and '.join(sizes)})" for command, sizes in fewer.items())
    names = ", ".join(f"{n} of `{command}`" for command, n in Counter(r["command"] for r in short).items())
    return [
        f"None of the {len(right)} right forms proves 93 to 97 %",
        f"{len(wrong) - len(short)} of the {len(wrong)} biased wrong forms prove 90 % told; not: {names}",
        f"Fewer than {found['trials']} trials: {shortest}",
    ]


def coverage_missed(found: Result) -> list[str]:
    """The rows that are not met, with the share of the trials that were told."""
    return [
        f"`{r['command']}`, {r['description']}: {share(r['told'], proportion(r['told'], r['trials']))} % told"
        for r in found["rows"]
        if not r["met"]
    ]


def coverage_versions(_: Result) -> list[str]:
    first, last = kept("coverage")["merged_commits"]
    return [f"of versions between {first[:8]} and {last[:8]}"]


TIES = [
    Tie("coverage.md", "coverage", (coverage_sum, coverage_proof, coverage_versions, coverage_missed)),
    Tie("coverage-table.md", "coverage", (coverage_rows,)),
]
