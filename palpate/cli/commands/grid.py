"""`palpate grid`."""

from __future__ import annotations

import resource
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json

if TYPE_CHECKING:
    from rich.table import Table

    from palpate.world.surfaces import DistanceGrid
    from palpate.world.surfaces.grid import GridError


@dataclass
class Command:
    """Compute the signed distance grid of a closed mesh, and measure its error against the exact distance.

    examples:
      palpate grid vessel.stl --spacing 0.5
      palpate grid organ.stl --unit m --out organ.npz

    The query time of a grid does not depend on the number of triangles; a grid has at most 512 x 512 x 512 nodes.
    """

    mesh: Positional[Path]
    """Mesh file (STL, OBJ, PLY, ...), closed."""
    spacing: Annotated[float | None, arg(metavar="MM")] = None
    """Distance of the nodes; 1/100 of the mesh when left out. Walls thinner than two spacings are lost."""
    unit: Literal["mm", "cm", "m", "in"] | None = None
    """Unit of the numbers in the mesh file; when left out that of the file or its format, otherwise mm."""
    out: Annotated[Path | None, arg(metavar="FILE.npz")] = None
    """The grid file to write; next to the mesh when left out."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Compute the grid, write it and print its error."""
        import numpy as np

        from palpate.world.mesh import Mesh
        from palpate.world.surfaces import DistanceGrid
        from palpate.world.surfaces.grid import error_of

        console = console_for(self.json)
        out = self.out or self.mesh.with_suffix(".npz")
        require_writable(out)
        mesh = Mesh.load(self.mesh, self.unit)
        spacing = None if self.spacing is None else 1e-3 * self.spacing
        step = spacing or float(np.ptp(mesh.bounds, axis=0).max()) / 100.0
        begin = time.perf_counter()
        with console.status("") as line:
            made = DistanceGrid.from_mesh(
                mesh, step, on_progress=lambda done, of: line.update(f"{done} of {of} layers of nodes")
            )
            took = time.perf_counter() - begin
            line.update(f"writing {out}")
            made.save(out)
            line.update("comparing with the exact distance")
            error = error_of(made, mesh)
        peak = 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        console.print(_table(made, step, took, peak, out, error))
        say(console, f"wrote {out}; errors against the exact distance of the mesh at {error.points:,} random points")
        write_json(self.json, {"mesh": str(self.mesh), "grid": str(out), "nodes": list(made.values.shape),
                               "spacing_m": step, "build_s": took, "peak_memory_bytes": peak,
                               "error_near_p99_m": error.near_p99, "error_near_max_m": error.near_worst,
                               "error_box_p99_m": error.box_p99, "error_box_max_m": error.box_worst})  # fmt: skip
        return 0


def _table(made: DistanceGrid, step: float, took: float, peak: float, file: Path, error: GridError) -> Table:
    from rich.table import Table

    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_row("nodes", f"{' x '.join(map(str, made.values.shape))}, {1e3 * step:.3g} mm apart, {took:.1f} s")
    table.add_row(
        "memory", f"{made.values.nbytes / 1e6:,.0f} MB of values; {peak / 1e6:,.0f} MB at most while building"
    )
    table.add_row("file", f"{file.stat().st_size / 1e6:,.0f} MB")
    table.add_row("error near the surface", f"p99 {1e6 * error.near_p99:.3g} um, worst {1e6 * error.near_worst:.3g} um")
    table.add_row("error in its box", f"p99 {1e6 * error.box_p99:.3g} um, worst {1e6 * error.box_worst:.3g} um")
    return table
