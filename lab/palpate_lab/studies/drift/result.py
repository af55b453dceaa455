"""Result of ``palpate study drift``. The keys are the documented contract of ``--json`` (docs/json.md)."""

from __future__ import annotations

from typing import TypedDict


class Drift(TypedDict):
    """Drift of an arm after its release."""

    mean_mm: float
    median_mm: float
    p95_mm: float
    stays: float  #: fraction of the releases without motion
    torque_error_Nm: list[float]  #: rms error of the holding torque of each joint
    beyond_friction: list[float]  #: fraction of the poses where the error exceeds the dry friction, per joint
    drift_mm: list[float]  #: drift of all releases, sorted


class Made(TypedDict):
    """Parameters of a plant."""

    friction_Nm: list[float]
    noise_Nm: list[float]
    beyond_form_Nm: list[float]


class Released(Drift):
    """Result of one point of the sweep."""

    made: Made


class Row(Drift):
    """Result of one form of gravity model on one plant."""

    arm: str
    plant: str
    model: str


class Described(TypedDict):
    """A recorded arm and the parameters of its plants by name."""

    arm: str
    recordings: list[str]
    friction_Nm: list[float]
    noise_Nm: dict[str, list[float]]
    beyond_form_Nm: dict[str, list[float]]


class StudyResult(TypedDict):
    """The whole study."""

    simulated: bool
    releases: int
    trained_on: int
    released_s: float
    published_mm: dict[str, tuple[float, float, float]]
    arms: list[Described]
    rows: list[Row]
