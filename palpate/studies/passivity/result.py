"""What ``palpate study passivity`` finds. The keys are the documented contract of ``--json`` (docs/json.md)."""

from __future__ import annotations

from typing import TypedDict


class Outcome(TypedDict):
    """What came of a run of one mode."""

    rendered_J: float  #: lowest energy of the rendered wall alone
    port_J: float  #: lowest energy of wall and device together
    diverged: bool
    oscillates: bool
    change: float  #: largest change of the force against the run without the layer, over its largest force


class Ran(TypedDict):
    """One random case, without the layer and with it in each mode."""

    K_N_per_m: float
    B_N_s_per_m: float
    delay_s: float
    rate_Hz: float
    case_seed: int
    passive: bool
    certified: bool
    calm: bool
    silent: bool
    force_N: float
    speed_m_s: float
    off: Outcome
    observer: Outcome
    tank: Outcome
    alone: Outcome


class Mode(TypedDict):
    """All runs of one mode."""

    mode: str
    lowest_port_J: float
    lowest_rendered_J: float
    below_bound: int
    rendered_below_bound: int
    diverged: int
    oscillates: int


class Change(TypedDict):
    """How often the layer changes the force by 1 % and more, in some of the runs."""

    of: str
    runs: int
    changed: int
    largest_change: float


class Found(TypedDict):
    """The whole study."""

    runs: int
    bound_J: float
    simulated: bool
    modes: list[Mode]
    changes: list[Change]


class Timed(Found):
    """The study as a command ran it."""

    seed: int
    seconds: float
