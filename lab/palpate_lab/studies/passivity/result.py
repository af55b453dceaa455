"""Result of ``palpate study passivity``. The keys are the documented contract of ``--json`` (docs/json.md)."""

from __future__ import annotations

from typing import TypedDict


class Outcome(TypedDict):
    """Result of a run in one mode."""

    rendered_J: float  #: lowest energy of the rendered wall alone
    port_J: float  #: lowest energy of wall and device together
    diverged: bool
    oscillates: bool
    change: float  #: largest difference to the force without the layer, relative to its maximum


class Ran(TypedDict):
    """Results of one random case, without the layer and with the layer in each mode."""

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
    """Summary of all runs in one mode."""

    mode: str
    lowest_port_J: float
    lowest_rendered_J: float
    below_bound: int
    rendered_below_bound: int
    diverged: int
    oscillates: int
    oscillates_certified: int  #: of these, the runs that are certified with their hand


class Changed(TypedDict):
    """Number of runs of a group in which the layer changes the force by 1 % or more."""

    runs: int
    changed: int
    largest_change: float


class Change(Changed):
    """A group by its name."""

    of: str


class ChangedByDelay(Changed):
    """The certified runs in which no cap acted, with a delay in a range."""

    from_s: float
    to_s: float | None


class StudyResult(TypedDict):
    """The whole study."""

    runs: int
    bound_J: float
    simulated: bool
    modes: list[Mode]
    changes: list[Change]
    by_delay: list[ChangedByDelay]


class Extracted(TypedDict):
    """Largest energy that motions in one case took out, with the layer and without it."""

    case: str
    extracted_J: float
    without_J: float


class ExtractedBy(TypedDict):
    """Result of ``palpate study passivity --extract``."""

    simulated: bool
    seed: int
    motions: int  #: per case
    extract: list[Extracted]


class Timed(StudyResult):
    """The result with the seed and the duration of the command."""

    seed: int
    seconds: float
