"""Tetrahedra from and to files: VTK, MSH (Gmsh) and MEDIT, by meshio."""

from __future__ import annotations

import os
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from palpate.base import limits
from palpate.base.arrays import Array
from palpate.base.errors import MeshError, MissingExtraError, PalpateWarning
from palpate.base.values.units import FILE_UNITS
from palpate.world.mesh import headers
from palpate.world.tissue.old_gmsh import Integers, old_version, read_old
from palpate.world.tissue.tetrahedra import TetMesh

ENDINGS = (".vtk", ".vtu", ".msh", ".mesh", ".meshb")
_REGIONS = ("region", "gmsh:physical", "medit:ref", "medit:tetra")


def load(path: str | os.PathLike[str], unit: str = "mm") -> TetMesh:
    """Read a file with tetrahedra. Other elements of the file, such as its surface, are ignored.

    Args:
        path: a file with one of `ENDINGS`.
        unit: unit of its coordinates: mm, cm, m or in.

    Returns:
        The mesh; `region` holds the file's physical groups or references, numbered from 0 in increasing order.

    Raises:
        MeshError: the file is missing, damaged, of another format, or has no tetrahedra.
        MissingExtraError: meshio is not installed.
    """
    file = Path(path)
    if unit not in FILE_UNITS:
        raise MeshError(f"unknown unit {unit!r}", where=str(file), mend=f"use one of {', '.join(FILE_UNITS)}")
    if file.suffix.lower() not in ENDINGS:
        raise MeshError(f"unknown ending {file.suffix!r}", where=str(file), mend=f"use one of {', '.join(ENDINGS)}")
    if not file.is_file():
        raise MeshError("no such file", where=str(file), mend="check the path")
    old = old_version(file) if file.suffix.lower() == ".msh" else None
    points, tets, groups = _arrays(file) if old is None else _old_arrays(file, old)
    region = np.unique(groups, return_inverse=True)[1].reshape(-1)
    mesh = TetMesh(points * FILE_UNITS[unit], tets.astype(np.int32), region.astype(np.int32), str(file))
    for finding in mesh.findings:
        warnings.warn(PalpateWarning(finding.what, where=str(file), why=finding.why, mend=finding.mend), stacklevel=2)
    return mesh


def _old_arrays(file: Path, version: int) -> tuple[Array, Integers, Array]:
    points, tets, groups, types = read_old(file, version)
    if not len(tets):
        raise _no_tetrahedra(file, "elements of Gmsh's types " + ", ".join(types) if types else "no elements")
    return points, tets, groups.astype(np.float64)


def _no_tetrahedra(file: Path, has: str) -> MeshError:
    mend = "export linear tetrahedra (four nodes), or name the closed surface to have it filled"
    return MeshError(f"no tetrahedra; it has {has}", where=str(file), mend=mend)


def _arrays(file: Path) -> tuple[Array, Integers, Array]:
    """Nodes (n, 3) in the file's unit, tetrahedra (m, 4), and their regions (m,)."""
    content = _read(file)
    blocks = [i for i, cells in enumerate(content.cells) if cells.type == "tetra"]
    if not blocks:
        raise _no_tetrahedra(file, ", ".join(sorted({cells.type for cells in content.cells})) or "no cells")
    tets = np.concatenate([content.cells[i].data for i in blocks])
    key = next((k for k in _REGIONS if k in content.cell_data), None)
    groups = (
        np.concatenate([np.asarray(content.cell_data[key][i]).ravel() for i in blocks]) if key else np.zeros(len(tets))
    )
    points = np.asarray(content.points, dtype=np.float64)
    return points, np.asarray(tets, dtype=np.int64), np.asarray(groups, dtype=np.float64)


def save(mesh: TetMesh, path: str | os.PathLike[str], unit: str = "mm") -> None:
    """Write a mesh; the ending of `path` chooses the format.

    Raises:
        MissingExtraError: meshio is not installed.
    """
    meshio = _meshio()
    data = {"medit:ref" if Path(path).suffix in (".mesh", ".meshb") else "region": [mesh.region]}
    content = meshio.Mesh(mesh.nodes / FILE_UNITS[unit], [("tetra", mesh.tets)], cell_data=data)
    meshio.write(str(path), content, file_format="gmsh" if Path(path).suffix == ".msh" else None)


def _read(file: Path) -> Any:
    meshio = _meshio()
    try:
        headers.require(file, limits.read_bytes(file))
        return meshio.read(str(file))
    except (Exception, SystemExit) as error:  # damaged files make meshio raise many kinds, and exit
        why = " ".join(str(error).split())[:300] or type(error).__name__
        raise MeshError("not a readable file", where=str(file), why=why, mend="export it again") from None


def _meshio() -> Any:
    try:
        import meshio
    except ImportError:
        raise MissingExtraError("the reader of files with tetrahedra", "tissue") from None
    return meshio
