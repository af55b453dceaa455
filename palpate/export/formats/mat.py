"""MATLAB: a variable for each signal, (n, 1) or (n, size), and their units, frames and meanings in structures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from scipy.io import savemat

from palpate.base.errors import RecordError
from palpate.export.demonstration import Demonstration
from palpate.export.options import Options
from palpate.export.tables import Table, tables, told

_MOST = 2**31 - 1
"""Bytes of the largest variable of a MATLAB 5 file."""


def write(runs: Sequence[Demonstration], folder: Path, options: Options) -> dict[str, Any]:
    """Write a .mat file (version 5, which MATLAB since 5 and Octave read) for each arm.

    Raises:
        RecordError: a signal is larger than the format allows.
    """
    written = []
    for table in tables(runs, options):
        values: dict[str, Any] = dict(table.whole())
        for name, array in values.items():
            if array.nbytes > _MOST:
                what = f"{name} has {array.nbytes / 1e9:.1f} GB, more than the 2.1 GB of a variable in a .mat file"
                raise RecordError(what, mend="give --every N, or export to hdf5, which MATLAB reads too (h5read)")
        file = folder / f"{table.name}.mat"
        savemat(file, values | _about(table), long_field_names=True, do_compression=True, oned_as="column")
        written.append((table, file, len(values["t"])))
    return told(written)


def _about(table: Table) -> dict[str, Any]:
    return {
        "units": {signal.name: signal.unit for signal in table.signals},
        "frames": {signal.name: signal.frame for signal in table.signals},
        "meanings": {signal.name: signal.doc for signal in table.signals},
        "about": table.facts(),
    }
