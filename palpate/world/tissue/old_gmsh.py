"""MSH files that meshio does not read: version 1 (``$NOD``), and version 2 without its header, as SOFA writes and reads
them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from palpate.base import limits
from palpate.base.arrays import Array
from palpate.base.errors import MeshError

Integers = npt.NDArray[np.int64]
_TETRAHEDRON = 4
_CONVERT = "gmsh FILE -save -format msh22 converts it"


def old_version(path: Path) -> int | None:
    """1 or 2 if the file is such an MSH file, by its first line; None otherwise."""
    try:
        limits.require_file(path)
        with open(path, "rb") as file:
            first = file.read(256).lstrip().partition(b"\n")[0].strip()
    except OSError:
        return None  # the reader of the file says why
    return {b"$NOD": 1, b"$Nodes": 2}.get(first)


def read_old(path: Path, version: int) -> tuple[Array, Integers, Integers, list[str]]:
    """Read a file of `old_version`.

    Returns:
        Nodes (n, 3) in the file's unit, tetrahedra (m, 4) as indices of nodes, their physical groups (m,), and the
        types of all elements by Gmsh's numbers.

    Raises:
        MeshError: a section is missing or damaged, or an element names a node that the file does not have.
    """
    lines = iter(limits.read_bytes(path).decode("ascii", "replace").splitlines())
    try:
        number, points = _nodes(_section(lines, ("$NOD",) if version == 1 else ("$Nodes",)))
        tets, groups, types = _elements(_section(lines, ("$ELM",) if version == 1 else ("$Elements",)), version)
    except (ValueError, IndexError, StopIteration) as error:
        what = f"MSH {version} without a readable list of nodes and elements"
        raise MeshError(what, where=str(path), why=str(error), mend=f"export it again; {_CONVERT}") from None
    order = np.argsort(number)
    place = np.searchsorted(number, tets, sorter=order).clip(max=len(number) - 1)
    found = order[place]
    if (number[found] != tets).any():
        missing = int(tets[number[found] != tets][0])
        raise MeshError(
            f"an element names node {missing}, which the file does not have", where=str(path), mend=_CONVERT
        )
    return points, found, groups, [str(t) for t in sorted(types)]


def _section(lines: Iterator[str], names: tuple[str, ...]) -> list[list[str]]:
    """Rows of a section after its count."""
    for line in lines:
        if line.strip() in names:
            count = int(next(lines))
            rows = [next(lines).split() for _ in range(count)]
            if any(not row or row[0].startswith("$") for row in rows):
                raise ValueError(f"{line.strip()} announces {count:,} rows and has fewer")
            return rows
    raise ValueError(f"there is no section {names[0]}")


def _nodes(rows: list[list[str]]) -> tuple[Integers, Array]:
    return np.array([int(r[0]) for r in rows], dtype=np.int64), np.array([[float(x) for x in r[1:4]] for r in rows])


def _elements(rows: list[list[str]], version: int) -> tuple[Integers, Integers, set[int]]:
    """Numbers of the nodes of the tetrahedra (m, 4), their physical groups (m,), and the types of all elements."""
    tets, groups, types = [], [], set()
    for row in rows:
        values = [int(x) for x in row]
        types.add(values[1])
        tags = 3 if version == 1 else values[2]  # version 1: group, entity, number of nodes
        nodes = values[2 + tags :] if version == 1 else values[3 + tags :]
        if values[1] != _TETRAHEDRON:
            continue
        if len(nodes) != 4:
            raise ValueError(f"tetrahedron {values[0]} has {len(nodes)} nodes")
        tets.append(nodes)
        groups.append(values[2] if version == 1 else values[3] if tags else 0)
    return np.array(tets, dtype=np.int64).reshape(-1, 4), np.array(groups, dtype=np.int64), types
