"""The table of signals as a numpy dtype: one `TICK` is one row of a run.

The table is defined in C++ (core/palpate/loop/signals.inl). A run's data is a structured array of dtype `TICK`:
`ticks["F_T_W"]` has shape (n, 3), `ticks["t"]` has shape (n,). All signals are doubles except `ticks["status"]`, an
integer whose bits are those of `STATUS`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from palpate import _core

Ticks = NDArray[np.void]
"""A structured array of dtype `TICK`, shape (n,)."""
Rows = NDArray[np.float64]
"""Rows of ticks (n, signals), in the order of the table of signals."""
Timing: TypeAlias = dict[str, Any]
"""Compute time, lateness, slack and missed ticks of a loop, as `Simulation.timing` of the core returns them."""


@dataclass(frozen=True)
class Signal:
    """A row of the table: the description of one recorded signal."""

    name: str
    """Name of the field in `TICK` and of the channel in a record."""
    offset: int
    """Position in a tick [bytes]."""
    size: int
    """Number of elements; each has eight bytes."""
    unit: str
    """SI unit; `rad|m` if it depends on the joint; `1` if dimensionless."""
    frame: str
    """Letter of the frame in which it is expressed (monogram notation); empty without a frame."""
    doc: str
    """Meaning and sign."""
    deterministic: bool
    """False if it depends on the machine (computation times); a lockstep record leaves it out."""
    stage: str
    """The stage that produces it: the first word of its channel."""

    @property
    def is_bits(self) -> bool:
        """True for an integer that holds bits; every other signal consists of doubles."""
        return self.unit == "bits"

    @property
    def format(self) -> str:
        """numpy type of one element, little-endian."""
        return "<u8" if self.is_bits else "<f8"


TICK_BYTES: int = _core.TICK_BYTES
TICK_DOUBLES: int = TICK_BYTES // 8
SIGNALS: dict[str, Signal] = {row[0]: Signal(*row) for row in _core.signals()}
"""Every signal by name, in the order of the tick."""
STATUS: dict[str, tuple[int, str]] = {name: (bit, words) for name, bit, words in _core.status_words()}
"""Bits of the signal `status` by name, each with its index and description, the most severe first."""

TICK: np.dtype[np.void] = np.dtype(
    {
        "names": list(SIGNALS),
        "formats": [s.format if s.size == 1 else (s.format, (s.size,)) for s in SIGNALS.values()],
        "offsets": [s.offset for s in SIGNALS.values()],
        "itemsize": TICK_BYTES,
    }
)
"""numpy dtype of one tick, laid out as the C++ struct."""


def as_tick(row: NDArray[Any]) -> Ticks:
    """A row (TICK_DOUBLES,) of a loop as one tick, an element of `TICK`, as `as_ticks` does for many."""
    tick: Ticks = as_ticks(np.asarray(row).reshape(1, -1))[0]
    return tick


def as_ticks(rows: NDArray[Any]) -> Ticks:
    """Rows of a run as ticks, without copying if the array is contiguous.

    Args:
        rows: (n, TICK_DOUBLES) float64 as `_core.Simulation.run` returns them (ticks viewed as doubles, although
            the status is an integer), or an array of `TICK`.

    Returns:
        (n,) structured array of `TICK`.

    Raises:
        ValueError: another shape or type.
    """
    if rows.dtype == np.float64 and rows.shape[-1] == TICK_DOUBLES:
        return np.ndarray(rows.size // TICK_DOUBLES, TICK, np.ascontiguousarray(rows))  # view(TICK) takes 15 us
    if rows.dtype == TICK:
        return rows.reshape(-1)
    raise ValueError(f"rows of a run are float64 of shape (n, {TICK_DOUBLES}). Got: {rows.dtype} {rows.shape}")


def as_rows(ticks: Ticks) -> NDArray[np.float64]:
    """Ticks as plain rows: (n, TICK_DOUBLES) float64, the inverse of `as_ticks`."""
    return np.ascontiguousarray(ticks).view(np.float64).reshape(-1, TICK_DOUBLES)
