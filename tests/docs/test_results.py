"""Figures on the pages are those of the results kept in docs/results (written by tools/results.py).

PHRASES is the one place that ties them: each entry computes a phrase from a result, and the page must contain it.
"""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"
Result = dict[str, Any]


def peak_mm(row: Result) -> str:
    """The overshoot is a percentage of 0.385 m."""
    return f"{3.85 * row['overshoot_percent']:.1f}"


def off(row: Result, key: str, published: str, scale: float = 1.0) -> str:
    return f"{100.0 * (scale * row[key] / row['published'][published] - 1.0):+.0f}"


def table_row(r: Result) -> str:
    p = r["published"]
    settles = "never" if r["settling_s"] is None else f"{r['settling_s']:.2f}"
    over = f"**{r['overshoot_percent']:.{1 if r['limit_cycle'] else 2}f}**" + (
        " and growing" if r["limit_cycle"] else ""
    )
    rests = f"{'swings +-' if r['limit_cycle'] else ''}{1e3 * r['steady_state_m']:.{0 if r['limit_cycle'] else 1}f}"
    return (
        f"| {r['kd']:g} | {p['offshoot_percent']:g}, {over} | {3.85 * p['offshoot_percent']:.1f}, {peak_mm(r)} | "
        f"{p['response_s']:g}, {settles} | {p['steady_state_cm'] / 10:.1f}, {rests} | "
        f"{1e3 * r['energy_J']:.0f} |"
    )


def wall_rows(found: Result) -> list[str]:
    return [table_row(row) for row in found["rows"]]


def wall_misses(found: Result) -> list[str]:
    first, second, third = found["rows"]
    less = -float(off(first, "overshoot_percent", "offshoot_percent"))
    pairs = {
        key: [off(row, key, published, scale) for row in (second, third)]
        for key, published, scale in (("overshoot_percent", "offshoot_percent", 1.0), ("settling_s", "response_s", 1.0),
                                      ("steady_state_m", "steady_state_cm", 1e4))
    }  # fmt: skip
    return [
        "({} and {} %)".format(*pairs["overshoot_percent"]),
        f"row 1 overshoots {less:.0f} % less than published",
        "settling is off by {} and {} %".format(*pairs["settling_s"]),
        "the resting depth by {} and {} %".format(*pairs["steady_state_m"]),
    ]


def wall_text(found: Result) -> list[str]:
    first, second, third = found["rows"]
    shipped = {(r["rate_Hz"], r["kd"]): r["overshoot_percent"] for r in found["other_rates"]}
    passive = found["passive_rows"]
    change = max(abs(a["overshoot_percent"] / b["overshoot_percent"] - 1.0)
                 for a, b in zip(passive[1:], found["rows"][1:], strict=True))  # fmt: skip
    assert not any(row["limit_cycle"] for row in passive)
    return [
        f"speed out over speed in: {first['rebound']:.2f} at the first bounce",
        f"({1e3 * first['swing_m']:.0f} mm peak to peak) after four seconds",
        f"rows 2 and 3 come to {shipped[250.0, 5.0]:.2f} and {shipped[250.0, 10.0]:.2f} %",
        f"to {shipped[100.0, 5.0]:.1f} % (oscillating) and {shipped[100.0, 10.0]:.2f} %",
        f"falls from {second['rigidity_N_per_m']:.0f} to {third['rigidity_N_per_m']:.0f} N/m",
        f"Row 1 overshoots {passive[0]['overshoot_percent']:.1f} % and settles in {passive[0]['settling_s']:.2f} s",
        f"as before to within {100.0 * change:.1g} %",
        f"({-1e3 * min(row['energy_J'] for row in passive):.0f} mJ)",
    ]


def wall_hands(found: Result) -> list[str]:
    assert {row["hands"]["people"] for row in found["rows"]} == {100}
    shares = [round(100.0 * row["hands"]["limit_cycle_share"]) for row in found["rows"]]
    return [rf"| {row['kd']:g} \|.*\| {share or 'none'} |" for row, share in zip(found["rows"], shares, strict=True)]


SCENES = ("liver, gallbladder, duodenum", "closed cage with one window of 12 mm", "two instruments crossing")


