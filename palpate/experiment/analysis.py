"""Comparison of the conditions: a mixed model, effect sizes with intervals, and one correction for all tests.

The model has condition and task as fixed effects and the participant as a random one (statsmodels' MixedLM, REML). Its
values are those of a participant in a condition, the mean over repetitions and tasks without the tasks' own effects: a
participant is one unit, however many tasks there were, since effects differ between people. Its t values have as many
degrees of freedom as the analysis of variance with repeated measures has; normal ones find too much with few people.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.base.arrays.intervals import LEAST, holm, interval, paired, proportion
from palpate.base.errors import MissingExtraError
from palpate.experiment.table import Row

StringArray = NDArray[np.str_]
PEOPLE = (6, 8, 10, 12, 16, 20, 24, 32)
"""Numbers of participants for which the power is computed."""
DRAWS = 400
"""Experiments that are drawn for each of them."""
ALPHA = 0.05
_NO_SPREAD = 1e-20  # residual variance over that of the values which is rounding [-]


@dataclass(frozen=True)
class Effect:
    """A condition against the reference in one measure."""

    measure: str
    condition: str
    reference: str
    participants: int
    mean: float
    """Mean of the condition over participants, in the unit of the measure."""
    difference: float
    """Mean difference from the reference; `low` and `high`: its 95 % interval."""
    low: float
    high: float
    dz: float
    """Difference over its standard deviation between participants; with its 95 % interval."""
    dz_low: float
    dz_high: float
    model: float
    """Difference by the mixed model."""
    p: float
    """By the mixed model."""
    p_holm: float
    """Corrected for all tests of the experiment (Holm)."""


def effects(rows: Sequence[Row], measures: Sequence[str], conditions: Sequence[str]) -> list[Effect]:
    """Every condition but the first against the first, in every measure.

    Raises:
        MissingExtraError: statsmodels is not installed.
    """
    found = []
    for measure in measures:
        model = mixed(rows, measure, conditions)
        found += [_effect(rows, measure, condition, conditions, model) for condition in conditions[1:]]
    corrected = holm(np.array([one.p for one in found]))
    return [Effect(**{**vars(one), "p_holm": float(p)}) for one, p in zip(found, corrected, strict=True)]


def means(rows: Sequence[Row], measure: str, conditions: Sequence[str]) -> tuple[list[str], Array]:
    """Means (participants, conditions) of a measure over tasks and repetitions; NaN without a value."""
    people = list(dict.fromkeys(row["participant"] for row in rows))
    values: dict[tuple[str, str], list[float]] = {}
    for row in _cells(rows, measure):
        values.setdefault((row["participant"], row["condition"]), []).append(row["value"])
    table = [[float(np.mean(values.get((who, c), [np.nan]))) for c in conditions] for who in people]
    return people, np.array(table).reshape(len(people), len(conditions))


def _effect(
    rows: Sequence[Row], measure: str, condition: str, conditions: Sequence[str], model: dict[str, tuple[float, float]]
) -> Effect:
    _, table = means(rows, measure, conditions)
    pair = table[:, [0, list(conditions).index(condition)]]
    pair = pair[np.isfinite(pair).all(axis=1)]
    change = pair[:, 1] - pair[:, 0]
    low, high = map(float, interval(np.mean, change) if len(change) else (np.nan, np.nan))
    dz = _dz(change)
    dz_low, dz_high = interval(_dz, change) if np.isfinite(dz) else (np.nan, np.nan)
    slope, p = model.get(condition, (np.nan, np.nan))
    return Effect(
        measure, condition, conditions[0], len(change), float(pair[:, 1].mean()) if len(pair) else np.nan,
        float(change.mean()) if len(change) else np.nan, low, high, dz, dz_low, dz_high, slope, p, np.nan,
    )  # fmt: skip


def _dz(change: Array) -> float:
    if len(change) < 2:
        return float("nan")
    deviation = float(change.std(ddof=1))
    return float(change.mean()) / deviation if deviation > 0.0 else float("nan")


def require_model() -> None:
    """Refuse to begin trials whose analysis needs the mixed model, if it is missing.

    Raises:
        MissingExtraError: statsmodels is not installed.
    """
    from importlib.util import find_spec

    if find_spec("statsmodels") is None:
        raise MissingExtraError("the mixed model", "experiment")


def mixed(rows: Sequence[Row], measure: str, conditions: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Difference from the first condition and its probability without an effect, by condition.

    It is empty below `LEAST` participants, and where the design or the values do not define it.

    Raises:
        MissingExtraError: statsmodels is not installed.
    """
    require_model()
    from scipy.special import stdtr
    from statsmodels.regression.mixed_linear_model import MixedLM

    cells = _cells(rows, measure)
    present = [c for c in conditions if any(row["condition"] == c for row in cells)]
    if len(present) < 2 or present[0] != conditions[0]:
        return {}
    who, met, y = _by_participant(cells, present)
    people, freedom = len(set(who)), len(y) - len(set(who)) - (len(present) - 1)
    if people < LEAST or freedom < 1 or np.ptp(y) == 0.0:
        return {}
    columns = [np.ones(len(y))] + [(met == c).astype(float) for c in present[1:]]
    scale = float(y.std())  # the optimiser expects values of about one
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a variance of zero between participants is a result, not a fault
        try:
            fit = MixedLM(y / scale, np.column_stack(columns), groups=who).fit(reml=True)
        except np.linalg.LinAlgError:
            return {}
        if fit.scale < _NO_SPREAD:
            return {}
        slopes, deviations = fit.fe_params, fit.bse_fe
    found = {}
    for k, condition in enumerate(present[1:], 1):
        slope, deviation = float(slopes[k]), float(deviations[k])
        p = 2.0 * float(stdtr(freedom, -abs(slope) / deviation)) if deviation > 0.0 else float("nan")
        found[condition] = (scale * slope, p)
    return found


