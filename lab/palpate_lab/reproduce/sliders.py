"""A page with sliders for the angle of approach, the gap, and the noise of a scene; it needs no server.

The page holds numbers that the core has computed (items `approach` and `noise`, and the pairs of Fig 6A); its script
only draws and interpolates them.
"""

from __future__ import annotations

import csv
import json
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from palpate.cli.terminal.output import write_text

PAGE = "sliders.html"
_SOURCES = ("approach", "noise")


def write_sliders(folder: Path) -> Path | None:
    """Write the page into the folder of the items; None if the items `approach` and `noise` are not there.

    Raises:
        OutputError: the page cannot be written.
    """
    tables = {name: folder / name / f"{name}.csv" for name in _SOURCES}
    if not all(table.is_file() for table in tables.values()):
        return None
    data = {"gap": gaps(), **{name: _read(table) for name, table in tables.items()}}
    package = files("palpate_lab.reproduce")
    page = package.joinpath("sliders.html").read_text(encoding="utf-8")
    script = package.joinpath("sliders.js").read_text(encoding="utf-8")
    file = folder / PAGE
    write_text(file, page.replace("/*DATA*/", json.dumps(data)).replace("/*SCRIPT*/", script))
    return file


def gaps() -> dict[str, Any]:
    """Sections of both surfaces of Fig 6A in the plane y = 0, and their pairs of points over the gap [mm]."""
    from palpate_lab.studies.geometry.drawing import outline
    from palpate_lab.studies.geometry.work import approaches

    lengths = np.logspace(-2, -8, 61)
    U, V, pairs = approaches(lengths.tolist())
    shapes = {
        name: np.round(1e3 * outline(S.core.half, S.exponents, 120), 3).tolist() for name, S in (("U", U), ("V", V))
    }
    rows = [
        {"x": (1e3 * p.x[[0, 2]]).tolist(), "y": (1e3 * p.y[[0, 2]]).tolist(), "n_U": p.n_U[[0, 2]].tolist(),
         "n_V": p.n_V[[0, 2]].tolist(), "p_V": (1e3 * p.p_V[[0, 2]]).tolist(), "gap_mm": 1e3 * p.gap, "cross": p.cross,
         "dot": p.dot}
        for p in pairs
    ]  # fmt: skip
    return {**shapes, "pairs": rows}


def _read(table: Path) -> list[dict[str, Any]]:
    with table.open(encoding="utf-8", newline="") as stream:
        return [{key: _number(value) for key, value in row.items()} for row in csv.DictReader(stream)]


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text
