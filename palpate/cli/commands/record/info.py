"""`palpate record info`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Tell what a record holds: its span, rate, size and signals, and whether it has its end.

    examples:
      palpate record info runs/palpation-20260101-120000/record.mcap
      palpate record info record.mcap --json -
    """

    record: Positional[Path]
    """Record (MCAP), or its folder."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the facts as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Open the record by its index and print what it holds."""
        from palpate.record.reader import Record

        console = console_for(self.json)
        require_writable(self.json)
        record = Record.open(self.record / "record.mcap" if self.record.is_dir() else self.record)
        start, end = record.span
        size = record.path.stat().st_size
        facts = {
            "record": str(record.path), "complete": record.complete, "start_s": start, "end_s": end,
            "duration_s": record.duration, "ticks": len(record), "rate_Hz": record.rate, "bytes": size,
            "mb_per_s": 1e-6 * size / record.duration, "version": record.version, "seed": record.seed,
            "deterministic": record.deterministic, "faults": record.faults, "signals": list(record.signals),
        }  # fmt: skip
        say(console, f"{record.path}: {record.duration:.3f} s from {start:.3f} to {end:.3f} s, {len(record):,} ticks")
        mode = "lockstep" if record.deterministic else "real time"
        size_words = f"{1e-6 * size:.2f} MB, {facts['mb_per_s']:.2f} MB/s"
        say(console, f"{record.rate:g} Hz, {size_words}; palpate {record.version}, {mode}")
        say(console, f"{len(record.signals)} signals: {', '.join(record.signals)}")
        for fault in (*record.faults, *([record.note] if record.note else [])):
            say(console, fault, "fault:", "red")
        write_json(self.json, facts)
        return 0
