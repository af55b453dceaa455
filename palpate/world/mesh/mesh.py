"""A triangle mesh in metres, checked and indexed for contact."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.base.errors import MeshError, PalpateWarning
from palpate.base.values.units import FILE_UNITS
from palpate.world.mesh import check, index

Unit = Literal["mm", "cm", "m", "in"]


class Mesh:
    """A surface of triangles, counter-clockwise seen from outside, in its own frame O.

    The core welds equal vertices, drops duplicate triangles and triangles without area, and reverses the winding of
    closed parts that are inside out and of triangles that disagree with their neighbours. ``report`` holds the counts;
    each finding is also given as a :class:`PalpateWarning`.

    Args:
        vertices: (n, 3) [m].
        triangles: (m, 3) indices into ``vertices``.
        name: name in messages.

    Raises:
        MeshError: wrong shapes, an index out of range, a vertex that is not finite, no triangle with an area, or
            extents that leave numbers no precision.
    """

    vertices: npt.NDArray[np.float64]  #: (n, 3) [m], read-only
    triangles: npt.NDArray[np.int32]  #: (m, 3), read-only
    core: _core.Mesh  #: the C++ mesh with its index
    key: str  #: of the mesh in the user's cache; empty for a small mesh, which is not kept there
    report: check.MeshReport  #: what was found and repaired
    name: str  #: name in messages
    unit: Unit  #: unit of the file's numbers; metres for a mesh made from arrays

    def __init__(self, vertices: npt.ArrayLike, triangles: npt.ArrayLike, *, name: str = "mesh") -> None:
        v, t = _vertices(vertices, name), _triangles(triangles, name)
        _require_indices(t, len(v), name)
        soup = [(np.ascontiguousarray(v), np.ascontiguousarray(t))]
        del v, t
        self._build(soup, name, "m")

    @classmethod
    def load(
        cls,
        path: str | os.PathLike[str],
        unit: Unit | None = None,
        *,
        label: int | str | None = None,
        threshold: float | None = None,
    ) -> Mesh:
        """Read a mesh file, or the surface of a segmentation or CT volume (docs/meshes.md lists the formats).

        Args:
            path: the file.
            unit: the unit of its coordinates: ``mm``, ``cm``, ``m`` or ``in``. When left out, the unit that the file or
                its format states (glTF: metres), and mm for formats without a unit, such as STL.
            label: value or name of a segment of a volume; not needed if it has a single one.
            threshold: instead of label: smallest value inside, e.g. in Hounsfield units.

        Raises:
            MeshError: the file is missing, empty, truncated, of an unknown format, or holds no triangle with an area.
            MissingExtraError: the package that reads the format is not installed.
        """
        if unit is not None and unit not in FILE_UNITS:
            raise MeshError(f"unknown unit {unit!r}", where=str(path), mend=f"use one of {', '.join(FILE_UNITS)}")
        mesh, file = cls.__new__(cls), index.file_key(Path(path), unit, label, threshold)
        known = index.load_file(file)
        if known is not None:
            mesh._take(known[0], known[1], str(path), known[2])
            return mesh
        from palpate.world.mesh import files as mesh_files
        from palpate.world.mesh.volumes import Selection

        with warnings.catch_warnings(record=True) as doubts:
            warnings.simplefilter("always", PalpateWarning)
            vertices, triangles, stated = mesh_files.read_with_unit(Path(path), Selection(label, threshold))
        for doubt in doubts:
            warnings.warn(doubt.message, stacklevel=2)
        unit = unit or stated or "mm"  # type: ignore[assignment]
        assert unit is not None
        _require_finite(vertices, str(path))
        metres: npt.NDArray[np.float64] = np.multiply(vertices, FILE_UNITS[unit], dtype=np.float64)
        del vertices  # frees the memory of a large file
        triangles = _triangles(triangles, str(path))
        _require_indices(triangles, len(metres), str(path))
        soup = [(np.ascontiguousarray(metres), np.ascontiguousarray(triangles))]
        del metres, triangles  # those of the list are freed as soon as they are welded
        mesh._build(soup, str(path), unit)
        if not doubts:  # which are told at each start
            index.keep_file(file, mesh.key, unit)
        return mesh

    def _build(self, soup: list[index.Soup], name: str, unit: str) -> None:
        """Build the core mesh, which welds, repairs and indexes, and warn of its findings; empties the list."""
        try:
            core, key = index.build(soup)
        except ValueError as error:
            what, _, mend = str(error).removeprefix("mesh: ").partition("; ")
            raise MeshError(what, where=name, mend=mend) from None
        self._take(core, key, name, unit)

    def _take(self, core: _core.Mesh, key: str, name: str, unit: str) -> None:
        self.core, self.key = core, key
        self.vertices, self.triangles, self.name = self.core.vertices, self.core.triangles, name
        self.unit = unit  # type: ignore[assignment]
        self.report = check.report_of(self.core.report, unit)
        for f in self.report.findings:
            warnings.warn(PalpateWarning(f.what, where=name, why=f.why, mend=f.mend), stacklevel=5)

    def closest(
        self, points: npt.ArrayLike, max_distance: float = np.inf
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.int32]]:
        """Nearest surface points to ``points`` (n, 3) [m].

        Returns:
            distance (n,) unsigned [m], point (n, 3) [m], outward unit normal (n, 3), triangle (n,): -1 where no
            surface is within ``max_distance``. Triangles are numbered as in ``triangles``.
        """
        return self.core.closest(np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3), max_distance)

    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """(2, 3): lowest and highest corner of the bounding box [m]."""
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    def __repr__(self) -> str:
        """Name, size and extents."""
        x, y, z = self.report.extents_m
        return f"<Mesh {self.name!r}: {len(self.triangles):,} triangles, {x:.3g} x {y:.3g} x {z:.3g} m>"


@contextmanager
def quiet() -> Iterator[None]:
    """Context in which findings give no warnings; they remain in ``Mesh.report``."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PalpateWarning)
        yield


