"""Fig 13 and Table 1: the virtual wall, and whether any plausible hand gives all three rows."""

from __future__ import annotations

from dataclasses import astuple, dataclass, fields
from functools import lru_cache, partial
from typing import Any, cast

import numpy as np
from matplotlib.figure import Figure
from rich.console import Console

from palpate.base.arrays import Array
from palpate.base.plotting.style import FORCE, INK, MUTED, TOOL, Canvas, plain_ticks
from palpate.base.sweep import Axis, Swept, sweep
from palpate.base.sweep.grid import Point
from palpate_lab.reproduce.item import Drawing, Item, Outcome, Work
from palpate_lab.studies.wall import figures, fit
from palpate_lab.studies.wall.bench import OSCILLATES, WALL, Setting, WallPress, judge, press, swing
from palpate_lab.studies.wall.result import StudyResult, Traces
from palpate_lab.studies.wall.work import KDS, TABLE_1
from palpate_lab.studies.wall.work import run as run_wall

_HANDS = 60  # other hands of the ranges of 90 % [-]
_TRIED = 900  # random candidates of the fit of all rows [-]
_REFINED, _STEPS = 8, 45  # best candidates that are refined, and random steps of each [-]
TOGETHER = 0.2  # largest relative error of the three overshoots that counts as giving them together [-]


@dataclass(frozen=True)
class Candidate:
    """What is unknown of the published experiment."""

    hand: WallPress
    friction_scale: float
    """Dry friction over that of the model file [-]."""
    velocity_cutoff_Hz: float
    """Cutoff of the low-pass of the measured velocity [Hz]."""

    def setting(self, kd: float) -> Setting:
        """The wall with damping kd [N s/m] on this arm."""
        return Setting(kd, coulomb_scale=self.friction_scale, velocity_cutoff=self.velocity_cutoff_Hz)

    def values(self) -> dict[str, float]:
        """All values by name."""
        hand = {field.name: getattr(self.hand, field.name) for field in fields(self.hand)}
        return {**hand, "friction_scale": self.friction_scale, "velocity_cutoff_Hz": self.velocity_cutoff_Hz}


LOW = Candidate(fit.LOW, 0.1, 5.0)
HIGH = Candidate(fit.HIGH, 2.0, 150.0)
_NAMES = tuple(LOW.values())
_LOW, _HIGH = (np.log(np.array([*astuple(c.hand), c.friction_scale, c.velocity_cutoff_Hz])) for c in (LOW, HIGH))
_PUBLISHED = np.array([TABLE_1[kd].offshoot_percent for kd in KDS])


def candidate(x: Array) -> Candidate:
    """The candidate with the logarithms x (8,) of its values."""
    *hand, friction, cutoff = (float(value) for value in np.exp(x))
    return Candidate(WallPress(*hand), friction, cutoff)


def overshoots(c: Candidate) -> tuple[Array, bool]:
    """Overshoot of the three rows (3,) [%], and whether rows 2 and 3 are at rest after four seconds, as published.

    NaN from the second row on if the first is wrong by more than 3 times.
    """
    found, rests = np.full(3, np.nan), True
    for i, kd in enumerate(KDS):
        trace = press(c.setting(kd), c.hand, follow=False)
        found[i] = 100.0 * max(float(trace.y.max()) - WALL, 0.0) / WALL
        if i == 0 and not 1.0 / 3.0 < found[0] / _PUBLISHED[0] < 3.0:
            break
        rests = rests and (i == 0 or swing(trace) <= OSCILLATES)
    return found, rests


def error(found: Array, rests: bool = True) -> float:
    """Largest relative error of the three overshoots, as a factor less one; infinite if a row is missing.

    One is added if rows 2 and 3 do not come to rest, so that such a hand never counts as giving the rows.
    """
    if not np.isfinite(found).all():
        return float("inf")
    with np.errstate(divide="ignore"):
        return float(np.exp(np.abs(np.log(found / _PUBLISHED)).max()) - 1.0) + (0.0 if rests else 1.0)


def tried(point: Point, seed: int) -> dict[str, Any]:
    """One random candidate of the ranges; depends on its number and the seed of the sweep alone."""
    x = np.random.default_rng(seed).uniform(_LOW, _HIGH)
    return _row(x)


def _row(x: Array) -> dict[str, Any]:
    found, rests = overshoots(candidate(x))
    return {"x": x.tolist(), "overshoots": found.tolist(), "error": error(found, rests)}


