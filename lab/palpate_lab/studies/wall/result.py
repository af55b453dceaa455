"""Result of ``palpate study wall``. The keys are the documented contract of ``--json`` (docs/json.md)."""

from __future__ import annotations

from typing import NotRequired, TypedDict

from palpate_lab.studies.wall.bench import Outcome, Trace

Traces = dict[float, tuple[Trace, Trace]]
"""Runs of the fitted hand by K_d, without and with passivity."""


class Person(TypedDict):
    """Result of one hand on one wall; NaN where a value is undefined."""

    kd: float
    person: int
    overshoot_percent: float
    rigidity_N_per_m: float
    settling_s: float
    limit_cycle: float
    rebound: float
    energy_J: float


class Hands(TypedDict):
    """Quantiles (5, 50 and 95 %) over all hands on one wall."""

    kd: NotRequired[float]
    people: int
    overshoot_percent: list[float]
    settling_s: list[float] | None
    rigidity_N_per_m: list[float] | None
    rebound: list[float]
    limit_cycle_share: float
    not_at_rest: int


class Printed(TypedDict):
    """A row of the paper's Table 1."""

    response_s: float
    offshoot_percent: float
    steady_state_cm: float


class Row(Outcome):
    """A simulated row of Table 1."""

    rate_Hz: NotRequired[float]
    kp: float
    kd: float
    published: Printed
    hands: NotRequired[Hands]


class Changed(TypedDict):
    """The rows with one value of the fit changed by a factor."""

    name: str
    factor: float
    overshoot_percent: list[float]
    limit_cycle: list[bool]


class StudyResult(TypedDict):
    """Result of the whole study."""

    simulated: bool
    leader: str
    rate_Hz: float
    hand: dict[str, float]
    rows: list[Row]
    passive_rows: list[Row]
    other_rates: list[Row]
    sensitivity: list[Changed]
    curve: list[Hands]
    fit: NotRequired[dict[str, float | list[float]]]
