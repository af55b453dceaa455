"""The work of ``palpate study planning``: how far simulated operators enter the margin on the routes of plans."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from palpate import _core, _guidance
from palpate.base.arrays import Array
from palpate.base.arrays.intervals import chance, holm, interval
from palpate.planning.checker import Checker
from palpate.simulators.operators import Errand, Operator, Senses, perform, person
from palpate.simulators.operators.trial import Trial
from palpate_lab.studies.planning.routes import MARGIN, SCALE, STIFFNESSES, Route, routes

SEED = 7
MOST = 25.0
"""Largest duration of a trial [s]."""
Rows = list[dict[str, Any]]
_KEYS = ("route", "condition", "operator")
_EVERY = 5  # rows of a trial per examined position, which are then 20 ms apart


@dataclass(frozen=True)
class Condition:
    """Assistance by the plan. In all conditions contact forces are felt and the operator aims along the plan."""

    words: str
    drawn: bool = False
    fixtures: tuple[str, ...] = ()


CONDITIONS = {
    "none": Condition("no assistance"),
    "drawn": Condition("plan drawn in the picture", drawn=True),
    "tube": Condition("wall of the tube alone", fixtures=("plan-tube",)),
    "follow": Condition("led along the plan, in its tube", fixtures=("plan", "plan-tube")),
}


SWEEP = {"none": CONDITIONS["none"]} | {
    f"{k:g}": Condition(f"led by a spring of {k:g} N/m, in the tube", fixtures=(f"plan {k:g}", "plan-tube"))
    for k in STIFFNESSES
}
"""The conditions of the sweep over the stiffness of the spring."""
EVERY = CONDITIONS | SWEEP
"""All conditions by name."""


def run(
    number: int, operators: int, seed: int = SEED, on_progress: Callable[[str], None] = lambda _: None,
    conditions: Sequence[str] = tuple(CONDITIONS),
) -> Rows:  # fmt: skip
    """One row per route, condition and operator."""
    return measured(routes(number, seed), operators, seed, on_progress, conditions)


def measured(
    found: Sequence[Route], operators: int, seed: int = SEED, on_progress: Callable[[str], None] = lambda _: None,
    conditions: Sequence[str] = tuple(CONDITIONS),
) -> Rows:  # fmt: skip
    """One row per route, condition and operator, for given routes."""
    rows: Rows = []
    for i, route in enumerate(found):
        for name in conditions:
            for who in range(operators):
                measured = judged(route, attempt(route, who, name, seed + who))
                rows.append({"route": i, "condition": name, "operator": who, **measured})
        on_progress(
            f"route {i + 1} of {len(found)}: {1e3 * (route.plan.clearance_m or 0.0):.2f} mm at its nearest place"
        )
    return rows


def summary(rows: Rows) -> dict[str, Any]:
    """Means of every condition, and the reduction of the entry against no assistance, with its 95 % interval."""
    found: dict[str, Any] = {}
    names = list(dict.fromkeys(row["condition"] for row in rows))
    for name in names:
        own = [row for row in rows if row["condition"] == name]
        means = {key: float(np.mean([row[key] for row in own])) for key in own[0] if key not in _KEYS}
        found[name] = {"words": EVERY[name].words, "trials": len(own), **means}
    for name in names:
        found[name]["entry_reduction"], found[name]["entry_reduction_95"], found[name]["p"] = _reduction(rows, name)
    tried = [one for name, one in found.items() if name != "none"]
    for one, p in zip(tried, holm(np.array([one["p"] for one in tried])), strict=True):
        one["p_holm"] = float(p)
    return found


def _reduction(rows: Rows, name: str) -> tuple[float, list[float], float]:
    """1 - entry / entry without assistance [-], its interval, and its probability without an effect.

    Routes and operators are both drawn.
    """
    before, after = _by_route(rows, "none"), _by_route(rows, name)  # each (routes, operators)

    def reduction(before: Array, after: Array) -> float:
        return float(1.0 - after.sum() / before.sum()) if before.sum() > 0.0 else float("nan")

    bounds = interval(reduction, before, after, axes=(0, 1))
    return reduction(before, after), list(bounds), chance(reduction, before, after, axes=(0, 1))


def _by_route(rows: Rows, condition: str) -> Array:
    own = [row for row in rows if row["condition"] == condition]
    count = 1 + max(row["route"] for row in own)
    return np.array([row["entry_mm_s"] for row in own]).reshape(count, -1)


def attempt(route: Route, operator: int, condition: str, seed: int) -> Trial:
    """Simulate one operator on one route under one condition."""
    who, c, rig = person(operator, SEED), EVERY[condition], route.rig
    o = rig.options(seed)
    o.hand, o.tremor = who.hand.options(), who.tremor
    arms = rig.arms
    rest = _core.HandPath([0.0], route.path[:1])
    sim = _core.Simulation(o, arms.leader, arms.leader, arms.follower, rig.snapshot, rest)
    sim.set_fixtures(_guidance.Fixtures([route.fixtures[name] for name in c.fixtures], rig.context.tool))
    errand = Errand(route.path, np.full(len(route.path), 2.0 * MARGIN), 400.0)
    return perform(sim, Operator(who, Senses("felt", c.drawn), seed), errand, arms.X_WL, SCALE, MOST)


def judged(route: Route, trial: Trial) -> dict[str, float]:
    """The measures of a trial, from the measured joints and the distances of the whole instrument.

    `entry_mm_s` is the depth of the instrument in the margin, integrated over the time.
    """
    checker = Checker(route.problem.robot, route.problem.world)
    n, rows = route.problem.robot.arm.n, slice(None, None, _EVERY)
    entry = np.zeros(len(trial.t[rows]))
    for k, q in enumerate(trial.q[rows, :n]):
        near = checker.nearest(q, MARGIN)
        entry[k] = max(0.0, MARGIN - near[0].distance) if near else 0.0
    dt = float(np.median(np.diff(trial.t[rows])))
    away = np.array([np.linalg.norm(route.path - p, axis=1).min() for p in trial.p_WT[rows]])
    return {
        "entry_mm_s": 1e3 * dt * float(entry.sum()),
        "deepest_mm": 1e3 * float(entry.max()),
        "inside_s": dt * float((entry > 0.0).sum()),
        "touched": float(entry.max() > MARGIN),
        "time_s": float(trial.t[-1]),
        "path_error_mm": 1e3 * float(np.sqrt(np.mean(away**2))),
        "done": float(trial.done),
    }
