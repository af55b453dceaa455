"""Tables and sentences of `palpate study guidance` for the terminal."""

from __future__ import annotations

from math import isfinite

from rich.console import RenderableType
from rich.table import Table

from palpate_lab.studies.guidance.result import StudyResult
from palpate_lab.studies.guidance.work import FEW


def tables(found: StudyResult) -> list[RenderableType]:
    """Tables, followed by sentences."""
    title = f"means of {found['operators']} simulated operators"
    means = _table(
        title, ("task", "condition"), ("path error", "time", "mean force", "peak force", "held 50 ms", "entries")
    )
    for row in found["rows"]:
        first = row["condition"] == "none"
        means.add_row(
            row["task"] if first else "", row["condition"], f"{row['path_error_mm']:.2f} mm", f"{row['time_s']:.1f} s",
            f"{row['mean_force_N']:.2f} N", f"{row['peak_force_N']:.2f} N", f"{row['peak_50ms_N']:.2f} N",
            f"{row['entries']:.2f}",
        )  # fmt: skip
    return [
        means,
        _expectations(found),
        _registration(found),
        _ablation(found),
        _cues(found),
        _yields(found),
        *_verdicts(found),
    ]


def _table(title: str, left: tuple[str, ...], right: tuple[str, ...]) -> Table:
    out = Table(box=None, pad_edge=False, title=title, title_justify="left")
    for column in (*left, *right):
        out.add_column(column, justify="left" if column in left else "right")
    return out


def _expectations(found: StudyResult) -> Table:
    columns = ("simulated", "literature", "Hedges' g simulated", "people")
    out = _table(
        "effect of a condition against none, simulated and published", ("task", "condition", "measure"), columns
    )
    for e in found["effects"]:
        if e["expected_hedges_g"] is None or e["change"] is None:
            continue
        range_ = e["expected_change"]
        lit = f"{100 * range_[0]:.0f} .. {100 * range_[1]:.0f} %" if range_ else ""
        simulated = _percent(e["change"], e["change_low"], e["change_high"])
        g = f"{e['hedges_g']:.2f} "
        g += f"({e['hedges_g_low']:.2f} .. {e['hedges_g_high']:.2f})" if isfinite(e["hedges_g_low"]) else "(too few)"
        out.add_row(e["task"], e["condition"], e["measure"].rsplit("_", 1)[0].replace("_", " "),
                    simulated, lit, g, f"{e['expected_hedges_g']:.2f}")  # fmt: skip
    return out


def _percent(change: float, low: float | None, high: float | None) -> str:
    """A relative change with its bounds; without them if the operators are too few for an interval."""
    bounds = [f"{100 * x:+.0f}" for x in (low, high) if x is not None and x == x]
    return f"{100 * change:+.0f} % " + (f"({' .. '.join(bounds)})" if bounds else "(too few operators)")


def _registration(found: StudyResult) -> Table:
    n = min(found["operators"], FEW)
    errors = sorted({row["error_mm"] for row in found["registration"] if row["error_mm"] is not None})
    columns = ("no guidance", *(f"{e:g} mm" for e in errors), "break-even")
    out = _table(f"contact felt, by registration error of the guidance, {n} operators", ("task", "measure"), columns)
    for one in found["break_even"]:
        mine = [row for row in found["registration"] if row["task"] == one["task"]]
        at = one["break_even_mm"]
        even = f"beyond {one['largest_tried_mm']:g} mm" if at is None else f"{at:.1f} mm"
        unit = " mm" if one["measure"].endswith("mm") else ""
        words = one["measure"].removesuffix("_mm").replace("_", " ")
        out.add_row(one["task"], words, *(f"{row[one['measure']]:.2f}{unit}" for row in mine), even)
    return out


def _ablation(found: StudyResult) -> Table:
    out = _table("effect of contact felt, with the operators' haste and without", ("task", "measure"),
                 ("with", "without"))  # fmt: skip
    for row in found["ablation"]:
        out.add_row(row["task"], row["measure"].rsplit("_", 1)[0].replace("_", " "), f"{100 * row['change']:+.0f} %",
                    f"{100 * row['change_without_haste']:+.0f} %")  # fmt: skip
    return out


def _cues(found: StudyResult) -> Table:
    title = f"visual cues alone, with contact felt, and none, {min(found['operators'], FEW)} operators, the same noise"
    out = _table(title, ("task", "condition"), ("path error", "mean force", "peak force", "time"))
    for row in found["visual_cues"]:
        first = row["condition"] == "none"
        out.add_row(row["task"] if first else "", row["condition"], f"{row['path_error_mm']:.2f} mm",
                    f"{row['mean_force_N']:.2f} N", f"{row['peak_force_N']:.2f} N",
                    f"{row['time_s']:.1f} s")  # fmt: skip
    return out


def _yields(found: StudyResult) -> Table:
    shares = list(dict.fromkeys(row["share"] for row in found["yields"]))
    title = f"path error, guidance against none, by the trait yields of {min(found['operators'], FEW)} operators"
    out = _table(title, ("task",), tuple(f"{100 * share:.0f} %" for share in shares))
    for task in dict.fromkeys(row["task"] for row in found["yields"]):
        mine = [row for row in found["yields"] if row["task"] == task]
        out.add_row(task, *(_percent(row["change"], row["change_low"], row["change_high"]) for row in mine))
    return out


def _verdicts(found: StudyResult) -> list[str]:
    both = [(e["change"], e["expected_change"]) for e in found["effects"]]
    graded = [(change, expected) for change, expected in both if expected and change is not None]
    inside = [change for change, (low, high) in graded if low <= change <= high]
    beyond = [change for change, (low, _) in graded if change < low]
    control = ", ".join(
        f"{one['task']} {one['than_right_mm']:+.2f} ({one['than_none_mm']:+.2f})" for one in found["control"]
    )
    worse = "worse in every task" if found["control_works"] else "NOT worse in every task"
    sources = dict.fromkeys(f"{e['measure']}: {e['source']}" for e in found["effects"] if e["source"])
    sure = sum(e["p_holm"] < 0.05 for e in found["effects"])
    return [
        f"{sure} of {len(found['effects'])} effects are not chance, as one family (Holm, 5 %); the intervals are "
        "of each effect alone",
        f"{len(inside)} of {len(graded)} effects lie within the published range, {len(beyond)} are larger",
        f"control, guidance displaced by 5 mm: path error [mm] against correct guidance (none): {control}: {worse}",
        *sources,
        "simulated operators: models, not people (palpate/simulators/operators); simulated arms",
    ]