def refined(point: Point, seed: int) -> dict[str, Any]:
    """Random steps from a candidate, always on from the best so far, within the ranges."""
    rng, best = np.random.default_rng(seed), _row(np.array([float(text) for text in point["start"].split()]))
    rows = [best]
    for step in range(int(point["steps"])):
        width = 0.25 * 0.93**step
        x = np.clip(np.array(best["x"]) + rng.normal(0.0, width, len(_LOW)), _LOW, _HIGH)
        rows.append(_row(x))
        best = min(best, rows[-1], key=lambda row: float(row["error"]))
    return {name: [row[name] for row in rows] for name in ("x", "overshoots", "error")}


@lru_cache(2)
def together(seed: int, workers: int | None, count: int = _TRIED) -> list[dict[str, Any]]:
    """All candidates that were tried, the best first."""
    quiet = Console(quiet=True)
    first = sweep(tried, {"candidate": Axis(range(count))}, seed, workers=workers, console=quiet, title="hands").rows()
    rows = sorted(first, key=lambda row: float(row["error"]))
    starts = [" ".join(map(repr, row["x"])) for row in rows[:_REFINED]]
    grid = {"start": Axis(starts), "steps": Axis([_STEPS])}
    more = sweep(refined, grid, seed + 1, workers=workers, console=quiet, title="steps").rows()
    names = ("x", "overshoots", "error")
    rows += [
        dict(zip(names, values, strict=True)) for one in more for values in zip(*(one[n] for n in names), strict=True)
    ]
    return sorted(rows, key=lambda row: float(row["error"]))


@lru_cache(2)
def study(seed: int, workers: int | None) -> tuple[StudyResult, Traces]:
    """The numbers and the traces of ``palpate study wall`` with `_HANDS` other hands."""

    def quiet_sweep(fn: Any, grid: Any, _: int = 0, **more: Any) -> Swept:
        return sweep(fn, grid, seed, workers=workers, console=Console(quiet=True), **more)

    return run_wall(cast(Any, quiet_sweep), _HANDS)


def fig13(work: Work) -> Outcome:
    """The handle over time for three gains, with the ranges of other hands."""
    found, traces = study(work.seed, work.workers)
    rows = found["rows"]
    over = [r["overshoot_percent"] for r in rows]
    falls = over[0] > over[1] > over[2]
    rigid = [r["rigidity_N_per_m"] for r in rows]
    inside = [
        bool(lo <= p <= hi)
        for p, (lo, _, hi) in zip(_PUBLISHED, (r["hands"]["overshoot_percent"] for r in rows), strict=True)
    ]
    value = {
        "overshoot_percent": over, "overshoot_90_percent_of_hands": [r["hands"]["overshoot_percent"] for r in rows],
        "rigidity_at_rest_N_per_m": rigid, "hands": _HANDS, "hand": found["hand"],
        "published_within_90_percent_of_hands": inside,
    }  # fmt: skip
    data = [
        {"kd_N_s_per_m": kd, "t_s": float(t), "y_m": float(y)}
        for kd in KDS for t, y in zip(traces[kd][0].t[::4], traces[kd][0].y[::4], strict=True)
    ]  # fmt: skip
    hand = WallPress.fitted()
    return Outcome(
        "differs" if not all(inside) or not falls else "agrees",
        value,
        {"overshoot_percent": _PUBLISHED.tolist(), "trend": "more damping, less overshoot, less rigid"},
        "The trend is that of the paper: more damping, less overshoot, and for the fitted hand a softer wall at rest. "
        "B and "
        f"C have the published height; A is an oscillation here, whose peak after 4 s is {over[0]:.1f} instead of "
        "10.2 %, "
        f"above that of 95 % of {_HANDS} other hands. Table 1 below says which hands would give it. Hand: "
        f"{hand.mass_kg:g} kg, {hand.damping_N_s_per_m:g} N s/m, {hand.stiffness_N_per_m:g} N/m, push "
        f"{hand.push_N:.2g} N; loop delay {1e3 * hand.delay_s:g} ms (a fit, not a proof).",
        data,
        [
            Drawing("", "A to C: the handle along y over time, without (red) and with passivity (blue).",
                    lambda canvas: figures.figure13(traces, canvas)),
            Drawing("hands", f"{_HANDS} other hands: overshoot, rigidity at rest and rebound over K_d, and sensitivity "
                             "of the fit.", lambda canvas: figures.hands(found, canvas)),
        ],
    )  # fmt: skip


