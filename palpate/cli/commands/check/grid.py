"""`palpate check` of a distance grid: its nodes, their spacing and the enclosed volume."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from palpate.base.arrays import Array
from palpate.world.mesh import Unit
from palpate.world.surfaces import DistanceGrid


@dataclass(frozen=True)
class Size:
    """Size of a distance grid."""

    nodes: NDArray[np.int64]  # (3,)
    spacing_m: Array  # (3,)
    extents_m: Array  # (3,)
    volume_m3: float  # enclosed volume


@dataclass(frozen=True)
class Findings:
    """What `palpate check` finds on a distance grid, as docs/json.md describes it."""

    grid: Size


def inspect(path: Path, unit: Unit, console: Console) -> Findings:
    """Print the size and volume of the grid, and return the findings."""
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
    return Findings(Size(nodes, grid.spacing, extents, float(inside * grid.spacing.prod())))
