"""Result of ``palpate study zwidth``. The keys are the documented contract of ``--json`` (docs/json.md)."""

from __future__ import annotations

from typing import TypedDict


class Panel(TypedDict):
    """Stable walls of the map and analytic bounds for one rate and one delay."""

    rate_Hz: float
    delay_s: float
    B_N_s_per_m: list[float]
    K_N_per_m: list[float]
    stable: list[list[bool]]  #: indexed by damping, then stiffness
    line_B_N_s_per_m: list[float]
    boundary_N_per_m: list[float | None]  #: along the line; None: every stiffness is stable
    colgate_brown_N_per_m: list[float]


class StudyResult(TypedDict):
    """The whole study."""

    simulated: bool
    device: dict[str, float]
    hand: str
    panels: list[Panel]
