"""What an experiment has found so far: the values of `palpate experiment --json`, and the table for the report."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from palpate.experiment.analysis import Effect, Power, effects, power
from palpate.experiment.study import Study
from palpate.experiment.table import Row, answers, preferences, trials


@dataclass(frozen=True)
class Found:
    """The state and the results of an experiment."""

    study: Study
    rows: list[Row]
    asked: list[Row]
    effects: list[Effect]
    answered: list[Effect]
    """The conditions compared by the answers."""
    preferred: dict[str, int]
    power: list[Power] = field(default_factory=list)

    @property
    def state(self) -> list[dict[str, Any]]:
        """By participant: trials planned, ended, attempts aborted and lost."""
        return [
            {
                "participant": who,
                "planned": len(self.study.plan[who]),
                "ended": len(done.ended),
                "aborted": len(done.aborted),
                "lost": done.lost,
            }
            for who in self.study.people
            for done in [self.study.progress(who)]
        ]

    def json(self) -> dict[str, Any]:
        """The contract of docs/json/experiment.md; what is not defined is null."""
        wins = [row["success"] for row in self.rows]
        return {
            "simulated": self.study.simulated,
            "title": self.study.experiment.title,
            "folder": str(self.study.folder),
            "conditions": list(self.study.experiment.conditions),
            "tasks": list(self.study.experiment.tasks),
            "participants": self.state,
            "trials": len(self.rows),
            "success": float(np.mean(wins)) if wins else None,
            "effects": [_plain(asdict(one)) for one in self.effects],
            "answers": [_plain(asdict(one)) for one in self.answered],
            "preference": self.preferred,
            "power": [asdict(one) for one in self.power],
        }


def found_in(study: Study, with_power: bool = False) -> Found:
    """Analyse what an experiment has so far.

    Raises:
        MissingExtraError: statsmodels is not installed.
    """
    experiment, rows, asked = study.experiment, trials(study), answers(study)
    names = tuple(experiment.conditions)
    scales = [name for name in (asked[0] if asked else {}) if name not in ("participant", "condition")]
    if "tlx" in scales:
        scales = [name for name in scales if not name.startswith("tlx_")]
    compared = [{**row, "task": ""} for row in asked]
    return Found(
        study, rows, asked, effects(rows, experiment.measures, names) if rows else [],
        effects(compared, scales, names) if asked else [], preferences(study),
        power(rows, experiment.measures[0], names, experiment.seed) if with_power else [],
    )  # fmt: skip


def _plain(values: dict[str, Any]) -> dict[str, Any]:
    return {k: None if isinstance(v, float) and not np.isfinite(v) else v for k, v in values.items()}
