"""Records of a session: the table of signals, MCAP files."""

from palpate.record.reader import Record
from palpate.record.ticks import SIGNALS, TICK, Signal, Ticks, as_rows, as_ticks
from palpate.record.writer import Recorder

__all__ = ["SIGNALS", "TICK", "Record", "Recorder", "Signal", "Ticks", "as_rows", "as_ticks"]
