"""What ``palpate study guidance`` finds. The keys are the documented contract of ``--json`` (docs/json.md)."""

from __future__ import annotations

from typing import Any, Literal, TypedDict

Purpose = Literal["path_error_mm", "entries"]
"""What guidance is for in a task."""

Trials = list[dict[str, Any]]
"""Rows of a sweep: its point (operator, task, condition, cohort), and the measures of the trial."""


class Mean(TypedDict):
    """Means over all operators of one task under one condition."""

    task: str
    condition: str
    path_error_mm: float
    time_s: float
    mean_force_N: float
    peak_force_N: float
    entries: float
    deepest_mm: float
    hand_peak_force_N: float
    unfinished: int


class Effect(TypedDict):
    """One measure of a condition against the condition none, with 95 % of a bootstrap, and what the literature says."""

    task: str
    condition: str
    measure: str
    change: float | None
    change_low: float | None
    change_high: float | None
    hedges_g: float
    hedges_g_low: float
    hedges_g_high: float
    expected_change: list[float] | None
    expected_hedges_g: float | None
    source: str | None


class Registered(TypedDict):
    """Means of a task at one registration error; None: without guidance."""

    task: str
    error_mm: float | None
    path_error_mm: float
    peak_force_N: float
    entries: float


class BreakEven(TypedDict):
    """From which registration error on guidance is worse than none."""

    task: str
    measure: Purpose
    break_even_mm: float | None
    largest_tried_mm: float


class Ablated(TypedDict):
    """What felt contact takes from a force, with the operators' haste and without."""

    task: str
    measure: str
    change: float
    change_without_haste: float


class Against(TypedDict):
    """Path error that wrong guidance adds, against right guidance and against none, with 95 % of a bootstrap."""

    task: str
    than_right_mm: float
    than_right_low_mm: float
    than_right_high_mm: float
    than_none_mm: float
    than_none_low_mm: float
    than_none_high_mm: float


class Cued(TypedDict):
    """Means of a task under one condition of the visual cues, and 95 % of their difference to none."""

    task: str
    condition: str
    path_error_mm: float
    path_error_mm_more_low: float
    path_error_mm_more_high: float
    mean_force_N: float
    mean_force_N_more_low: float
    mean_force_N_more_high: float
    peak_force_N: float
    peak_force_N_more_low: float
    peak_force_N_more_high: float
    time_s: float
    time_s_more_low: float
    time_s_more_high: float


class Yielded(TypedDict):
    """Path error of guided operators who keep a share of how readily they give way."""

    task: str
    share: float
    path_error_mm: float
    change: float
    change_low: float
    change_high: float


class Summary(TypedDict):
    """What the cohort did."""

    simulated: bool
    operators: int
    rows: list[Mean]
    effects: list[Effect]
    registration: list[Registered]
    break_even: list[BreakEven]
    ablation: list[Ablated]
    control: list[Against]
    control_works: bool


class Found(Summary):
    """The whole study."""

    visual_cues: list[Cued]
    yields: list[Yielded]
