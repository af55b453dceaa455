"""Parquet: one row a tick, a column for each number; unit, frame and meaning are metadata of the column."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from palpate.base.errors import MissingExtraError
from palpate.export.demonstration import Demonstration
from palpate.export.options import Options
from palpate.export.tables import Table, columns_of, tables, told
from palpate.record.frame import column_names


def write(runs: Sequence[Demonstration], folder: Path, options: Options) -> dict[str, Any]:
    """Write a Parquet file for each arm, in blocks, so that a record of any length needs constant memory."""
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise MissingExtraError("pyarrow, which writes Parquet,", "learning") from None
    written = []
    for table in tables(runs, options):
        file, rows, schema = folder / f"{table.name}.parquet", 0, _schema(pa, table)
        with pq.ParquetWriter(file, schema, compression="zstd") as out:
            for ticks in table.blocks():
                columns = list(columns_of(ticks, table.signals).values())
                out.write_table(pa.Table.from_arrays([pa.array(values) for values in columns], schema=schema))
                rows += len(ticks)
        written.append((table, file, rows))
    return told(written)


def _schema(pa: Any, table: Table) -> Any:
    columns = []
    for signal in table.signals:
        about = {"signal": signal.name, "unit": signal.unit, "frame": signal.frame, "doc": signal.doc}
        kind = pa.uint64() if signal.is_bits else pa.float64()
        columns += [pa.field(name, kind, metadata=about) for name in column_names(signal)]
    return pa.schema(columns, metadata=table.facts())
