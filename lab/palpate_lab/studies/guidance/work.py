"""The work of ``palpate study guidance``."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

import numpy as np

from palpate import _core
from palpate.base.arrays.peaks import sustained
from palpate.base.sweep import Axis, Label, sweep
from palpate.base.sweep.grid import Point
from palpate.base.sweep.work import seed_of
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate.simulators.operators import Operator, Senses, perform, person
from palpate.simulators.operators.trial import Trial
from palpate_lab.studies._command import Sweeper
from palpate_lab.studies.guidance.result import Trials
from palpate_lab.studies.guidance.tasks import OFFSET_AXIS, SCALE, TASKS, Task

SEED = 7
MOST = 15.0
"""Largest duration of a trial [s]."""
FEW = 50
"""Number of operators, the first of the cohort, for the sweep over the registration error."""
STEADY = 0.05e-3
"""Distance outside the forbidden region at which the region counts as left [m]."""


@dataclass(frozen=True)
class Condition:
    """Assistance that the console provides."""

    words: str
    senses: Senses
    forces: bool = False
    """True if contact forces are rendered."""
    guidance: Literal["", "soft", "hard"] = ""
    offset_mm: float = 0.0
    """Registration error: displacement of the guidance, with a sign that alternates over the operators [mm]."""
    haste: bool = True
    """Operators press harder without force feedback (assumed trait `TRAITS["haste"]`); False for the ablation."""


@dataclass(frozen=True)
class Assumed:
    """Assumptions of the simulation that the ablations vary; the defaults are those of the study."""

    yields: float = 1.0
    """Share of the operators' trait `yields` [-]."""
    care: float = 1.0
    """Share by which operators slow down for an error that they see [-]."""
    stiffness: float | None = None
    """Stiffness of the soft fixtures [N/m]; None: that of the task."""


STUDY = Assumed()


def _misplaced(error: float) -> Condition:
    return Condition(f"contact and guidance felt, {error:g} mm off", Senses("felt"), True, "soft", error)


CONDITIONS: dict[str, Condition] = {
    "none": Condition("the picture alone", Senses()),
    "visual": Condition("path drawn, force as a bar", Senses("shown", drawn=True)),
    "haptics": Condition("contact felt", Senses("felt"), forces=True),
    "guidance": Condition("guidance felt, contact not", Senses(), guidance="soft"),
    "haptics+guidance": Condition("contact and guidance felt", Senses("felt"), True, "soft"),
    "haptics+hard": Condition("contact felt, guidance hard", Senses("felt"), True, "hard"),
    "control_wrong": _misplaced(5.0),
}
REGISTRATION: dict[str, Condition] = {f"registration_{e:g}mm": _misplaced(e) for e in (1.0, 2.0, 3.0)}
"""Conditions with registration errors between `haptics+guidance` and `control_wrong`."""
ABLATION: dict[str, Condition] = {"none_no_haste": Condition("the picture alone", Senses(), haste=False)}
ALL = CONDITIONS | REGISTRATION | ABLATION
CUED: dict[str, Condition] = {"visual+haptics": Condition("path drawn, contact felt", Senses("felt", drawn=True), True)}
"""Condition of cues.py in addition to `visual` and `haptics`; a force bar adds nothing to a felt force."""

MEASURES = {
    "path_error_mm": Label("mm", "rms distance from the path"),
    "time_s": Label("s", "duration until the end of the path"),
    "mean_force_N": Label("N", "mean force of the tool on the touched object"),
    "peak_force_N": Label("N", "peak force of the tool on the touched object"),
    "entries": Label("", "number of entries of the tool into the forbidden region"),
}


def run(operators: int = 200, seed: int = SEED, sweep: Sweeper = sweep) -> Trials:
    """One row per operator, task and condition."""
    if operators < 2:
        raise ValueError(f"operators must be 2 or more: a spread needs two. Got: {operators}")
    grid = {
        "operator": Axis(range(operators)),
        "task": Axis(TASKS),
        "condition": Axis(ALL),
        "cohort": Axis([seed]),
    }
    return sweep(measure, grid, seed, labels=MEASURES, where=_included).rows()


def trial_seed(operator: int, task: str, condition: str, seed: int = SEED) -> int:
    """Seed of one trial of `run`, equal to the sweep's seed of this point."""
    tasks, conditions = list(TASKS), list(ALL)
    return seed_of(seed, (operator * len(tasks) + tasks.index(task)) * len(conditions) + conditions.index(condition))


def _included(point: Point) -> bool:
    """Registration errors only for the first operators; the ablation of haste only for tasks with pressing."""
    if point["condition"] in ABLATION:
        return task_of(point["task"]).errand.press > 0.0
    return point["condition"] not in REGISTRATION or point["operator"] < FEW


def measure(point: Point, seed: int) -> dict[str, float]:
    """Run one trial of the sweep and return its measures."""
    trial = attempt(point["operator"], point["task"], point["condition"], seed, point["cohort"])
    return judged(task_of(point["task"]), trial)


def attempt(
    operator: int, task: str, condition: str, seed: int, cohort_seed: int = SEED, assumed: Assumed = STUDY
) -> Trial:
    """Simulate one operator in one task under one condition."""
    who, c, t = person(operator, cohort_seed), (ALL | CUED)[condition], task_of(task)
    if not c.haste:
        who = replace(who, haste=1.0)
    who = replace(who, yields=assumed.yields * who.yields, care=assumed.care)
    rig = _rig(task, c.guidance, c.offset_mm if operator % 2 == 0 else -c.offset_mm, assumed.stiffness)
    o = rig.options(seed)
    o.hand, o.tremor = who.hand.options(), who.tremor
    arms = rig.arms
    rest = _core.HandPath([0.0], t.start[None])
    sim = _core.Simulation(o, arms.leader, arms.leader, arms.follower, rig.snapshot, rest)
    sim.set_fixtures(rig.fixtures)
    controls = sim.controls
    controls.stiffness_scale = controls.damping_scale = float(c.forces)
    sim.controls = controls
    return perform(sim, Operator(who, c.senses, seed), t.errand, arms.X_WL, SCALE, MOST)


@lru_cache
def task_of(name: str) -> Task:
    """The task with this name."""
    return TASKS[name]()


@lru_cache(maxsize=64)
def _rig(name: str, guidance: str, offset_mm: float, stiffness: float | None = None) -> Rig:
    task = task_of(name)
    data = task.scene()
    if guidance:
        data["guidance"] = task.guidance(1e-3 * offset_mm * OFFSET_AXIS, guidance == "hard")
        for fixture in data["guidance"] if stiffness else ():
            fixture["law"] = fixture["law"] | {"stiffness": stiffness}
    rig = build(Scene.model_validate(data))
    if task.surface is None:
        return rig
    material = _core.Material(K=np.full(3, task.errand.stiffness), B=np.ones(3))
    return replace(rig, snapshot=_core.Snapshot([_core.Object(name, task.surface(), np.eye(4), material)]))


def judged(task: Task, trial: Trial) -> dict[str, float]:
    """The measures of a trial, computed from the true positions."""
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
        "peak_50ms_N": sustained(trial.F_T, float(np.median(np.diff(trial.t)))),
        "done": float(trial.done),
    }
