"""``palpate soak contact``: millions of short random pokes at random meshes, none of which may pop through.

The pokes and their evaluation are in C++ (``core/palpate/verify/soak.hpp``). This module creates the meshes, runs two
threads and counts the results.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from palpate import _core, _verify
from palpate.base.arrays import Array
from palpate.scene.contact_method import loaded
from palpate.world.shapes.analytic import MM, Box, Groove, Sphere, Torus, WavySheet

Triangles = NDArray[np.int32]

PASSES = 10_000_000
PER_MESH = 2000  # passes per mesh
THREADS = 2
TRIANGLES = (12, 1500)  # range of triangles per mesh; the evaluation tests all triangles in every tick
EXAMPLES = 10  # largest number of meshes that the result lists
KINDS = ("plate", "thin plate", "organ", "box", "edge", "torus", "sheet", "groove", "holes", "soup")


@dataclass
class Popped:
    """The first pass at a mesh that popped through."""

    mesh: int  #: number of the mesh; number and seed reproduce the mesh
    kind: str
    radius_mm: float
    speed_m_s: float
    depth_mm: float
    object_moves: bool


@dataclass
class Soak:
    """Counts of a soak run. The keys are the documented contract of ``--json``."""

    method: str
    seed: int
    passes: int = 0  #: passes that found free space for their start
    touched: int = 0  #: passes with a force
    ticks: int = 0
    popped: int = 0  #: passes through the surface
    meshes: int = 0
    seconds: float = 0.0
    examples: list[Popped] = field(default_factory=list)  #: the first meshes with a pass through the surface


def run(
    passes: int = PASSES,
    method: str = "proxy",
    seed: int = 1,
    on_progress: Callable[[Soak], None] | None = None,
) -> Soak:
    """Run ``passes`` passes on two threads; the same seed gives the same meshes and passes.

    Raises:
        ValueError: the method is unknown, or ``passes`` is below 1.
    """
    if passes < 1:
        raise ValueError(f"passes must be at least 1, got {passes}")
    out, start, mesh = Soak(method, seed), perf_counter(), 0

    def add(report: tuple[str, int, _verify.SoakReport]) -> None:
        _add(out, *report)
        out.seconds = perf_counter() - start
        if on_progress:
            on_progress(out)

    with ThreadPoolExecutor(THREADS) as pool:
        while out.passes < passes:  # repeats the few passes that found no free space
            counts = [min(PER_MESH, passes - out.passes - k) for k in range(0, passes - out.passes, PER_MESH)]
            jobs = [(mesh + k, method, seed, count) for k, count in enumerate(counts)]
            mesh += len(counts)
            for report in _in_order(pool, jobs):
                add(report)
    return out


def _in_order(
    pool: ThreadPoolExecutor, jobs: Iterable[tuple[int, str, int, int]]
) -> Iterator[tuple[str, int, _verify.SoakReport]]:
    """Yield results in the order of the jobs; a few jobs run ahead."""
    ahead: deque[Future[tuple[str, int, _verify.SoakReport]]] = deque()
    try:
        for job in jobs:
            ahead.append(pool.submit(_at_one_mesh, *job))
            if len(ahead) >= 2 * THREADS:
                yield ahead.popleft().result()
        while ahead:
            yield ahead.popleft().result()
    finally:
        for future in ahead:
            future.cancel()


def _at_one_mesh(number: int, method: str, seed: int, passes: int) -> tuple[str, int, _verify.SoakReport]:
    rng = np.random.default_rng([seed, number])
    kind = KINDS[int(rng.integers(len(KINDS)))]
    mesh = None
    while mesh is None:
        try:
            mesh = _core.Mesh(*random_mesh(kind, rng))
        except ValueError:  # all triangles of a soup are degenerate: draw another mesh
            continue
    return kind, number, _verify.soak(mesh, loaded(method), passes, int(rng.integers(2**63)), _verify.SoakRange())


def _add(out: Soak, kind: str, number: int, report: _verify.SoakReport) -> None:
    out.passes += report.passes
    out.touched += report.touched
    out.ticks += report.ticks
    out.popped += report.popped
    out.meshes += 1
    if report.popped and len(out.examples) < EXAMPLES:
        p = report.first_popped
        out.examples.append(Popped(number, kind, p.radius / MM, p.speed, p.depth / MM, p.object_moves))


def random_mesh(kind: str, rng: np.random.Generator) -> tuple[Array, Triangles]:
    """A mesh of one of ``KINDS`` that is large enough for the tool: vertices (n, 3) [m] and triangles (m, 3)."""
    n = int(TRIANGLES[0] * (TRIANGLES[1] / TRIANGLES[0]) ** rng.random())
    side = rng.uniform(20, 60, 3) * MM
    if kind in ("plate", "thin plate", "holes"):
        side[2] = 0.5 * MM if kind == "thin plate" else rng.uniform(0.5, 2) * MM
        vertices, faces = Box((side[0], side[1], side[2])).mesh(n)
    elif kind == "soup":
        corners = (
            rng.normal(size=(max(2, n // 8), 1, 3)) * side / 2 + rng.normal(size=(max(2, n // 8), 3, 3)) * side / 4
        )
        vertices, faces = corners.reshape(-1, 3), np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3)
    elif kind == "sheet":
        vertices, faces = WavySheet(rng.uniform(1, 6) * MM, rng.uniform(10, 60) * MM, side[0]).mesh(n)
    elif kind == "organ":
        vertices, faces = Sphere().mesh(n)
        bumps, amount = rng.normal(size=(4, 3)) * rng.uniform(20, 120), rng.uniform(0, 0.15)
        vertices = vertices * (1 + amount * np.sin(vertices @ bumps.T).mean(axis=1))[:, None]
        vertices *= rng.uniform([0.5, 0.5, 0.05], [1.5, 1.5, 1])
    elif kind == "torus":
        vertices, faces = Torus(rng.uniform(15, 40) * MM, rng.uniform(2, 10) * MM).mesh(max(n, 60))
    elif kind == "groove":
        vertices, faces = Groove(side[0]).mesh(n)
        vertices[:, 2] *= 10.0 ** rng.uniform(-1, 0.6)  # dihedral angles from 30 to 170 degrees
    else:
        vertices, faces = Box((side[0], side[1], side[2])).mesh(n)
        if kind == "edge":  # sheared and stretched into wedges and slivers
            vertices = vertices @ (np.eye(3) + rng.uniform(-1.5, 1.5, (3, 3)) * [[0, 1, 1], [0, 0, 1], [0, 0, 0]])
            vertices[:, 2] *= np.where(vertices[:, 0] > 0, rng.uniform(0.02, 1), 1.0)
    if kind == "holes":
        faces = faces[rng.random(len(faces)) > rng.uniform(0.02, 0.3)]
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return vertices @ (turn * np.sign(np.linalg.det(turn))), np.ascontiguousarray(faces)


def table(soak: Soak) -> Table:
    """The counts as a table for a terminal."""
    out = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False, show_header=False)
    for words, value in (
        ("method", soak.method),
        ("passes", f"{soak.passes:,} over {soak.meshes:,} meshes, {soak.touched:,} with a force"),
        ("ticks", f"{soak.ticks:,} at 1 kHz"),
        ("popped through", f"{soak.popped:,}"),
        ("time", f"{soak.seconds:.0f} s"),
    ):
        out.add_row(words, value)
    for e in soak.examples:
        out.add_row(
            f"  mesh {e.mesh}, {e.kind}",
            f"radius {e.radius_mm:.2f} mm, {e.speed_m_s:.2f} m/s, {e.depth_mm:.1f} mm deep"
            + (", object moves" if e.object_moves else ""),
        )
    return out
