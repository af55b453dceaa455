"""Records of a session: the table of signals, and MCAP files."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from palpate.record.ticks import SIGNALS, TICK, Signal, Ticks, as_rows, as_ticks

if TYPE_CHECKING:
    from palpate.record.reader import Record
    from palpate.record.writer import Recorder

__all__ = ["SIGNALS", "TICK", "Record", "Recorder", "Signal", "Ticks", "as_rows", "as_ticks"]

_HOME = {"Record": "palpate.record.reader", "Recorder": "palpate.record.writer"}


def __getattr__(name: str) -> Any:
    """Import the readers and writers of MCAP files at first use: a scene needs only the signals."""
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'palpate.record' has no attribute {name!r}")
