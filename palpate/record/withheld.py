"""Why does the hand feel less than the law asks for? The answer of every tick, in newtons.

The signal `F_asked` is the force that contacts and guidance ask of the hand. `F_withheld` says which element withholds
how much of it; both differ by what the hand feels. The same words stand in the terminal, in the viewer, on
/diagnostics, in summaries and in records.
"""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.record.ticks import STATUS, Ticks

NAMES = ("coupling", "low_pass", "passivity", "force_cap", "rate_cap", "device", "gate")
"""Elements that withhold a force, in the order of the signal `F_withheld`."""
WORDS = {
    "coupling": "the virtual coupling",
    "low_pass": "the low-pass",
    "passivity": "passivity (the hand has not put in enough energy)",
    "force_cap": "the force cap",
    "rate_cap": "the rate cap",
    "device": "the ramp after a pause, or the drives' limits",
    "gate": "a closed gate",
}
LEAST = 0.05
"""Smallest withheld force that is told [N]."""
SHARE = 0.1
"""Smallest share of the asked force that is told [-]."""
LASTING = 0.5
"""Time after which a withheld force is told [s]."""
SHIFT = 1e-3
"""Smallest shift of the tool against the hand that is told [m]."""
_GATES = (
    *("clutched", "not_following", "no_operator", "not_enabled", "two_sources", "no_listener", "base_moved", "guarded"),
    *("second_writer", "other_teleop", "frame_unsure", "not_finite", "not_rotation", "too_far", "bad_stamp"),
    *("clock_offset", "clock_jumped", "jumped", "alternating", "streams_disagree", "stalled", "slow", "lagging"),
    *("leader_stale", "follower_stale", "settling"),
)  # conditions that forbid a force


def parts(F_withheld: Array, asked: float) -> dict[str, float]:
    """The elements that withhold a noticeable part, with their force [N], the largest first.

    Args:
        F_withheld: signal of a tick, or its mean over some (7,) [N].
        asked: asked force [N].
    """
    least = max(LEAST, SHARE * asked)
    found = {name: float(F) for name, F in zip(NAMES, F_withheld, strict=True) if least < F}
    return dict(sorted(found.items(), key=lambda one: -one[1]))


def sentence(asked: Array, F_withheld: Array, status: int) -> str:
    """Who withholds how much, in words; empty if the hand feels what is asked.

    Args:
        asked: signal `F_asked` (3,): in all, of contacts, of guidance [N].
        F_withheld: signal `F_withheld` (7,) [N].
        status: bits of the signal `status`, for the reason of a closed gate.
    """
    found = parts(F_withheld, float(asked[0]))
    if not found:
        return ""
    who = ", ".join(f"{_who(name, status)} withholds {F:.2f} N" for name, F in found.items())
    felt = max(0.0, float(asked[0]) - float(np.sum(F_withheld)))
    return f"{felt:.2f} of {asked[0]:.2f} N are felt (law {asked[1]:.2f}, guidance {asked[2]:.2f} N): {who}"


def shift_sentence(shift: Array, how: str) -> str:
    """The shift of the tool against the hand (3,) [m] in words, with how to take it back; empty if it is small."""
    size = float(np.linalg.norm(shift))
    if not size >= SHIFT:
        return ""
    return (
        f"a pause has shifted the tool by {1e3 * size:.1f} mm against the hand, and all surfaces with it. Mend: {how}"
    )


def in_words(tick: Ticks) -> list[str]:
    """The sentences about a tick: withheld force and shift; empty if the hand feels the law where it should."""
    asked, withheld = np.nan_to_num(tick["F_asked"]), np.nan_to_num(tick["F_withheld"])
    found = [sentence(asked, withheld, int(tick["status"])),
             shift_sentence(np.nan_to_num(tick["p_shift_W"]), "clutch, or take_back")]  # fmt: skip
    return [words for words in found if words]


def _who(name: str, status: int) -> str:
    if name != "gate":
        return WORDS[name]
    closed = [STATUS[gate][1].partition(":")[0] for gate in _GATES if status & STATUS[gate][0]]
    return f"{WORDS[name]} ({', '.join(closed)})" if closed else WORDS[name]


class Withheld:
    """Accumulates which element withheld how much for how long.

    Args:
        dt: time of a tick [s].
    """

    SIGNALS = ("F_withheld", "F_asked", "p_shift_W")
    """Signals that the ticks must have."""

    def __init__(self, dt: float) -> None:
        self._dt = dt
        self._peak, self._ticks, self._sum = np.zeros(len(NAMES)), np.zeros(len(NAMES), int), np.zeros(len(NAMES))
        self._shift = 0.0

    def add(self, ticks: Ticks) -> None:
        """Add further ticks (n,)."""
        if not len(ticks):
            return
        withheld, asked = np.nan_to_num(ticks["F_withheld"]), np.nan_to_num(ticks["F_asked"][:, 0])
        noticed = withheld > np.maximum(LEAST, SHARE * asked)[:, None]
        self._peak = np.maximum(self._peak, np.where(noticed, withheld, 0.0).max(axis=0))
        self._ticks += noticed.sum(axis=0)
        self._sum += np.where(noticed, withheld, 0.0).sum(axis=0)
        self._shift = float(np.linalg.norm(np.nan_to_num(ticks["p_shift_W"][-1])))

    def figures(self) -> dict[str, dict[str, float]]:
        """By element: largest and mean withheld force [N] and the time in which it was noticeable [s]."""
        return {
            name: {"peak_N": float(self._peak[k]), "mean_N": float(self._sum[k] / self._ticks[k]),
                   "time_s": round(float(self._ticks[k]) * self._dt, 9)}
            for k, name in enumerate(NAMES) if self._ticks[k]
        }  # fmt: skip

    @property
    def shift(self) -> float:
        """Shift of the tool against the hand at the end [m]."""
        return self._shift
