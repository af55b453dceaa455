"""The work of ``palpate study drift``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import cast

import numpy as np

from palpate.arm.identify.fit_gravity import fit_poses
from palpate.arm.identify.gravity import named_arm
from palpate.base.errors import RecordingError
from palpate.base.sweep import Axis, sweep
from palpate.base.sweep.grid import Point
from palpate_lab import places
from palpate_lab.studies._command import Sweeper
from palpate_lab.studies.drift.plant import PLANTS, TIME, Plant, make_plants, release, sampled, unseen_poses
from palpate_lab.studies.drift.result import Described, Drift, Made, Released, Row, StudyResult

FORMS = ("paper", "gravity+springs", "dvrk", "potential")
PUBLISHED = {"paper": (96.0, 60.0, 254.0), "dvrk": (5.8, 2.1, 22.0)}  # mean, median, p95 on a real arm [mm]
RELEASES, TRAINED = 400, 160  # numbers of poses
STAYS = 0.1  # largest drift that counts as no motion [mm]

_REAL = ("MTML_34863", "MTMR_31519", "MTMR_28247")
_FILES = ("random_N160", "random_N400", "uniform_pos", "uniform_neg")


@dataclass(frozen=True)
class Recorded:
    """An arm and the recordings from which its plants are identified."""

    name: str
    arm: str  # mtml or mtmr
    files: tuple[Path, ...]


def real_arms(side: str | None = None) -> list[Recorded]:
    """The three arms with public recordings, or those of one side.

    Raises:
        RecordingError: the recordings are missing; the error names the searched folder.
    """
    folder = places.data() / "mtm_static"
    arms = [
        Recorded(name, name[:4].lower(), tuple(folder / f"{name}__{part}.csv" for part in _FILES)) for name in _REAL
    ]
    arms = [arm for arm in arms if side in (None, arm.arm)]
    if not all(file.is_file() for arm in arms for file in arm.files):
        mend = "name static recordings of your arm, or set PALPATE_DATA"
        raise RecordingError("the recordings for the plants are missing", where=str(folder), mend=mend)
    return arms


def run(arms: Sequence[Recorded], releases: int = RELEASES, sweep: Sweeper = sweep) -> StudyResult:
    """All forms on the same plants with the same samples and releases; the keys are those of docs/json.md."""
    grid = {"arm": Axis(arm.name for arm in arms), "plant": Axis(PLANTS), "model": Axis(FORMS)}
    rows = sweep(partial(_released, tuple(arms), releases), grid).rows()
    made = {(row["arm"], row["plant"]): row.pop("made") for row in rows}
    return {
        "simulated": True,
        "releases": releases,
        "trained_on": TRAINED,
        "released_s": TIME,
        "published_mm": PUBLISHED,
        "arms": [_description(arm, {name: made[arm.name, name] for name in PLANTS}) for arm in arms],
        "rows": cast(list[Row], rows),
    }


def _released(arms: tuple[Recorded, ...], releases: int, point: Point, seed: int) -> Released:
    """One form on one plant. Samples and releases have fixed seeds, so they are the same for every form."""
    (arm,) = (arm for arm in arms if arm.name == point["arm"])
    plant = _plants(arm)[point["plant"]]
    made: Made = {
        "friction_Nm": plant.coulomb[:6].tolist(),
        "noise_Nm": plant.noise[:6].tolist(),
        "beyond_form_Nm": plant.beyond[:6].tolist(),
    }
    return {"made": made, **_drift(point["model"], plant, releases)}


@lru_cache(1)
def _plants(arm: Recorded) -> dict[str, Plant]:
    return make_plants(arm.files, arm.arm)


def _description(arm: Recorded, made: dict[str, Made]) -> Described:
    return {
        "arm": arm.name,
        "recordings": [file.name for file in arm.files],
        "friction_Nm": made[PLANTS[0]]["friction_Nm"],
        "noise_Nm": {name: plant["noise_Nm"] for name, plant in made.items()},
        "beyond_form_Nm": {name: plant["beyond_form_Nm"] for name, plant in made.items()},
    }


def _drift(form: str, plant: Plant, releases: int) -> Drift:
    controller = named_arm("mtml" if plant.arm.name == "mtm_left" else "mtmr")
    poses = sampled(plant, TRAINED, seed=1, both_ways=form == "dvrk")
    model = fit_poses(poses, controller, form, plant.measured).model
    model.apply(controller)
    starts = unseen_poses(plant, releases, seed=2)
    error = model.holding(starts, controller) - np.array([plant.arm.holding(q) for q in starts])
    drift = 1e3 * np.array([release(plant, controller, q) for q in starts])
    return {
        "mean_mm": float(drift.mean()),
        "median_mm": float(np.median(drift)),
        "p95_mm": float(np.percentile(drift, 95)),
        "stays": float((drift < STAYS).mean()),
        "torque_error_Nm": np.sqrt((error**2).mean(axis=0))[:6].tolist(),
        "beyond_friction": (np.abs(error) > plant.coulomb).mean(axis=0)[:6].tolist(),
        "drift_mm": np.round(np.sort(drift), 4).tolist(),
    }
