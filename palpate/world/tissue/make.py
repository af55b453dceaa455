"""Tetrahedra that fill a closed surface, by fTetWild (Hu and others 2020, ACM Trans. Graph. 39)."""

from __future__ import annotations

import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from hashlib import sha256
from importlib import metadata
from pathlib import Path

import numpy as np

from palpate.base import cache
from palpate.base.arrays.checks import positive
from palpate.base.errors import MeshError, MissingExtraError
from palpate.world.mesh import Mesh, quiet
from palpate.world.mesh.repair import repair
from palpate.world.tissue.tetrahedra import MOST, TetMesh, signed_volumes

ENVELOPE = 1e-3
"""Largest distance of the filled volume from the surface, over the diagonal of the surface's box [-]."""

PERIOD = 10.0
"""Period of the lines that tell that the mesher still runs [s]."""


def tetrahedralize(mesh: Mesh, edge: float, *, tell: Callable[[str], None] | None = None) -> TetMesh:
    """Fill a closed surface. The result is kept in the cache, by the content of the surface.

    Args:
        mesh: the closed surface.
        edge: length of the tetrahedra's edges [m].
        tell: called with a line before and after the computation; not if the result is in the cache.

    Raises:
        MeshError: the surface is open or has no volume, or the edge is too short or too long for it.
        MissingExtraError: pytetwild is not installed.
    """
    positive("edge", edge, "m")
    _require_closed(mesh)
    _require_size(mesh, edge)
    version = _version()
    inputs = (sha256(a.tobytes()).hexdigest() for a in (mesh.vertices, mesh.triangles))
    key = cache.source_key([Path(__file__).with_name("fill.py")], version, edge, ENVELOPE, *inputs)
    say = tell or (lambda _: None)

    def make() -> cache.Arrays:
        say(f"{mesh.name}: filling {len(mesh.triangles):,} triangles with tetrahedra of {1e3 * edge:.3g} mm ...")
        made = _fill(mesh, edge, say)
        say(f"{mesh.name}: {len(made['tets']):,} tetrahedra, kept in the cache")
        return made

    found = cache.load_or_make("tetrahedra", key, make)
    made = TetMesh(found["nodes"], found["tets"], name=mesh.name)
    _require_same_volume(mesh, made)
    return made


def _fill(mesh: Mesh, edge: float, say: Callable[[str], None]) -> cache.Arrays:
    low, high = mesh.bounds
    size = float(np.linalg.norm(high - low))
    with tempfile.TemporaryDirectory(prefix="palpate-") as folder:
        surface = {"vertices": (mesh.vertices - low) / size, "triangles": mesh.triangles}
        np.savez(Path(folder) / "surface.npz", edge=min(edge / size, 1.0), envelope=ENVELOPE, **surface)
        _run(folder, mesh.name, say)
        with np.load(Path(folder) / "volume.npz") as volume:
            nodes, tets = low + size * volume["nodes"], volume["tets"].astype(np.int32)
    flipped = signed_volumes(nodes, tets) < 0
    tets[flipped] = tets[flipped][:, [0, 2, 1, 3]]
    return {"nodes": nodes, "tets": tets}


def _run(folder: str, name: str, say: Callable[[str], None]) -> None:
    """Run the mesher in `folder`, with a line every ten seconds.

    Raises:
        MeshError: it fails.
    """
    program = [sys.executable, str(Path(__file__).with_name("fill.py"))]
    with open(Path(folder) / "messages", "w+", encoding="utf-8") as messages:
        child = subprocess.Popen(program, cwd=folder, stdout=messages, stderr=subprocess.STDOUT)
        try:
            start, code = time.monotonic(), None
            while code is None:
                try:
                    code = child.wait(PERIOD)
                except subprocess.TimeoutExpired:
                    say(f"{name}: still filling, after {time.monotonic() - start:.0f} s")
        finally:
            child.kill()  # an interrupt ends the mesher, too
        if code != 0 or not (Path(folder) / "volume.npz").exists():
            messages.seek(0)
            why = (messages.read().strip().splitlines() or ["no message"])[-1]
            raise MeshError(f"the mesher failed (exit {code})", where=name, why=why, mend="palpate check FILE")


def _require_closed(mesh: Mesh) -> None:
    r = mesh.report
    if r.watertight and r.volume_m3 > 0.0:
        return
    found = [f.what for f in r.findings] or ["it encloses no volume"]
    raise MeshError(
        f"the surface cannot be filled: {'; '.join(found)}",
        where=mesh.name,
        why="only a closed surface has an inside",
        mend=_mend(mesh),
    )


def _mend(mesh: Mesh) -> str:
    """What ``palpate check --repair`` would do to an open surface."""
    command = f"palpate check {mesh.name} --repair mended.stl"
    if mesh.report.open_edges == 0:
        return f"give a closed surface; {command} corrects its winding only"
    narrow = 0.1 * float(np.linalg.norm(mesh.report.extents_m))  # the default of --hole
    wide = 0.0
    for widest in (narrow, np.inf):
        vertices, triangles, done = repair(mesh.core, widest)
        with quiet():
            closed = Mesh(vertices, triangles).report.watertight
        if closed:
            size = f" --hole {math.ceil(wide)}" if wide > 0.0 else ""
            return f"{command}{size} closes it (holes filled: {done.filled}); then use mended.stl"
        wide = done.widest_left_mm
    return f"{command} would leave holes of up to {wide:.3g} mm open: close them in the program that made the surface"


def _require_size(mesh: Mesh, edge: float) -> None:
    count = 8.5 * mesh.report.volume_m3 / edge**3  # a regular tetrahedron has the volume edge^3 / 8.5
    if count > MOST:
        mend = f"an edge of {1e3 * (mesh.report.volume_m3 / 1e3) ** (1 / 3):.2g} mm gives about 10,000"
        raise MeshError(f"edges of {1e3 * edge:.3g} mm give {count:,.0f} tetrahedra", where=mesh.name, mend=mend)
    if edge > max(mesh.report.extents_m):
        mend = f"its largest extent is {1e3 * max(mesh.report.extents_m):.3g} mm"
        raise MeshError(f"edges of {1e3 * edge:.3g} mm do not fit into the surface", where=mesh.name, mend=mend)


def _require_same_volume(mesh: Mesh, made: TetMesh) -> None:
    """Self-intersecting surfaces enclose parts twice or not at all: the filled volume then differs."""
    surface, volume = mesh.report.volume_m3, float(made.volumes.sum())
    if abs(volume / surface - 1.0) < 0.05:
        return
    raise MeshError(
        f"the surface encloses {1e6 * surface:.4g} ml by its triangles, but {1e6 * volume:.4g} ml were filled",
        where=mesh.name,
        why="the surface intersects itself, or it has thin parts that the envelope closes",
        mend="unite its parts into one closed surface without inner walls, for example by a boolean union; "
        "palpate check --repair closes holes and does not mend this",
    )


def _version() -> str:
    try:
        return metadata.version("pytetwild")
    except metadata.PackageNotFoundError:
        raise MissingExtraError("the tetrahedral mesher", "tissue") from None
