"""The certificate in words: what limits the wall, and which changes would raise the limit."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

_WORTH = 1.15  # smallest relative gain for which a change is advised

#: A change, and a function that computes the stiffness limit with this change [N/m].
Advice = tuple[str, Callable[[], float]]


def number(k: float) -> str:
    """A stiffness with three significant digits, without an exponent: ``2270``."""
    if not np.isfinite(k):
        return "any"
    if k == 0.0:
        return "0"
    decimals = 2 - int(np.floor(np.log10(abs(k))))
    return f"{round(k, decimals):.{max(decimals, 0)}f}"


def hands_covered(dampings: Iterable[float], k_less: float) -> str:
    """The hands for which a limit holds, in words: the damping of the assumed hands [N s/m], and the limit for less.

    dampings: of the assumed hands [N s/m]; k_less: limit with `LESS` of their damping [N/m].
    """
    low, high = min(dampings := list(dampings)), max(dampings)
    span = f"{low:g} N s/m" if low == high else f"{low:g} to {high:g} N s/m"
    return f"for hands of {span}; with half of this damping below {number(k_less)} N/m"


LESS = 0.5
"""Fraction of the assumed damping of hands for which a certificate states a second limit [-]."""


@dataclass(frozen=True)
class LoopFacts:
    """Properties of a loop that the reason of a verdict quotes."""

    delay: float
    """Delay in the loop [s]."""
    rate: float
    """Rate of the cycle [Hz]."""
    B: float
    """Damping of the wall [N s/m]."""
    frequency: float
    """Frequency of the oscillation at the limit [Hz]."""
    worst: str
    """Description of the case that sets the limit."""
    lag: str = ""
    """Further delays in words, with a leading comma."""

    def summary(self) -> str:
        """Delay, rate and damping in words: ``9 ms of delay at 1000 Hz and 0.6 N s/m``."""
        delay = f"{1e3 * self.delay:.3g} ms of delay" if self.delay > 0.0 else "no delay"
        return f"{delay} at {self.rate:.4g} Hz{self.lag} and {self.B:.3g} N s/m"


def reason(K: float | None, k_max: float, verdict: str | None, loop: LoopFacts, advice: Iterable[Advice]) -> str:
    """The verdict and its cause in one sentence.

    Example: ``unstable: 9 ms of delay and 0.6 N s/m; stable below 310 N/m; 3 ms less delay would give 870``.
    """
    if not np.isfinite(k_max):
        return "stable: nothing is too stiff for this loop"
    if k_max <= 0.0:
        return f"unstable: {loop.summary()}; that is too much damping, whatever the stiffness"
    swing = f"it would swing at {loop.frequency:.3g} Hz, {loop.worst}"
    if verdict == "stable" and K:
        grown = f"could be {k_max / K:.2g} times as stiff" if k_max > 1.1 * K else "is near the limit"
        return f"stable: {loop.summary()}; {number(K)} N/m {grown}, {number(k_max)} N/m (beyond, {swing})"
    text = f"{verdict}: {loop.summary()}; stable below {number(k_max)} N/m ({swing})".removeprefix("None: ")
    gains = sorted(((k(), change) for change, k in advice), reverse=True)
    return text + "".join(f"; {change} would give {number(k)}" for k, change in gains if k > _WORTH * k_max)