def _by_participant(cells: Sequence[Row], present: Sequence[str]) -> tuple[StringArray, StringArray, Array]:
    """Participant, condition and value (n,): means over the tasks, less the tasks' own effects.

    Empty if the conditions were met in different tasks, so that their effects are one.
    """
    keys = {key: np.array([row[key] for row in cells]) for key in ("participant", "condition", "task")}
    y = np.array([row["value"] for row in cells])
    people, tasks = (
        np.column_stack([keys[key] == one for one in dict.fromkeys(keys[key])]).astype(np.float64)
        for key in ("participant", "task")
    )
    tried = np.column_stack([keys["condition"] == c for c in present[1:]]).astype(np.float64)
    rest, A = np.hstack([people, tasks]), np.hstack([people, tasks, tried])
    if np.linalg.matrix_rank(A) < np.linalg.matrix_rank(rest) + tried.shape[1]:
        return keys["participant"][:0], keys["condition"][:0], y[:0]
    y = y - tasks @ np.linalg.lstsq(A, y, rcond=None)[0][people.shape[1] : rest.shape[1]]
    found: dict[tuple[str, str], list[float]] = {}
    for who, condition, value in zip(keys["participant"], keys["condition"], y, strict=True):
        found.setdefault((str(who), str(condition)), []).append(float(value))
    names, conditions = (np.array(one) for one in zip(*found, strict=True))
    return names, conditions, np.array([np.mean(values) for values in found.values()])


def _cells(rows: Sequence[Row], measure: str) -> list[Row]:
    """Mean over the repetitions of each participant, task and condition that has a value."""
    found: dict[tuple[str, str, str], list[float]] = {}
    for row in rows:
        if row.get(measure) is not None and np.isfinite(row[measure]):
            found.setdefault((row["participant"], row["task"], row["condition"]), []).append(float(row[measure]))
    return [
        {"participant": who, "task": task, "condition": condition, "value": float(np.mean(values))}
        for (who, task, condition), values in found.items()
    ]


@dataclass(frozen=True)
class Power:
    """Share of drawn experiments that find a condition different from the reference, for a number of people."""

    participants: int
    condition: str
    power: float
    low: float
    """95 % interval of the share, by the number of draws."""
    high: float


def power(rows: Sequence[Row], measure: str, conditions: Sequence[str], seed: int = 0) -> list[Power]:
    """Power of the primary measure: experiments are drawn from the participants in `rows` with replacement.

    Each drawn experiment tests the paired differences of the participants' means (Student), corrected by Holm.
    """
    _, table = means(rows, measure, conditions)
    table = table[np.isfinite(table).all(axis=1)]
    if len(table) < 2:
        return []
    rng = np.random.default_rng([seed, 3])
    found = []
    for n in PEOPLE:
        drawn = [table[rng.integers(len(table), size=n)] for _ in range(DRAWS)]
        p = np.array([holm(np.array([paired(one[:, 0], one[:, k]) for k in range(1, one.shape[1])])) for one in drawn])
        for k, condition in enumerate(conditions[1:]):
            share = float((p[:, k] < ALPHA).mean())
            found.append(Power(n, condition, share, *proportion(share, DRAWS)))
    return found
