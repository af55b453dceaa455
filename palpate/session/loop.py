"""Interface of the loop that a session runs: a simulation of the core, or a node that drives real devices."""

from __future__ import annotations

from typing import Protocol

from palpate import _core
from palpate.record.ticks import Rows, Timing


class Loop(Protocol):
    """A real-time loop in its own thread; mailboxes transfer its state and its controls."""

    controls: _core.Controls
    """Reading returns a copy; an assigned value takes effect as a whole before the next cycle."""

    def start(self) -> None:
        """Start running in real time."""
        ...

    def stop(self) -> None:
        """Stop with the force at zero."""
        ...

    def drain(self) -> Rows:
        """The rows since the last call."""
        ...

    def latest(self) -> Rows:
        """The newest row (signals,); does not wait for the loop."""
        ...

    def soft_vertices(self, object: int, /) -> Rows:
        """Deformed vertices (n, 3) of a soft object, in the object's frame O [m]."""
        ...

    @property
    def dropped(self) -> int:
        """Number of rows lost because the ring buffer was not drained in time."""
        ...

    def timing(self) -> Timing:
        """Compute time, lateness, slack and missed ticks."""
        ...

    def set_snapshot(self, snapshot: _core.Snapshot, /) -> None:
        """Replace all objects before the next cycle."""
        ...

    def set_live(self, targets: _core.LiveTargets, /) -> None:
        """Set the poses that the live objects shall reach."""
        ...

    def set_fixtures(self, fixtures: _core.FixtureList, /) -> None:
        """Replace all virtual fixtures before the next cycle."""
        ...

    def fault(self) -> str | None:
        """Reason for which the loop stopped by itself; None if it did not stop."""
        ...


class LockstepLoop(Loop, Protocol):
    """A loop that can also run tick by tick in the caller's thread: a simulation."""

    def run(self, n_ticks: int, /) -> Rows:
        """Run `n_ticks` and return their rows; no rows while the loop is paused."""
        ...
