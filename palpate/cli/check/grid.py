"""`palpate check` of a distance grid: its nodes, their spacing and the enclosed volume."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from palpate.mesh import Unit
from palpate.surfaces import DistanceGrid


def inspect(path: Path, unit: Unit, console: Console) -> dict[str, Any]:
    """Print the size and volume of the grid; returns the values for JSON."""
    grid = DistanceGrid.load(path, unit)
    nodes = np.array(grid.values.shape)
    extents, inside = grid.spacing * (nodes - 1), int((grid.values < 0).sum())
    table = Table(show_header=False, box=None, pad_edge=False)
    for name, value in (
        ("nodes", " x ".join(f"{n}" for n in nodes)),
        ("spacing", " x ".join(f"{1e3 * s:.3g}" for s in grid.spacing) + " mm; use a tool radius above this"),
        ("extents", " x ".join(f"{1e3 * e:.1f}" for e in extents) + " mm"),
        ("inside", f"{inside:,} nodes, {1e6 * inside * grid.spacing.prod():,.1f} cm^3"),
    ):
        table.add_row(name, value)
    console.print(table)
    lengths = {"nodes": nodes.tolist(), "spacing_m": grid.spacing.tolist(), "extents_m": extents.tolist()}
    return {"grid": {**lengths, "volume_m3": float(inside * grid.spacing.prod())}}
