"""`palpate path` and `palpate grid`: what fixtures are made from."""

from __future__ import annotations

import resource
import time
from pathlib import Path

import numpy as np
from rich.table import Table

from palpate.cli.output import console_for, require_writable, say, write_json
from palpate.errors import PalpateError
from palpate.mesh import Mesh, Unit


def record_path(record: Path, out: Path, spacing: float, smooth: float, span: tuple[float, float] | None,
                json: Path | None) -> int:  # fmt: skip
    """Write the way of the tool in a record as a path file."""
    from palpate.guidance import curve, demonstration
    from palpate.guidance.files import write_rows

    console = console_for(json)
    shown = demonstration.read(record, span)
    require_writable(out)
    places, rotations = demonstration.simplified(shown, spacing, smooth)
    path = curve.path(places, rotations, name=str(record), crossing=0.0)
    write_rows(out, places, rotations)
    off = demonstration.deviation(path, shown)
    say(console, f"{record}: {len(shown.t):,} ticks, {shown.t[-1] - shown.t[0]:.2f} s of motion")
    say(console, f"smoothed over {1e3 * smooth:g} mm, a place every {1e3 * spacing:g} mm: "
                 f"{len(places)} places, {1e3 * path.length:.4g} mm long")  # fmt: skip
    say(console, f"from what was shown: rms {1e3 * off.rms:.3g} mm, worst {1e3 * off.worst:.3g} mm")
    try:
        curve.path(places, rotations, name=str(out))
    except PalpateError as error:
        say(console, str(error), "warning:", "yellow")
    say(console, f"wrote {out}; in a scene: follow: {out}")
    write_json(json, {"record": str(record), "path": str(out), "places": len(places), "length_m": path.length,
                      "deviation_rms_m": off.rms, "deviation_max_m": off.worst})  # fmt: skip
    return 0


def grid(mesh_file: Path, spacing: float | None, unit: Unit, out: Path | None, json: Path | None) -> int:
    """Make a distance grid of a mesh, and say how far it is from the exact distance."""
    from palpate.surfaces import DistanceGrid
    from palpate.surfaces.grid import error_of

    console = console_for(json)
    out = out or mesh_file.with_suffix(".npz")
    require_writable(out)
    mesh = Mesh.load(mesh_file, unit)
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
        off = error_of(made, mesh)
    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_row("nodes", f"{' x '.join(map(str, made.values.shape))}, {1e3 * step:.3g} mm apart, {took:.1f} s")
    peak = 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    table.add_row(
        "memory", f"{made.values.nbytes / 1e6:,.0f} MB of values; {peak / 1e6:,.0f} MB at most while building"
    )
    table.add_row("file", f"{out.stat().st_size / 1e6:,.0f} MB")
    table.add_row("error near the surface", f"p99 {1e6 * off.near_p99:.3g} um, worst {1e6 * off.near_worst:.3g} um")
    table.add_row("error in its box", f"p99 {1e6 * off.box_p99:.3g} um, worst {1e6 * off.box_worst:.3g} um")
    console.print(table)
    say(console, f"wrote {out}; against the exact distance of the mesh at {off.points:,} random places")
    write_json(json, {"mesh": str(mesh_file), "grid": str(out), "nodes": list(made.values.shape), "spacing_m": step,
                      "build_s": took, "peak_memory_bytes": peak,
                      "error_near_p99_m": off.near_p99, "error_near_max_m": off.near_worst,
                      "error_box_p99_m": off.box_p99, "error_box_max_m": off.box_worst})  # fmt: skip
    return 0
