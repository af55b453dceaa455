"""Comparison of the conditions: a mixed model, effect sizes with intervals, and one correction for all tests.

A value is the mean over the repetitions of a participant in a task and condition. The model has condition and task as
fixed effects and the participant as a random one (statsmodels' MixedLM, REML). Its t values have as many degrees of
freedom as the analysis of variance with repeated measures has, since the normal ones are too small with few people.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.intervals import holm, interval, paired, proportion
from palpate.base.errors import MissingExtraError
from palpate.experiment.table import Row

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
    """Difference from the first condition and its probability without an effect, by condition; empty if not defined.

    Raises:
        MissingExtraError: statsmodels is not installed.
    """
    require_model()
    from scipy.special import stdtr
    from statsmodels.regression.mixed_linear_model import MixedLM

    cells = _cells(rows, measure)
    people = sorted({row["participant"] for row in cells})
    present = [c for c in conditions if any(row["condition"] == c for row in cells)]
    tasks = sorted({row["task"] for row in cells})
    y = np.array([row["value"] for row in cells])
    columns = (
        [np.ones(len(y))]
        + [_is(cells, "condition", c) for c in present[1:]]
        + [_is(cells, "task", task) for task in tasks[1:]]
    )
    freedom = len(y) - len(people) - (len(columns) - 1)
    if len(people) < 2 or len(present) < 2 or present[0] != conditions[0] or freedom < 1 or np.ptp(y) == 0.0:
        return {}
    scale = float(y.std())  # the optimiser expects values of about one
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a variance of zero between participants is a result, not a fault
        groups = [people.index(row["participant"]) for row in cells]
        try:
            fit = MixedLM(y / scale, np.column_stack(columns), groups=groups).fit(reml=True)
        except np.linalg.LinAlgError:  # e.g. each condition was met in another task
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


def _is(cells: Sequence[Row], key: str, value: str) -> Array:
    return np.array([float(row[key] == value) for row in cells])


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
