"""Result of ``palpate study certificate``. The keys are the documented contract of ``--json`` (docs/json.md)."""

from __future__ import annotations

from typing import TypedDict


class Summary(TypedDict):
    """Summary of the agreement over all devices."""

    count: int
    median_error: float
    largest_error: float
    share_within: float
    linear_median_error: float
    certified_gains: int
    certified_broken: int


class Walled(TypedDict):
    """One arm of a scene at one wall: predicted and simulated limit."""

    scene: str
    normal: int
    B: float
    delay: float
    predicted_N_per_m: float
    simulated_N_per_m: float
    error: float
    frequency_Hz: float
    certified_broken: float


Row = dict[str, float]
"""One random device: its numbers, predicted and simulated limit (docs/json.md lists the keys)."""
