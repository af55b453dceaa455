"""Result of ``palpate study guidance``. The keys are the documented contract of ``--json`` (docs/json.md)."""

from __future__ import annotations

from typing import Literal, TypedDict

from palpate.base.sweep.work import Values

Purpose = Literal["path_error_mm", "entries"]
"""The measure that the guidance of a task should improve."""

Trials = list[Values]
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
    peak_50ms_N: float
    unfinished: int


class Effect(TypedDict):
    """Effect of a condition on one measure, relative to the condition none, with 95 % bounds and Holm's probability."""

    task: str
    condition: str
    measure: str
    change: float | None
    change_low: float | None
    change_high: float | None
    p: float
    p_holm: float
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
    """Registration error above which guidance is worse than none."""

    task: str
    measure: Purpose
    break_even_mm: float | None
    largest_tried_mm: float


class Ablated(TypedDict):
    """Relative change of a force by haptic feedback, with the operators' haste and without."""

    task: str
    measure: str
    change: float
    change_without_haste: float


class Against(TypedDict):
    """Additional path error of displaced guidance, relative to correct guidance and to none; bounds (95 %)."""

    task: str
    than_right_mm: float
    than_right_low_mm: float
    than_right_high_mm: float
    than_none_mm: float
    than_none_low_mm: float
    than_none_high_mm: float


class Cued(TypedDict):
    """Means of a task under one condition of the visual cues, and 95 % bounds of their difference to none."""

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
    """Path error of guided operators whose trait `yields` is scaled by `share`."""

    task: str
    share: float
    path_error_mm: float
    change: float
    change_low: float
    change_high: float


class Stiffened(TypedDict):
    """Path error of operators guided by fixtures of another stiffness."""

    task: str
    stiffness_N_per_m: float
    path_error_mm: float
    change: float
    change_low: float
    change_high: float


class Cared(TypedDict):
    """Hedges' g of the time with guidance, of operators who slow down for the error that they see, and who do not."""

    task: str
    hedges_g: float
    hedges_g_without_care: float


class Assumptions(TypedDict):
    """Result of ``palpate study guidance --assumptions``."""

    simulated: bool
    operators: int
    seed: int
    stiffness: list[Stiffened]
    care: list[Cared]


class Summary(TypedDict):
    """Statistics of the cohort."""

    simulated: bool
    operators: int
    seed: int
    rows: list[Mean]
    effects: list[Effect]
    registration: list[Registered]
    break_even: list[BreakEven]
    ablation: list[Ablated]
    control: list[Against]
    control_works: bool


class StudyResult(Summary):
    """Result of the whole study."""

    visual_cues: list[Cued]
    yields: list[Yielded]
