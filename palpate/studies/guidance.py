"""``palpate study guidance``: do virtual fixtures, forces and visual cues help? Simulated operators answer.

They are models, not people (`palpate.operators`, with the source of every trait). Each does four tasks under each
condition, in closed loop through the whole chain: hand, master arm, haptic cycle with its caps, instrument. Effects are
against the console without help, with confidence from a bootstrap over the operators; beside them stands what the
literature says of people. The control is guidance that lies beside the truth: it has to make things worse.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console, RenderableType
from rich.table import Table
from tyro.conf import arg

from palpate import _core, conformance
from palpate.operators import Operator, Senses, cohort, perform
from palpate.operators.errand import Trial
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate.studies.command import Findings, SweepCommand, Sweeper
from palpate.studies.guidance_tasks import DISPLACED, SCALE, TASKS, Task
from palpate.sweep import Axis, Label, sweep
from palpate.sweep.grid import Point

Array = NDArray[np.float64]

SEED = 7
MOST = 15.0
"""Longest trial [s]."""
BOOTSTRAPS = 2000
STEADY = 0.05e-3
"""The forbidden region counts as left once the tool is so far outside of it [m]."""


@dataclass(frozen=True)
class Condition:
    """What the console gives."""

    words: str
    senses: Senses
    forces: bool = False
    """contact is felt."""
    guidance: str = ""
    """`right`, `wrong` (the control), or none."""


CONDITIONS: dict[str, Condition] = {
    "none": Condition("the picture alone", Senses()),
    "visual": Condition("path drawn, force as a bar", Senses("shown", drawn=True)),
    "haptics": Condition("contact felt", Senses("felt"), forces=True),
    "guidance": Condition("guidance felt, contact not", Senses(), guidance="right"),
    "haptics+guidance": Condition("contact and guidance felt", Senses("felt"), forces=True, guidance="right"),
    "control_wrong": Condition("as before, guidance 5 mm beside", Senses("felt"), forces=True, guidance="wrong"),
}

MEASURES = {
    "path_error_mm": Label("mm", "rms distance from the path"),
    "time_s": Label("s", "until the end of the path"),
    "mean_force_N": Label("N", "of the tool on what it touches, mean over the trial"),
    "peak_force_N": Label("N", "of the tool on what it touches"),
    "entries": Label("", "times the tool went into the forbidden region"),
}

#: (condition, measure): change against `none` that the literature lets expect, and Hedges' g with its source.
EXPECTED: dict[tuple[str, str], tuple[tuple[float, float] | None, float, str]] = {
    ("guidance", "path_error_mm"): ((-0.70, -0.20), 1.28, "path error -20 to -70 %"),
    ("haptics+guidance", "path_error_mm"): ((-0.70, -0.20), 1.28, "path error -20 to -70 %"),
    ("haptics", "peak_force_N"): ((-0.50, -0.30), 0.69, "peak force about -40 %"),
    ("haptics+guidance", "peak_force_N"): ((-0.50, -0.30), 0.69, "peak force about -40 %"),
    ("haptics", "mean_force_N"): (None, 0.83, ""),
    ("haptics+guidance", "mean_force_N"): (None, 0.83, ""),
}
SOURCE = "Hedges' g of people: Bergholz, Ferle and Weber 2023 (meta-analysis, 56 papers, haptic feedback in RAS)"


@dataclass
class Study(SweepCommand):
    """Virtual fixtures, forces and visual cues in four tasks, done by simulated operators (some four minutes).

    examples:
      palpate study guidance
      palpate study guidance --json guidance.json --figures docs/images
      palpate study guidance --conformance
    """

    operators: Annotated[int, arg(metavar="N")] = 200
    """How many simulated operators."""
    seed: int = SEED
    """Of the cohort and of all that is random."""
    conformance: bool = False
    """Instead: every role x geometry x law x policy, judged by numbers of its own."""

    def study(self, console: Console) -> Findings:
        """Do it."""
        if self.conformance:
            told = conform(self.sweeper(console))
            return Findings({"conformance": told}, lambda _: [], conformance_words(told))
        from palpate.studies.guidance_figures import draw

        rows = run(self.operators, self.seed, self.sweeper(console))
        told = summary(rows, self.seed)
        return Findings(told, lambda folder: draw(rows, told, folder, self.seed), tables(told))


def conform(sweep: Sweeper = sweep) -> dict[str, Any]:
    """The conformance suite, role x geometry by role x geometry on every core, and how far the tool gets in."""
    grid = {"role": Axis(conformance.ROLES), "geometry": Axis(conformance.SPECIMENS)}
    rows = sweep(examined, grid, title="conformance").rows()
    by_name = {str(c): c for c in conformance.combinations()}
    failures = {by_name[name]: wrong for row in rows for name, wrong in json.loads(row["failures"]).items()}
    told = conformance.summary(failures, list(by_name.values()))
    hard, soft = conformance.entry.hard(), conformance.entry.soft()
    return told | {"hard_entry": hard, "soft_entry": soft, "entry_passed": conformance.entry.passed(hard, soft)}


def examined(point: Point, seed: int) -> dict[str, Any]:
    """All laws and policies of a role with a geometry; nothing in it is random."""
    mine = [c for c in conformance.combinations() if (c.role, c.geometry) == (point["role"], point["geometry"])]
    found = {str(c): conformance.examine(c) for c in mine}
    return {"examined": len(mine), "failures": json.dumps({name: wrong for name, wrong in found.items() if wrong})}


def conformance_words(told: dict[str, Any]) -> list[RenderableType]:
    """For people: what failed, by property; what has no meaning, and why; how far the tool got in."""
    kinds: dict[str, list[str]] = {}
    for failure in told["failures"]:
        for name, wrong in failure.items():
            if name != "combination":
                kinds.setdefault(name, []).append(f"{failure['combination']}: {wrong}")
    lines: list[RenderableType] = []
    for name, found in kinds.items():
        lines += [f"{name}: {len(found)} combinations", *(f"  {text}" for text in found[:3])]
    lines += [f"not judged: {name}" for name in told["unjudged"]]
    lines += [f"refused, as it has to be: {n} combinations, {why}" for why, n in told["reasons"].items()]
    worst = max(told["hard_entry"], key=lambda row: row["entry_mm"])
    lines.append(f"hard: at most {worst['entry_mm']:.3f} mm in ({worst['geometry']}), whatever the hand does")
    pressed = ", ".join(
        f"{e['force_N']:g} N {e['measured_mm']:.2f} mm (certified {e['certified_mm']:.2f})" for e in told["soft_entry"]
    )
    lines.append(f"soft: {pressed}")
    return [*lines, f"conformance: {told['passed']} of {told['combinations']} combinations passed"]


def run(operators: int = 200, seed: int = SEED, sweep: Sweeper = sweep) -> list[dict[str, Any]]:
    """A row per operator, task and condition."""
    if operators < 2:
        raise ValueError(f"operators must be 2 or more: a spread needs two. Got: {operators}")
    grid = {
        "operator": Axis(range(operators)),
        "task": Axis(TASKS),
        "condition": Axis(CONDITIONS),
        "cohort": Axis([seed]),
    }
    return sweep(measure, grid, seed, labels=MEASURES).rows()


def measure(point: Point, seed: int) -> dict[str, float]:
    """One trial of the sweep."""
    trial = attempt(point["operator"], point["task"], point["condition"], seed, point["cohort"])
    return judged(_task(point["task"]), trial)


def attempt(operator: int, task: str, condition: str, seed: int, cohort_seed: int = SEED) -> Trial:
    """One operator does one task under one condition."""
    person, c, t = cohort(operator + 1, cohort_seed)[operator], CONDITIONS[condition], _task(task)
    rig = _rig(task, c.guidance)
    o = rig.options(seed)
    o.hand, o.tremor = person.hand.options(), person.tremor
    arms = rig.arms
    rest = _core.HandPath([0.0], t.start[None])
    sim = _core.Simulation(o, arms.leader, arms.leader, arms.follower, rig.snapshot, rest)
    sim.set_fixtures(rig.fixtures)
    controls = sim.controls
    controls.stiffness_scale = controls.damping_scale = float(c.forces)
    sim.controls = controls
    return perform(sim, Operator(person, c.senses, seed), t.errand, arms.X_WL, SCALE, MOST)


@lru_cache
def _task(name: str) -> Task:
    return TASKS[name]()


@lru_cache
def _rig(name: str, guidance: str) -> Rig:
    task = _task(name)
    data = task.scene()
    if guidance:
        data["guidance"] = task.guidance(DISPLACED if guidance == "wrong" else np.zeros(3))
    rig = build(Scene.model_validate(data))
    if task.surface is None:
        return rig
    material = _core.Material(K=np.full(3, task.errand.stiffness), B=np.ones(3))
    return replace(rig, snapshot=_core.Snapshot([_core.Object(name, task.surface(), np.eye(4), material)]))


def judged(task: Task, trial: Trial) -> dict[str, float]:
    """The measures of a trial, from the true positions."""
    deep = task.outside(trial.p_WT)
    inside = False
    entries = 0
    for d in deep:
        entries += d > 0.0 and not inside
        inside = d > 0.0 or (inside and d > -STEADY)
    return {
        "path_error_mm": 1e3 * float(np.sqrt(np.mean(task.off(trial.p_WT) ** 2))),
        "time_s": float(trial.t[-1]),
        "mean_force_N": float(trial.F_T.mean()),
        "peak_force_N": float(trial.F_T.max()),
        "entries": float(entries),
        "deepest_mm": 1e3 * float(max(deep.max(), 0.0)),
        "hand_peak_force_N": float(trial.F_hand.max()),
        "done": float(trial.done),
    }


def summary(rows: list[dict[str, Any]], seed: int) -> dict[str, Any]:
    """As in docs/json.md."""
    rng = np.random.default_rng(seed)
    means, effects = [], []
    for task in TASKS:
        none = _columns(rows, task, "none")
        draws = rng.integers(len(none["time_s"]), size=(BOOTSTRAPS, len(none["time_s"])))
        for condition in CONDITIONS:
            mine = _columns(rows, task, condition)
            mean = {key: float(mine[key].mean()) for key in (*MEASURES, "deepest_mm", "hand_peak_force_N")}
            unfinished = int(np.sum(mine["done"] == 0.0))
            means.append({"task": task, "condition": condition, **mean, "unfinished": unfinished})
            if condition != "none":
                effects += [_effect(task, condition, key, none[key], mine[key], draws) for key in MEASURES]
    control = [_against(rows, task, rng) for task in TASKS]
    return {
        "simulated": True,
        "operators": len(none["time_s"]),
        "rows": means,
        "effects": effects,
        "control": control,
        "control_works": all(one["than_right_low_mm"] > 0.0 for one in control),
    }


def _columns(rows: list[dict[str, Any]], task: str, condition: str) -> dict[str, Array]:
    mine = sorted((r for r in rows if r["task"] == task and r["condition"] == condition), key=lambda r: r["operator"])
    return {key: np.array([row[key] for row in mine]) for key in mine[0] if key not in ("task", "condition")}


def hedges_g(a: Array, b: Array) -> Array:
    """Standardised difference of means b - a over the pooled spread, corrected for few; along the last axis."""
    n = a.shape[-1] + b.shape[-1]
    spread = np.sqrt(0.5 * (a.var(axis=-1, ddof=1) + b.var(axis=-1, ddof=1)))
    difference = b.mean(axis=-1) - a.mean(axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        g = np.where(spread > 0.0, difference / spread, 0.0)
    return np.asarray((1.0 - 3.0 / (4.0 * n - 9.0)) * g)


def _effect(task: str, condition: str, key: str, none: Array, mine: Array, draws: NDArray[np.int64]) -> dict[str, Any]:
    g = hedges_g(none[draws], mine[draws])
    before, after = none[draws].mean(axis=1), mine[draws].mean(axis=1)
    some = before > 0.0
    change = after[some] / before[some] - 1.0
    known = none.mean() > 0.0
    low, high = np.percentile(change, [2.5, 97.5]) if known and some.any() else (np.nan, np.nan)
    expected = EXPECTED.get((condition, key))
    return {
        "task": task,
        "condition": condition,
        "measure": key,
        "change": float(mine.mean() / none.mean() - 1.0) if known else None,
        "change_low": float(low) if known else None,
        "change_high": float(high) if known else None,
        "hedges_g": float(hedges_g(none, mine)),
        "hedges_g_low": float(np.percentile(g, 2.5)),
        "hedges_g_high": float(np.percentile(g, 97.5)),
        "expected_change": list(expected[0]) if expected and expected[0] else None,
        "expected_hedges_g": -expected[1] if expected else None,
    }


def _against(rows: list[dict[str, Any]], task: str, rng: np.random.Generator) -> dict[str, Any]:
    """How much more path error wrong guidance makes than the same guidance in its place, and than none [mm]."""
    wrong = _columns(rows, task, "control_wrong")["path_error_mm"]
    draws = rng.integers(len(wrong), size=(BOOTSTRAPS, len(wrong)))
    told: dict[str, Any] = {"task": task}
    for name, condition in (("right", "haptics+guidance"), ("none", "none")):
        more = wrong - _columns(rows, task, condition)["path_error_mm"]
        low, high = np.percentile(more[draws].mean(axis=1), [2.5, 97.5])
        told |= {f"than_{name}_mm": float(more.mean())}
        told |= {f"than_{name}_low_mm": float(low), f"than_{name}_high_mm": float(high)}
    return told


def tables(told: dict[str, Any]) -> list[RenderableType]:
    """For people."""
    title = f"means of {told['operators']} simulated operators"
    means = Table(box=None, pad_edge=False, title=title, title_justify="left")
    for column in ("task", "condition", "path error", "time", "mean force", "peak force", "entries"):
        means.add_column(column, justify="left" if column in ("task", "condition") else "right")
    for row in told["rows"]:
        first = row["condition"] == "none"
        means.add_row(
            row["task"] if first else "", row["condition"], f"{row['path_error_mm']:.2f} mm", f"{row['time_s']:.1f} s",
            f"{row['mean_force_N']:.2f} N", f"{row['peak_force_N']:.2f} N", f"{row['entries']:.2f}",
        )  # fmt: skip
    return [means, _expectations(told), *_verdicts(told)]


def _expectations(told: dict[str, Any]) -> Table:
    out = Table(box=None, pad_edge=False, title="against none, beside the literature", title_justify="left")
    for column in ("task", "condition", "measure", "ours", "literature", "Hedges' g ours", "people"):
        out.add_column(column, justify="left" if column in ("task", "condition", "measure") else "right")
    for e in told["effects"]:
        if e["expected_hedges_g"] is None or e["change"] is None:
            continue
        c = [round(100 * e[k]) for k in ("change", "change_low", "change_high")]
        range_ = e["expected_change"]
        lit = f"{100 * range_[0]:.0f} .. {100 * range_[1]:.0f} %" if range_ else ""
        g = f"{e['hedges_g']:.2f} ({e['hedges_g_low']:.2f} .. {e['hedges_g_high']:.2f})"
        out.add_row(e["task"], e["condition"], e["measure"].rsplit("_", 1)[0].replace("_", " "),
                    f"{c[0]:+d} % ({c[1]:+d} .. {c[2]:+d})", lit, g, f"{e['expected_hedges_g']:.2f}")  # fmt: skip
    return out


def _verdicts(told: dict[str, Any]) -> list[str]:
    graded = [e for e in told["effects"] if e["expected_change"] and e["change"] is not None]
    inside = [e for e in graded if e["expected_change"][0] <= e["change"] <= e["expected_change"][1]]
    beyond = [e for e in graded if e["change"] < e["expected_change"][0]]
    control = ", ".join(
        f"{one['task']} {one['than_right_mm']:+.2f} ({one['than_none_mm']:+.2f})" for one in told["control"]
    )
    worse = "worse in every task" if told["control_works"] else "NOT worse in every task"
    return [
        f"{len(inside)} of {len(graded)} effects lie where the literature has them, {len(beyond)} are larger",
        f"control, guidance 5 mm beside the truth: path error [mm] against right guidance (none): {control}: {worse}",
        SOURCE,
        "simulated operators: models, not people (palpate/operators); simulated arms",
    ]
