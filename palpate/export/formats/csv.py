"""CSV: one row a tick, a column for each number, named with its unit; PlotJuggler takes the first column as time."""

from __future__ import annotations

from collections.abc import Sequence
from csv import writer
from pathlib import Path
from typing import Any

from palpate.export.demonstration import Demonstration
from palpate.export.options import Options
from palpate.export.tables import columns_of, tables, told


def write(runs: Sequence[Demonstration], folder: Path, options: Options) -> dict[str, Any]:
    """Write a CSV file for each arm. Numbers are written so that they read back bit for bit."""
    written = []
    for table in tables(runs, options):
        file, rows = folder / f"{table.name}.csv", 0
        with file.open("w", newline="", encoding="utf-8") as stream:
            out = writer(stream)
            for ticks in table.blocks():
                columns = columns_of(ticks, table.signals)
                if not rows:
                    out.writerow(columns)
                out.writerows(zip(*(values.tolist() for values in columns.values()), strict=True))
                rows += len(ticks)
        written.append((table, file, rows))
    return told(written)
