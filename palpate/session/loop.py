"""What a session needs from the loop that it runs: a simulation of the core, or a node that drives real devices."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from palpate import _core

Rows = NDArray[np.float64]
"""(n, signals) rows of ticks, in the order of the table of signals."""


class Loop(Protocol):
    """A loop in real time: it runs in a thread of its own and is looked at and steered through mailboxes."""

    controls: _core.Controls
    """Reading gives a copy; an assigned value reaches the loop whole, before its next cycle."""

    def start(self) -> None:
        """Run on in real time."""
        ...

    def stop(self) -> None:
        """Stop with the force at zero."""
        ...

    def drain(self) -> Rows:
        """The rows since the last call."""
        ...

    def latest(self) -> Rows:
        """The newest row (signals,); never waits for the loop."""
        ...

    @property
    def dropped(self) -> int:
        """Number of rows lost because nobody drained the ring in time."""
        ...

    def timing(self) -> dict[str, Any]:
        """Compute time, lateness, slack and missed ticks."""
        ...

    def set_snapshot(self, snapshot: _core.Snapshot, /) -> None:
        """Replace the scene, whole, before the next cycle."""
        ...

    def set_fixtures(self, fixtures: _core.Fixtures, /) -> None:
        """Replace the virtual fixtures, whole, before the next cycle."""
        ...

    def fault(self) -> str | None:
        """Why the loop stopped by itself; None when it did not."""
        ...


class LockstepLoop(Loop, Protocol):
    """A loop that also runs tick by tick in the caller's thread: a simulation."""

    def run(self, n_ticks: int, /) -> Rows:
        """Run `n_ticks` and return their rows; none while it is paused."""
        ...
