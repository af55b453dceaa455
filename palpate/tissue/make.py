"""Tetrahedra that fill a closed surface, by fTetWild (Hu and others 2020, ACM Trans. Graph. 39)."""

from __future__ import annotations

from collections.abc import Callable
from hashlib import sha256
from importlib import metadata

import numpy as np

from palpate import cache
from palpate.arrays.checks import positive
from palpate.errors import MeshError, MissingExtraError
from palpate.mesh import Mesh
from palpate.tissue.tetrahedra import MOST, TetMesh

ENVELOPE = 1e-3
"""Largest distance of the filled volume from the surface, over the diagonal of the surface's box [-]."""


def tetrahedralize(mesh: Mesh, edge: float, *, tell: Callable[[str], None] | None = None) -> TetMesh:
    """Fill a closed surface. The result is kept in the cache, by the content of the surface.

    Args:
        mesh: the closed surface.
        edge: length of the tetrahedra's edges [m].
        tell: called with a line before a long computation and after it.

    Raises:
        MeshError: the surface is open or has no volume, or the edge is too short or too long for it.
        MissingExtraError: pytetwild is not installed.
    """
    positive("edge", edge, "m")
    _require_closed(mesh)
    _require_size(mesh, edge)
    version = _version()
    inputs = (sha256(a.tobytes()).hexdigest() for a in (mesh.vertices, mesh.triangles))
    key = cache.source_key([], version, edge, ENVELOPE, *inputs)
    say = tell or (lambda _: None)

    def make() -> cache.Arrays:
        say(f"{mesh.name}: filling {len(mesh.triangles):,} triangles with tetrahedra of {1e3 * edge:.3g} mm ...")
        return _fill(mesh, edge)

    found = cache.load_or_make("tetrahedra", key, make)
    made = TetMesh(found["nodes"], found["tets"], name=mesh.name)
    _require_same_volume(mesh, made)
    say(f"{mesh.name}: {len(made.tets):,} tetrahedra")
    return made


def _fill(mesh: Mesh, edge: float) -> cache.Arrays:
    from pytetwild.pytetwild import tetrahedralize as fill

    low, high = mesh.bounds
    size = float(np.linalg.norm(high - low))
    nodes, tets = fill(
        (mesh.vertices - low) / size,  # fTetWild's tolerances are relative
        np.array(mesh.triangles),  # writable, as the library demands
        edge_length_fac=min(edge / size, 1.0),
        epsilon=ENVELOPE,
        num_threads=1,  # the result is then the same on every run
        quiet=True,
    )
    nodes, tets = low + size * np.asarray(nodes), np.asarray(tets, dtype=np.int32)
    p = nodes[tets]
    flipped = np.linalg.det(p[:, 1:] - p[:, :1]) < 0
    tets[flipped] = tets[flipped][:, [0, 2, 1, 3]]
    return {"nodes": nodes, "tets": tets}


def _require_closed(mesh: Mesh) -> None:
    r = mesh.report
    if r.watertight and r.volume_m3 > 0.0:
        return
    found = [f.what for f in r.findings] or ["it encloses no volume"]
    raise MeshError(
        f"the surface cannot be filled: {'; '.join(found)}",
        where=mesh.name,
        why="only a closed surface has an inside",
        mend="palpate check FILE --repair mended.stl fills small holes and turns triangles; use mended.stl then",
    )


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
        mend="remesh it as one closed surface without inner walls, then palpate check FILE",
    )


def _version() -> str:
    try:
        return metadata.version("pytetwild")
    except metadata.PackageNotFoundError:
        raise MissingExtraError("the tetrahedral mesher", "tissue") from None