def table1(work: Work) -> Outcome:
    """All columns for the fitted hand, and the best of all tried hands."""
    fitted = [judge(press(Setting(kd), WallPress.fitted())) for kd in KDS]
    rows = together(work.seed, work.workers)
    best = candidate(np.array(rows[0]["x"]))
    judged = [judge(press(best.setting(kd), best.hand)) for kd in KDS]
    region = [row for row in rows if row["error"] <= TOGETHER]
    exists = bool(region)
    data, lines = [], []
    for i, (kd, ours) in enumerate(zip(KDS, fitted, strict=True)):
        printed, all_rows = TABLE_1[kd], judged[i]
        data.append({
            "kd": kd, "overshoot_published": printed.offshoot_percent, "overshoot_fitted": ours["overshoot_percent"],
            "overshoot_best_of_all_rows": all_rows["overshoot_percent"], "response_published_s": printed.response_s,
            "response_fitted_s": ours["settling_s"], "response_best_s": all_rows["settling_s"],
            "steady_state_printed_cm": printed.steady_state_cm, "steady_state_read_mm": 1e3 * printed.steady_state_m,
            "steady_state_fitted_mm": 1e3 * ours["steady_state_m"],
            "steady_state_best_mm": 1e3 * all_rows["steady_state_m"],
            "oscillates_fitted": ours["limit_cycle"], "oscillates_best": all_rows["limit_cycle"],
        })  # fmt: skip
        lines.append(_line(data[-1]))
    ranges = {
        name: [low, high] for name, low, high in zip(_NAMES, np.exp(_LOW).tolist(), np.exp(_HIGH).tolist(), strict=True)
    }
    value = {
        "rows": data, "best_hand_for_all_rows": best.values(), "largest_relative_error": rows[0]["error"],
        "tried": len(rows), "give_all_three_within_20_percent": len(region), "ranges": ranges,
        "region": {name: [float(np.exp(min(r["x"][i] for r in region))), float(np.exp(max(r["x"][i] for r in region)))]
                   for i, name in enumerate(_NAMES)} if exists else None,
    }  # fmt: skip
    return Outcome(
        "differs",
        value,
        {"overshoot_percent": _PUBLISHED.tolist(), "response_s": [TABLE_1[kd].response_s for kd in KDS],
         "steady_state_cm_as_printed": [TABLE_1[kd].steady_state_cm for kd in KDS]},
        _why(best, rows, len(region), judged[0]["limit_cycle"]),
        data,
        [Drawing("region", "Candidates over delay, damping, mass, stiffness, friction, filter; red: all overshoots "
                           f"within {100 * TOGETHER:.0f} % of the published, rows 2 and 3 at rest; cross: the best.",
                 partial(_region, rows))],
        '<div class="scroll"><table><tr><th>K_d</th><th>% offshoot</th><th>response [s]</th><th>steady state [mm]</th>'
        f"<th>oscillates</th></tr>{''.join(lines)}</table></div><p>Each cell: published | fitted to rows 2 and 3 | "
        "best hand "
        "for all three rows. The steady state is printed as 100, 15 and 20 cm and read as 1.00, 0.15 and 0.20 cm.</p>",
    )  # fmt: skip


def _why(best: Candidate, rows: list[dict[str, Any]], region: int, oscillates: bool) -> str:
    tried = f"Of {len(rows)} combinations of hand, delay, friction and velocity filter within the stated ranges "
    if region:
        hand = best.hand
        first = (
            f"{region} give all three overshoots within {100 * TOGETHER:.0f} % with rows 2 and 3 at rest, the best "
            "within "
            f"{100 * rows[0]['error']:.0f} %: {hand.mass_kg:.2g} kg, {hand.damping_N_s_per_m:.2g} N s/m, "
            f"{hand.stiffness_N_per_m:.3g} N/m, push {hand.push_N:.2g} N, {1e3 * hand.delay_s:.3g} ms of delay, "
            f"{best.friction_scale:.2g} times the friction of our model, velocities filtered at "
            f"{best.velocity_cutoff_Hz:.3g} Hz. So such a hand exists, and nothing says that it was theirs."
        )
    else:
        first = (
            f"none gives all three overshoots within {100 * TOGETHER:.0f} % with rows 2 and 3 at rest: the best is "
            "off by "
            f"{100 * rows[0]['error']:.0f} % in its worst row. Within these ranges no such hand was found."
        )
    row1 = " Row 1 is an oscillation, whose peak depends on when one looks; a response time and an error it has not."
    return (
        tried
        + first
        + (row1 if oscillates else "")
        + (" The published hand was not measured, so the cause of the difference cannot be told without the robot.")
    )


