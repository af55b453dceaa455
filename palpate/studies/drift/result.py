"""What ``palpate study drift`` finds. The keys are the documented contract of ``--json`` (docs/json.md)."""

from __future__ import annotations

from typing import TypedDict


class Row(TypedDict):
    """One form of gravity model on one plant."""

    arm: str
    plant: str
    model: str
    mean_mm: float
    median_mm: float
    p95_mm: float
    stays: float  #: share of the releases that do not move
    torque_error_Nm: list[float]  #: of the holding torques, rms of each joint
    beyond_friction: list[float]  #: share of the poses whose error dry friction does not hold
    drift_mm: list[float]  #: of each release, sorted


class Made(TypedDict):
    """What a plant was made of."""

    friction_Nm: list[float]
    noise_Nm: list[float]
    beyond_form_Nm: list[float]


class Described(TypedDict):
    """A recorded arm, and the plants made from it, by name."""

    arm: str
    recordings: list[str]
    friction_Nm: list[float]
    noise_Nm: dict[str, list[float]]
    beyond_form_Nm: dict[str, list[float]]


class Found(TypedDict):
    """The whole study."""

    simulated: bool
    releases: int
    trained_on: int
    released_s: float
    published_mm: dict[str, tuple[float, float, float]]
    arms: list[Described]
    rows: list[Row]
