"""``palpate bench contact``: accuracy and computing time of forces on analytic shapes, with reference figures.

Every row runs in a separate process, so that load time and memory are those of a single mesh.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from time import perf_counter

import numpy as np
from rich.table import Table

from palpate.base.arrays import Array
from palpate.scene.contact.judging import PATHS, RADIUS, Judged, judge
from palpate.world.mesh import files as mesh_files
from palpate.world.shapes.analytic import SHAPES
from palpate.world.shapes.paths import tool_path

SIZES, HUGE = (10_000, 100_000, 1_000_000), 10_000_000


class Row(Judged):
    """One case. The keys are the documented contract of ``--json``."""

    shape: str
    triangles: int
    path: str
    method: str
    load_s: float  #: time from binary STL on disk to indexed mesh, without a cache
    again_s: float  #: the same at the next start, from the cache if the mesh is large
    memory_MB: float  #: peak growth of the process's memory while loading without a cache
    bytes_per_triangle: float  #: the same for each triangle


def run(
    shapes: Sequence[str] = tuple(SHAPES),
    sizes: Sequence[int] = SIZES,
    paths: Sequence[str] = ("deep", "shallow", "fast"),
    method: str = "proxy",
    on_row: Callable[[Row], None] | None = None,
) -> list[Row]:
    """Measure every combination; ``on_row`` is called with each finished row.

    Raises:
        ValueError: a shape or path is unknown.
        RuntimeError: a case failed; the message contains the output of its process.
    """
    for kind, given, known in (("shape", shapes, SHAPES), ("path", paths, PATHS)):
        for name in given:
            if name not in known:
                raise ValueError(f"unknown {kind} {name!r}; there are: {', '.join(known)}")
    rows = []
    with tempfile.TemporaryDirectory(prefix="palpate-bench-") as folder:
        for shape in shapes:
            for size in sizes:
                file = Path(folder) / f"{shape}-{size}.stl"
                vertices, triangles = SHAPES[shape].mesh(size)
                mesh_files.write(file, 1e3 * vertices, triangles)
                for path in paths:
                    row = _in_a_process(file, shape, path, method)
                    rows.append(row)
                    if on_row:
                        on_row(row)
                file.unlink()
    return rows


def _in_a_process(file: Path, shape: str, path: str, method: str) -> Row:
    command = [sys.executable, "-m", "palpate_lab.verify.bench.contact", str(file), shape, path, method]
    with tempfile.TemporaryDirectory(dir=file.parent) as cache:  # empty: the mesh is built
        environment = os.environ | {"XDG_CACHE_HOME": cache}
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    if done.returncode != 0:
        raise RuntimeError(f"bench contact: {shape}, {path}, {method} failed:\n{done.stderr.strip()}")
    row: Row = json.loads(done.stdout.splitlines()[-1])
    return row


def measure(file: Path, shape: str, path: str, method: str) -> Row:
    """Measure one row in this process, which should be newly started."""
    from palpate.world.mesh import Mesh

    before, start = _status_mb("VmRSS"), perf_counter()
    mesh = Mesh.load(file, unit="mm").core
    load_s, memory = perf_counter() - start, _status_mb("VmHWM") - before
    start = perf_counter()
    Mesh.load(file, unit="mm")
    again_s = perf_counter() - start

    offset, speed = PATHS[path]
    tool = tool_path(SHAPES[shape], offset, speed, RADIUS)
    row: Row = {
        "shape": shape,
        "triangles": mesh.triangle_count,
        "path": path,
        "method": method,
        **judge(mesh, SHAPES[shape], tool, method, _cluster() if path == "tool" else None),
        "load_s": load_s,
        "again_s": again_s,
        "memory_MB": memory,
        "bytes_per_triangle": 1e6 * memory / mesh.triangle_count,
    }
    return row


def _cluster() -> Array:
    """Sphere centres (16, 3) [m]: the tip, and 15 centres spread evenly at 1.5 mm around the tip."""
    k = np.arange(15)
    z, turn = 1.0 - 2.0 * (k + 0.5) / 15, np.pi * (1.0 + 5.0**0.5) * k
    ring = np.sqrt(1.0 - z * z)
    around = 1.5e-3 * np.stack([ring * np.cos(turn), ring * np.sin(turn), z], axis=1)
    return np.concatenate([np.zeros((1, 3)), around])


def _status_mb(key: str) -> float:
    """A memory figure of this process from /proc [MB]; NaN on systems without /proc."""
    try:
        lines = Path("/proc/self/status").read_text().splitlines()
    except OSError:
        return float("nan")
    return next((int(line.split()[1]) * 1024 / 1e6 for line in lines if line.startswith(f"{key}:")), float("nan"))


# Reference figures of deep slides on the same input by CHAI3D 3.3.0, which is no part of this project: dynamic proxy,
# shaded normals, scene scaled by 500, one core of a shared machine. The definition of this benchmark came with them.
# Columns: p50, p99 [us]; direction median, p95, max [deg]; magnitude p95, max [mN]; step [deg], [mN].
CHAI3D: dict[tuple[str, int], tuple[float, ...]] = {
    ("sphere", 10_000): (17, 24, 0.13, 0.21, 0.4, 8, 9, 0.3, 1),
    ("sphere", 100_000): (96, 135, 0.11, 0.13, 0.2, 0.7, 1, 0.2, 0.6),
    ("sphere", 1_000_000): (797, float("nan"), 0.11, 0.12, 0.13, 0.1, 0.2, 0.1, 0.2),
    ("torus", 10_000): (11, 20, 0.35, 1.1, 4.2, 25, 30, 5, 9),
    ("torus", 100_000): (48, 86, 0.21, 0.45, 1.9, 2.5, 3, 1.8, 2),
    ("torus", 1_000_000): (348, 697, 0.20, 0.28, 0.85, 0.2, 0.3, 0.9, 0.4),
}


def table(rows: Iterable[Row]) -> Table:
    """The rows for a terminal of 80 columns, with CHAI3D's figures below each deep slide on sphere and torus."""
    rows = list(rows)
    methods = ", ".join(dict.fromkeys(r["method"] for r in rows))
    out = Table(title=f"Method {methods}: r = 2 mm, k = 500 N/m", box=None, padding=(0, 1, 0, 0), pad_edge=False)
    columns: tuple[str, ...] = ("mesh", "path", "us\np50/p99", "direction deg\nmed/p95/max", "force mN\np95/max")
    columns += ("step deg\n/true", "lost\nflip", "work mJ\n/true", "load\ns", "B/\ntri")
    for i, column in enumerate(columns):
        out.add_column(column, justify="left" if i < 2 else "right", no_wrap=True)
    for r in rows:
        out.add_row(
            f"{r['shape']} {_short(r['triangles'])}",
            r["path"],
            f"{r['p50_us']:.2f}/{r['p99_us']:.0f}",
            f"{r['direction_median_deg']:.2f}/{r['direction_p95_deg']:.2f}/{r['direction_max_deg']:.2f}",
            f"{r['magnitude_p95_mN']:.1f}/{r['magnitude_max_mN']:.1f}",
            f"{r['step_deg']:.1f}/{r['true_step_deg']:.1f}",
            f"{r['lost']}/{r['flipped']}",
            "/".join(f"{round(r[key], 2) + 0.0:.2f}" for key in ("energy_mJ", "true_energy_mJ")),  # no -0.00
            f"{r['load_s']:.2f}",
            f"{r['bytes_per_triangle']:.0f}",
        )
        size = min((*SIZES, HUGE), key=lambda n: abs(np.log(n / r["triangles"])))
        reference = CHAI3D.get((r["shape"], size)) if r["path"] == "deep" else None
        if reference:
            p50, p99, median, p95, top, magnitude, magnitude_top, step_deg, _ = (f"{x:g}" for x in reference)
            figures = (f"{p50}/{p99}", f"{median}/{p95}/{top}", f"{magnitude}/{magnitude_top}", step_deg)
            out.add_row("  CHAI3D", "", *figures, style="dim")
    return out


def _short(triangles: int) -> str:
    return f"{triangles / 1e6:.1f}M" if triangles >= 1e6 else f"{triangles / 1e3:.0f}k"


if __name__ == "__main__":
    print(json.dumps(measure(Path(sys.argv[1]), *sys.argv[2:5])))
