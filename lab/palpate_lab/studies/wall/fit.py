"""The fit of one hand and one loop delay to the rows of Table 1."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple

import numpy as np

from palpate.base.arrays import Array
from palpate_lab.studies.wall.bench import Outcome, Setting, WallPress, judge, press
from palpate_lab.studies.wall.work import KDS, TABLE_1

LOW = WallPress(0.02, 0.1, 15.0, 0.4, 0.3, 0.005)
HIGH = WallPress(0.8, 3.0, 300.0, 1.5, 1.5, 0.040)
TRIES, STEPS = 300, 300


def loss(rows: list[Outcome]) -> float:
    """Weighted squared logarithmic errors of three rows against the published rows, mainly the overshoots of rows 2, 3.

    A penalty is added if row 1 does not oscillate or another row does not settle.
    """

    def off(x: float, target: float) -> float:
        return float(np.log(max(x, 1e-6) / target) ** 2)

    total = 0.0 if rows[0]["limit_cycle"] else 2.0
    total += 0.3 * off(rows[0]["overshoot_percent"], TABLE_1[0.0].offshoot_percent)
    for kd, outcome in zip(KDS[1:], rows[1:], strict=True):
        published = TABLE_1[kd]
        total += 4.0 * off(outcome["overshoot_percent"], published.offshoot_percent)
        total += 0.5 * off(outcome["settling_s"], published.response_s) if outcome["settling_s"] is not None else 4.0
        total += 0.3 * off(outcome["steady_state_m"], published.steady_state_m)
    return total


def search(seed: int = 1, on_progress: Callable[[str], object] = lambda _: None) -> tuple[WallPress, float]:
    """Search random hands, then random steps from the best one; returns the best hand and its loss."""
    rng = np.random.default_rng(seed)
    low, high = (np.log(astuple(bound)) for bound in (LOW, HIGH))
    best, least = low, np.inf
    for k in range(TRIES + STEPS):
        x = rng.uniform(low, high) if k < TRIES else np.clip(best + rng.normal(0.0, 0.1, len(low)), low, high)
        found = loss(outcomes(_press(x)))
        if found < least:
            best, least = x, found
        if (k + 1) % 100 == 0:
            on_progress(f"{k + 1} of {TRIES + STEPS} hands, loss {least:.3f}")
    return _press(best), float(least)


def outcomes(hand: WallPress) -> list[Outcome]:
    """The three rows with this hand."""
    return [judge(press(Setting(kd), hand)) for kd in KDS]


def words(found: WallPress, least: float, overshoots: list[float]) -> str:
    """The fitted hand, and the overshoots that it makes, in one sentence."""
    percent = ", ".join(f"{one:.3g}" for one in overshoots)
    return (
        f"found again: {found.mass_kg:.3g} kg, {found.damping_N_s_per_m:.3g} N s/m, {found.stiffness_N_per_m:.3g} N/m, "
        f"push {found.push_N:.3g} N, approach {found.approach_s:.3g} s, delay {1e3 * found.delay_s:.3g} ms, "
        f"loss {least:.3f}; overshoots {percent} %"
    )


def _press(x: Array) -> WallPress:
    return WallPress(*(float(value) for value in np.exp(x)))
