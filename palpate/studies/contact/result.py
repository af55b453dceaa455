"""What ``palpate study contact`` finds. The keys are the documented contract of ``--json`` (docs/json.md)."""

from __future__ import annotations

from typing import TypedDict

from palpate.contact.judging import Judged


class Measured(Judged):
    """One method along one way over one mesh."""

    triangles: int
    path: str
    penetration_mm: float
    approach_deg: float


class Row(Measured):
    """The same, with the shape and the method that the sweep asked for."""

    shape: str
    method: str


class Plane(TypedDict):
    """Planes grown through noisy points: their normals."""

    points: int
    spread_mm: float
    noise_um: float
    refused: float  #: share of the planes
    direction_median_deg: float | None
    direction_p95_deg: float | None


class Found(TypedDict):
    """The whole study."""

    rows: list[Row]
    planes: list[Plane]