def _vertices(values: npt.ArrayLike, name: str) -> npt.NDArray[np.float64]:
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise MeshError("vertices are not numbers", where=name, why=str(error), mend="pass an (n, 3) array") from None
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(
            f"vertices must have shape (n, 3). Got: {array.shape}", where=name, mend="one row per vertex [m]"
        )
    _require_finite(array, name)
    return array


def _require_finite(vertices: npt.NDArray[np.floating], name: str) -> None:
    if np.isfinite(vertices).all():
        return
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    text = ", ".join(f"{x:g}" for x in vertices[bad[0]])
    raise MeshError(
        f"{len(bad):,} of {len(vertices):,} vertices are not finite; the first is vertex {bad[0]:,}: ({text})",
        where=name,
        why="NaN and infinity are not coordinates",
        mend="remove these vertices or export the mesh again",
    )


def _triangles(values: npt.ArrayLike, name: str) -> npt.NDArray[np.int32]:
    array = np.asarray(values)
    if array.size == 0:
        raise MeshError("zero triangles", where=name, mend="pass an (m, 3) array of vertex indices")
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(
            f"triangles must have shape (m, 3). Got: {array.shape}", where=name, mend="triangulate the faces"
        )
    if not np.issubdtype(array.dtype, np.integer):
        raise MeshError(f"triangles must be integers. Got: {array.dtype}", where=name, mend="pass vertex indices")
    if array.max() > np.iinfo(np.int32).max or array.min() < np.iinfo(np.int32).min:
        raise MeshError(f"triangle index {array.max()} is out of range", where=name, mend="indices count from 0")
    return array.astype(np.int32, copy=False)


def _require_indices(triangles: npt.NDArray[np.int32], n: int, name: str) -> None:
    if triangles.min() >= 0 and triangles.max() < n:
        return
    row = int(np.flatnonzero(((triangles < 0) | (triangles >= n)).any(axis=1))[0])
    raise MeshError(
        f"triangle {row:,} names the vertices {triangles[row].tolist()}; the mesh has {n:,} vertices (0 to {n - 1:,})",
        where=name,
        mend="indices count from 0",
    )
