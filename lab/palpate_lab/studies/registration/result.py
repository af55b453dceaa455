"""Result of ``palpate study registration``. The keys are the documented contract of ``--json`` (docs/json.md)."""

from __future__ import annotations

from typing import TypedDict


class Predicted(TypedDict):
    """Predicted against simulated target error over layouts."""

    layouts: int
    p95_m: float
    largest_p95_m: float
    largest_error: float
    largest_from_closed_form: float | None
    largest_from_horn: float | None


class Matched(TypedDict):
    """Unknown correspondence."""

    trials: int
    right: float
    refused: float


class Marked(TypedDict):
    """One marker off by 3 mm."""

    trials: int
    found: float
    alone: float
    false_alarms: float


class Viewed(TypedDict):
    """Partial views of a surface, of one kind."""

    trials: int
    wrong: int
    converged: float | None
    median_m: float | None
    p95_m: float | None
    wrong_told: float | None
    right_trusted: float | None
    mean_nees: float | None


class Seen(TypedDict):
    """Hand-eye calibrations."""

    trials: int
    position_p95_m: float
    rotation_p95_rad: float
    mean_nees: float


class Touched(TypedDict):
    """Landmarks touched by the simulated hand."""

    trials: int
    fre_m: float
    predicted_m: float
    simulated_m: float
    largest_m: float


class Chained(TypedDict):
    """The chain of tracker, arms, camera and organ."""

    trials: int
    tip_median_m: float
    tip_largest_m: float
    felt_median_m: float
    felt_largest_m: float
    felt_within_1mm: float


class Registered(TypedDict):
    """Unattended sessions of one kind."""

    trials: int
    told: float
    right: float | None
    predicted_m: float | None
    error_m: float | None
    largest_m: float | None
    touches: float | None
    seconds: float | None
    check_passed: float | None
    off_failed: float | None


class Real(TypedDict):
    """A real pair of clouds."""

    points: int
    explained: float
    rms_m: float
    noise_m: float
    trusted: bool
    moved_m: float
    from_small_gicp_m: float
    from_small_gicp_rad: float


class Found(TypedDict):
    """The whole study."""

    simulated: bool
    seed: int
    predicted: dict[str, Predicted]
    unknown: dict[str, Matched]
    wrong_marker: dict[str, Marked]
    surface: dict[str, Viewed]
    wrong_told: float | None
    handeye: dict[str, Seen]
    touched: Touched
    chain: Chained
    session: dict[str, Registered]
    real: Real | None
    layouts: dict[str, list[dict[str, float]]]
