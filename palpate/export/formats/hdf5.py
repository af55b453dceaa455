"""HDF5: a data set for each signal, over the coordinate t, with units and meaning as netCDF-4 has them, for xarray."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from palpate.base.errors import MissingExtraError
from palpate.export.demonstration import Demonstration
from palpate.export.options import Options
from palpate.export.tables import tables, told
from palpate.record.ticks import Signal

_CHUNK = 4096  # ticks
_AXES = {3: "xyz", 4: "wxyz"}


def write(runs: Sequence[Demonstration], folder: Path, options: Options) -> dict[str, Any]:
    """Write an HDF5 file for each arm, in blocks, so that a record of any length needs constant memory."""
    try:
        import h5py
    except ImportError:
        raise MissingExtraError("h5py, which writes HDF5,", "learning") from None
    written = []
    for table in tables(runs, options):
        file = folder / f"{table.name}.h5"
        rows = -(-len(table.ticks) // table.every)
        with h5py.File(file, "w") as out:
            out.attrs.update(table.facts())
            arrays = {signal.name: _array(out, signal, rows) for signal in table.signals}
            at = 0
            for ticks in table.blocks():
                for name, array in arrays.items():
                    array[at : at + len(ticks)] = ticks[name]
                at += len(ticks)
        written.append((table, file, rows))
    return told(written)


def _array(out: Any, signal: Signal, rows: int) -> Any:
    """The empty data set of a signal, with its scales: t, and an axis of its numbers."""
    shape = (rows, signal.size) if signal.size > 1 else (rows,)
    chunks = (min(rows, _CHUNK), *shape[1:])
    array = out.create_dataset(signal.name, shape, signal.format, chunks=chunks, compression="gzip", shuffle=True)
    about = {"units": signal.unit, "frame": signal.frame, "long_name": signal.doc}
    array.attrs.update({key: value for key, value in about.items() if value})
    if signal.name == "t":
        array.make_scale("t")
        return array
    array.dims[0].attach_scale(out["t"])
    if signal.size > 1:
        named = bool(signal.frame) or signal.name.startswith("quat")
        axis = _AXES[signal.size] if named and signal.size in _AXES else f"part_{signal.size}"
        if axis not in out:
            scale = out.create_dataset(axis, data=list(range(signal.size)))
            scale.make_scale(axis)
        array.dims[1].attach_scale(out[axis])
    return array