def _line(d: dict[str, Any]) -> str:
    def cell(*values: float | None, digits: int) -> str:
        return "<td>" + " | ".join("never" if v is None else f"{v:.{digits}f}" for v in values) + "</td>"

    swing = " | ".join(
        "?" if v is None else ("yes" if v else "no") for v in (None, d["oscillates_fitted"], d["oscillates_best"])
    )
    return (
        f"<tr><td>{d['kd']:g}</td>"
        + cell(d["overshoot_published"], d["overshoot_fitted"], d["overshoot_best_of_all_rows"], digits=2)
        + cell(d["response_published_s"], d["response_fitted_s"], d["response_best_s"], digits=2)
        + cell(d["steady_state_read_mm"], d["steady_state_fitted_mm"], d["steady_state_best_mm"], digits=1)
        + f"<td>{swing}</td></tr>"
    )


_PLANES = ((5, 1), (0, 2), (6, 7))
_AXES = {
    "mass_kg": "hand's mass [kg]", "damping_N_s_per_m": "hand's damping [N s/m]",
    "stiffness_N_per_m": "hand's stiffness [N/m]", "delay_s": "loop delay [s]",
    "friction_scale": "dry friction over model's",
    "velocity_cutoff_Hz": "velocity filter [Hz]",
}  # fmt: skip


_TICKS = {
    "delay_s": (0.005, 0.01, 0.02, 0.04), "mass_kg": (0.02, 0.05, 0.1, 0.2, 0.5),
    "friction_scale": (0.1, 0.2, 0.5, 1.0, 2.0),
}  # fmt: skip


def _region(rows: list[dict[str, Any]], canvas: Canvas) -> Figure:
    figure = Figure(figsize=(canvas.width, 3.3), layout="constrained")
    x, off = np.exp(np.array([row["x"] for row in rows])), np.array([row["error"] for row in rows])
    near = off <= TOGETHER
    half = (off <= 0.5) & ~near
    for axes, (i, j) in zip(figure.subplots(1, 3), _PLANES, strict=True):
        axes.loglog(x[~near & ~half, i], x[~near & ~half, j], ".", ms=2, color="#c9d2d8", label="tried")
        axes.loglog(x[half, i], x[half, j], "o", ms=3, color="#7d8b96", label="all three within 50 %")
        if near.any():
            axes.loglog(x[near, i], x[near, j], "o", ms=3.5, color=FORCE, label=f"within {100 * TOGETHER:.0f} %")
        axes.plot(x[0, i], x[0, j], "x", ms=8, mew=2, color=INK, label="best")
        fitted = WallPress.fitted()
        own = [*astuple(fitted), 1.0, np.nan]
        axes.plot(own[i], own[j], "s", ms=5, mfc="none", color=TOOL, label="fitted to rows 2, 3")
        axes.set(xlabel=_AXES[_NAMES[i]], ylabel=_AXES[_NAMES[j]])
        plain_ticks(axes, _TICKS[_NAMES[i]])
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=5, labelcolor=MUTED)
    return figure


_CODE = ("lab/palpate_lab/studies/wall/bench.py", "lab/palpate_lab/studies/wall/work.py", "scenes/wall.yaml")
_READ = (
    "“% offshoot” is read against 0.385 m (peaks of 39.3, 4.9, 4.8 mm), “response time” as settling within 5 % of the "
    "peak "
    "penetration, the steady-state error as 1.00, 0.15, 0.20 cm, because 400 N/m over 1 m would be 400 N."
)

ITEMS = (
    Item("fig13", "The virtual wall", "Section 4, Fig 13 A–C",
         "The master's position along y as it meets a wall at 0.385 m, for K_p 400 and K_d 0, 5, 10: more damping "
         "lowers "
         "the overshoot, at the cost of rigidity.",
         fig13, ("R41", "R42", "R48", "R49"), _READ, _CODE,
         "The authors' later published code ran the wall at 500 Hz, collision at 250 Hz and teleoperation at 100 Hz."),
    Item("table1", "Values of the virtual wall", "Section 4, Table 1",
         "Response time, overshoot and steady-state error of the three gains.", table1, ("R41", "R42"), _READ, _CODE),
)  # fmt: skip
