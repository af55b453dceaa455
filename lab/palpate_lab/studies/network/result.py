"""Result of ``palpate study network``. The keys are the contract of ``--json`` (docs/json/study-network.md)."""

from __future__ import annotations

from typing import TypedDict


class Figures(TypedDict):
    """Figures of one trial; NaN where a value is undefined."""

    energy_mJ: float  #: lowest of both ports: the hand's, and the site's
    energy_hand_mJ: float
    energy_site_mJ: float
    energy_ports_mJ: float  #: lowest net energy of both ports together
    felt_over_true: float
    force_rms_N: float
    force_site_N: float  #: largest force on the tissue
    kick_N: float  #: largest change of the force per tick that no motion explains
    drift_mm: float  #: distance of hand and instrument 1 s after stopping
    round_trip_ms: float
    lost: float  #: share of lost packets
    outages: float  #: reported by the site


class Row(Figures):
    """Figures of one condition and mode."""

    condition: str
    mode: str
    outage_told_ms: float | None  #: beyond the 99.9th percentile of the age; None without an outage
    palpation_s: float | None  #: time of a simulated palpation; None: not done within a minute
    palpation_longer: float | None  #: over that of the model without delay, less 1 [-]


class Ran(Figures):
    """Figures of one random run."""

    run: float
    mode: str
    asked_round_trip_ms: float


class Random(TypedDict):
    """All random runs of one mode."""

    mode: str
    runs: int
    energy_lowest_mJ: float
    energy_ports_lowest_mJ: float
    felt_over_true: list[float]  #: quantiles 0.5, 50 and 99.5 %
    force_rms_N: list[float]  #: the same
    force_site_largest_N: float
    kick_largest_N: float
    drift_largest_mm: float
    not_passive: int  #: runs with an energy below -0.5 mJ
    felt_outside: int  #: runs whose felt_over_true lies outside 0.95-1.05
    rms_outside: int  #: runs whose force_rms_N exceeds 0.03 N


class Moving(TypedDict):
    """A world that moves."""

    case: str
    round_trip_ms: float
    force_rms_N: float
    energy_mJ: float
    kick_N: float
    drift_mm: float  #: distance of hand and instrument 1 s after stopping
    relearnt_s: float | None  #: after a push; None: does not apply


class Alarm(TypedDict):
    """The detector of outages on one network without its outages, and then with one."""

    condition: str
    hours: float  #: virtual time in which false alarms were counted
    false_alarms_per_hour: float
    p999_ms: float  #: of the age of the newest packet
    told_ms: float  #: after which a true outage is told, beyond that
    possible_ms: float  #: age that the network exceeds once an hour without an outage, beyond p999_ms


class StudyResult(TypedDict):
    """The whole result."""

    simulated: bool
    seed: int
    conditions: list[Row]
    random: list[Random]
    moving: list[Moving]
    alarms: list[Alarm]
