"""Scores of the field: peg transfer of the FLS, and simulators that compare with experts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from statistics import mean, stdev

FLS_TIME = 300.0
"""Time from which that of a peg transfer is subtracted [s]."""


def fls_peg_transfer(time_s: float, dropped: int, objects: int = 6) -> float:
    """Score of a peg transfer: 300 - time - penalty, the penalty being the percentage of objects dropped out of view.

    Args:
        time_s: duration [s].
        dropped: objects that were dropped out of view.
        objects: objects of the task.

    Raises:
        ValueError: more objects were dropped than there are, or there are none.
    """
    if objects < 1 or not 0 <= dropped <= objects:
        raise ValueError(f"{dropped} of {objects} objects cannot have been dropped")
    return max(0.0, FLS_TIME - time_s - 100.0 * dropped / objects)


def benchmark(experts: Sequence[Mapping[str, float]]) -> dict[str, tuple[float, float]]:
    """Mean and standard deviation of each measure over trials of experts, for `simulator_score`.

    Args:
        experts: measures of at least two trials, e.g. of `summary`; what is NaN in one of them is left out.

    Raises:
        ValueError: fewer than two trials.
    """
    if len(experts) < 2:
        raise ValueError(f"{len(experts)} trials of experts: a spread needs two")
    values = {name: [one.get(name, float("nan")) for one in experts] for name in experts[0]}
    return {name: (mean(some), stdev(some)) for name, some in values.items() if all(map(isfinite, some))}


def simulator_score(found: Mapping[str, float], experts: Mapping[str, tuple[float, float]]) -> dict[str, bool]:
    """Whether each measure is within the benchmark of experts: at most their mean and one standard deviation.

    Args:
        found: measures of which less is better, e.g. of `summary`.
        experts: mean and standard deviation of experts, for some of these measures.

    Raises:
        KeyError: a measure of the experts was not found.
    """
    return {name: found[name] <= mean + deviation for name, (mean, deviation) in experts.items()}
