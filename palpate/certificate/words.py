"""The certificate in words: what limits the wall, and what would help."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

_WORTH = 1.15  # an advice has to buy so much

#: What would help, and the stiffness it would give [N/m].
Advice = tuple[str, Callable[[], float]]


def number(k: float) -> str:
    """Three digits of a stiffness, no powers of ten: ``2270``."""
    if not np.isfinite(k):
        return "any"
    digits = max(0, 2 - int(np.floor(np.log10(max(abs(k), 1e-9)))))
    return f"{round(k, 2 - int(np.floor(np.log10(max(abs(k), 1e-9))))):.{digits}f}" if k else "0"


@dataclass(frozen=True)
class LoopFacts:
    """What a reason speaks of."""

    delay: float
    """In the loop [s]."""
    rate: float
    """Of the cycle [Hz]."""
    B: float
    """[N s/m]."""
    frequency: float
    """At which it would swing [Hz]."""
    worst: str
    """The case that sets the limit."""
    lag: str = ""
    """What else is late, with its own comma."""

    def told(self) -> str:
        """``9 ms of delay at 1000 Hz and 0.6 N s/m``."""
        delay = f"{1e3 * self.delay:.3g} ms of delay" if self.delay > 0.0 else "no delay"
        return f"{delay} at {self.rate:.4g} Hz{self.lag} and {self.B:.3g} N s/m"


def reason(K: float | None, k_max: float, verdict: str | None, loop: LoopFacts, advice: Iterable[Advice]) -> str:
    """One sentence: ``unstable: 9 ms of delay and 0.6 N s/m; stable below 310 N/m; 3 ms less delay would give 870``."""
    if not np.isfinite(k_max):
        return "stable: nothing is too stiff for this loop"
    if k_max <= 0.0:
        return f"unstable: {loop.told()}; that is too much damping, whatever the stiffness"
    swing = f"it would swing at {loop.frequency:.3g} Hz, {loop.worst}"
    if verdict == "stable" and K:
        grown = f"could be {k_max / K:.2g} times as stiff" if k_max > 1.1 * K else "is near the limit"
        return f"stable: {loop.told()}; {number(K)} N/m {grown}, {number(k_max)} N/m (beyond, {swing})"
    told = f"{verdict}: {loop.told()}; stable below {number(k_max)} N/m ({swing})"
    told = told.removeprefix("None: ")
    gains = sorted(((k(), what) for what, k in advice), reverse=True)
    return told + "".join(f"; {what} would give {number(k)}" for k, what in gains if k > _WORTH * k_max)
