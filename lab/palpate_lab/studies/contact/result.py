"""Result of ``palpate study contact``. The keys are the documented contract of ``--json`` (docs/json.md)."""

from __future__ import annotations

from typing import TypedDict

from palpate.scene.contact.judging import Judged


class Measured(Judged):
    """Result of one method along one path over one mesh."""

    triangles: int
    path: str
    penetration_mm: float
    approach_deg: float


class Row(Measured):
    """A result with the shape and the method of the sweep's point."""

    shape: str
    method: str


class GrownPlanes(TypedDict):
    """Normals of planes grown through noisy points."""

    points: int
    spread_mm: float
    noise_um: float
    refused: float  #: fraction of the planes
    direction_median_deg: float | None
    direction_p95_deg: float | None


class StudyResult(TypedDict):
    """The whole study."""

    rows: list[Row]
    planes: list[GrownPlanes]