def planning_rows(found: Result) -> list[str]:
    rows = found["rows"]
    ways = [(r["straight"], r["retracted"], r["queries"] - r["straight"] - r["retracted"]) for r in rows]
    return [
        f"| {name} | {100 * r['success_rate']:.0f} % | {r['median_s']:.2f} and {r['p95_s']:.2f} s | "
        f"{way[0]}, {way[1]}, {way[2]} | {r['violations']} of {r['checked_samples']:,} |"
        for name, r, way in zip(SCENES, rows, ways, strict=True)
    ]


def tissue_ticks(found: Result) -> list[str]:
    return [f"| {int(n):,} | {t['p50']:.2f} / {t['p99']:.2f} ms |" for n, t in found["tick_ms"].items()]


def tissue_rows(found: Result) -> list[str]:
    return [
        f"| {r['name']} | {r['value']:.3g} {r['unit']} | {'>=' if r['least'] else '<='} {r['asked']:g} {r['unit']} | "
        f"{'yes' if r['met'] else '**no**'} |"
        for r in found["rows"]
        if r["unit"] != "ms"  # times are those of the idle machine
    ]


def tissue_text(found: Result) -> list[str]:
    m, late = found["mujoco"], found["realtime"]
    ticks, missed, bare = round(1000 * late["seconds"]), late["missed"], late["control_missed"]
    errors = f"errs by {100 * m['layer_error']:+.1f} %, Palpate by {100 * m['own_layer_error']:+.1f} %"
    return [errors, f"missed {missed} of {ticks} ticks, a bare loop in turns with it {bare}"]


def tissue_mujoco(found: Result) -> list[str]:
    return [f"MuJoCo takes {found['mujoco']['tick_ms']['p50']:.1f} ms a step"]


PHRASES: dict[str, tuple[str, list[Callable[[Result], list[str]]]]] = {
    "wall": ("wall.md", [wall_rows, wall_misses, wall_text, wall_hands]),
    "planning": ("planning.md", [planning_rows]),
    "tissue": ("tissue-figures.md", [tissue_rows, tissue_text]),
    "tissue_times": ("tissue-figures.md", [tissue_ticks, tissue_mujoco]),
}
"""By result: its page, and what computes phrases of it. A phrase with `\\|.*\\|` leaves columns of other runs out."""


def missing(page: str, phrases: list[str]) -> list[str]:
    """The phrases that are not on the page; line breaks count as spaces."""
    text = " ".join(page.split())
    parts = {phrase: re.escape(phrase).replace(re.escape(r"\|.*\|"), r"\|[^|]*\|[^|]*\|") for phrase in phrases}
    return [phrase for phrase, pattern in parts.items() if not re.search(pattern, text)]


def kept(name: str) -> Result:
    return json.loads((DOCS / "results" / f"{name}.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize(("name", "phrases"), [(name, one) for name, (_, all_) in PHRASES.items() for one in all_])
def test_pages_have_the_figures_of_the_kept_results(name, phrases):
    page = (DOCS / PHRASES[name][0]).read_text(encoding="utf-8")
    assert missing(page, phrases(kept(name)["result"])) == []


@pytest.mark.parametrize("name", PHRASES)
def test_a_figure_that_differs_is_found(name):
    """The page has no phrase whose last digit is changed."""
    page, makers = PHRASES[name]
    result = kept(name)["result"]
    text = (DOCS / page).read_text(encoding="utf-8")
    for maker in makers:
        for phrase in maker(result):
            other = re.sub(r"none|(\d)(?=\D*$)", lambda m: str((int(m[1] or 4) + 1) % 10), phrase)
            assert missing(text, [other]) == [other], phrase


@pytest.mark.parametrize("path", sorted((DOCS / "results").glob("*.json")), ids=lambda path: path.stem)
def test_a_result_says_how_to_repeat_it(path):
    found = json.loads(path.read_text(encoding="utf-8"))
    assert found["command"].startswith("palpate ")
    assert re.fullmatch(r"[0-9a-f]{12}\+?", found["commit"])
    assert found["control_numpy_import_s"] > 0.0
    assert isinstance(found["seed"], int)
    assert path.stem in PHRASES, "no page is compared with it"
