"""Reference force of each law, written from its documentation in docs/guidance-laws.md."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

K, B, K_TURN, B_TURN, MOST, MOMENT, RANGE, RANGE_TURN, RATIO = 400.0, 2.0, 0.5, 0.005, 1.0, 0.2, 0.01, 0.8, 0.1
"""Options with which every law is checked."""
RISE, RISE_TURN = 2e-4, 5e-3
"""Violation over which the damping of a position and of an angle rises to B [m, rad]."""
_OPTIONS = {"K": K, "B": B, "K_turn": K_TURN, "B_turn": B_TURN, "force": MOST, "moment": MOMENT, "range": RANGE,
            "range_turn": RANGE_TURN, "ratio": RATIO}  # fmt: skip


@dataclass(frozen=True)
class LawCase:
    """A law with the options of its check."""

    law: str
    force: Callable[[float, bool, bool], float] | None = None
    """(gap, attracts, turns) -> force [N] or moment [N m] at rest; None for a pure velocity law."""
    damping: float = B
    """Damping against a tool above the speed limit [N s/m]."""
    together: bool = False
    """True if one optimisation solves all fixtures with this law."""
    options: dict[str, float] = field(default_factory=lambda: _OPTIONS)


def _spring(gap: float, attracts: bool, turns: bool) -> float:
    return (K_TURN if turns else K) * max(-gap, 0.0)


def _optimise(gap: float, attracts: bool, turns: bool) -> float:
    return min(_spring(gap, attracts, turns), MOMENT if turns else MOST)


def _potential(gap: float, attracts: bool, turns: bool) -> float:
    """Attraction saturates and fades over the last fifth of its range. Repulsion starts at its range."""
    k, most, reach = (K_TURN, MOMENT, RANGE_TURN) if turns else (K, MOST, RANGE)
    if not attracts:
        return min(k * max(reach - gap, 0.0), most)
    e = max(-gap, 0.0)
    return min(k * e, most, k * 0.8 * reach) * float(np.clip((reach - e) / (0.2 * reach), 0.0, 1.0))


#: Cases by the core's name of the law.
LAWS: dict[str, LawCase] = {
    "spring": LawCase("spring", _spring),
    "potential": LawCase("potential", _potential),
    "admittance": LawCase("admittance", damping=B / RATIO),
    "optimise": LawCase("optimise", _optimise, together=True),
}
