"""The export of runs, and the formats that are there."""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any, TypeAlias

from palpate.base import plugins
from palpate.base.errors import PalpateError
from palpate.export.beside import with_forces
from palpate.export.demonstration import Demonstration, demonstrations
from palpate.export.folder import require_free, whole_folder
from palpate.export.options import Options

Exporter: TypeAlias = Callable[[Sequence[Demonstration], Path, Options], dict[str, Any]]
"""Writes runs into an empty folder, and returns facts for the user by name, in plain values. Other distributions add
theirs as entry points of the group `palpate.exporters`, whose name is the format."""


def export(
    records: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    to: str = "lerobot",
    options: Options | None = None,
    **changes: Any,
) -> dict[str, Any]:
    """Write records in another format.

    The folder appears whole, at the end: after an error nothing is left.

    Args:
        records: records, folders of runs (of several pairs, too), or ROS 2 bags of a CRTK session.
        out: folder of the data set; new, or empty.
        to: the format: ``lerobot``, ``minari``, ``parquet``, ``csv``, ``mat``, ``hdf5``, ``rerun``, or one of an
            installed distribution.
        options: options of the format.
        **changes: single options, e.g. ``fps=20``.

    Returns:
        Facts of the data set, in plain values (docs/json/export.md).

    Raises:
        RecordError: a record cannot be read, is cut off, holds no follower, or does not fit the others.
        PalpateError: there is no such format, or no record. OutputError: the folder cannot be written.
        MissingExtraError: a library is not installed.
    """
    write = exporter(to)
    out = Path(out)
    require_free(out)
    listed = [records] if isinstance(records, (str, os.PathLike)) else list(records)
    chosen = replace(options or Options(), **changes)
    runs = demonstrations(Path(os.fspath(one)) for one in listed)
    if chosen.forces is not None:
        runs = with_forces(runs, chosen.forces)
    with whole_folder(out) as draft:
        facts = write(runs, draft, chosen)
    return {"format": to, "out": str(out), "runs": [run.name for run in runs], **facts}


def formats() -> list[str]:
    """Names of all formats."""
    own = [path.stem for path in _FOLDER.iterdir() if not path.name.startswith("_")]
    return sorted({*own, *plugins.names("palpate.exporters")})


def exporter(name: str) -> Exporter:
    """The writer of a format.

    Raises:
        PalpateError: there is none of this name.
    """
    found: Exporter | None = plugins.load("palpate.exporters", name)
    if found is not None:
        return found
    if name not in formats():
        near = difflib.get_close_matches(name, formats(), n=1)
        mend = f"did you mean {near[0]}?" if near else f"use one of {', '.join(formats())}"
        raise PalpateError(f"there is no format {name!r}", mend=mend)
    own: Exporter = import_module(f"palpate.export.formats.{name}").write
    return own


_FOLDER = Path(__file__).parent / "formats"
