"""What ``palpate study zwidth`` finds. The keys are the documented contract of ``--json`` (docs/json.md)."""

from __future__ import annotations

from typing import TypedDict


class Panel(TypedDict):
    """One rate and one delay: which walls of the map are stable, and what analysis says."""

    rate_Hz: float
    delay_s: float
    B_N_s_per_m: list[float]
    K_N_per_m: list[float]
    stable: list[list[bool]]  #: by damping, by stiffness
    line_B_N_s_per_m: list[float]
    boundary_N_per_m: list[float | None]  #: along the line; None: no stiffness is the largest
    colgate_brown_N_per_m: list[float]


class Found(TypedDict):
    """The whole study."""

    simulated: bool
    device: dict[str, float]
    hand: str
    panels: list[Panel]
