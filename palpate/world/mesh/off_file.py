"""OFF files with faces of any number of corners, which are cut into triangles; colours and normals are left out."""

from __future__ import annotations

import re

import numpy as np
import numpy.typing as npt

from palpate.base import limits
from palpate.base.arrays import Array

_COMMENT = re.compile(r"#[^\n]*")
_KIND = re.compile(r"(ST)?C?N?OFF")

Triangles = npt.NDArray[np.int64]


def decode(data: bytes) -> tuple[Array, Triangles]:
    """Vertices (n, 3) in the file's unit and triangles (m, 3).

    Raises:
        ValueError, IndexError: the file is damaged, binary, or has four coordinates.
    """
    lines = [line.split() for line in _COMMENT.sub("", data.decode("latin-1")).splitlines()]
    lines = [line for line in lines if line]
    if not lines or not _KIND.fullmatch(lines[0][0].upper()):
        raise ValueError(f"it begins with {' '.join(lines[0])[:20] if lines else ''!r}, not with OFF, COFF or NOFF")
    if lines[0][1:2] == ["BINARY"]:
        raise ValueError("it is binary; save it as text")
    rest = [lines[0][1:], *lines[1:]] if len(lines[0]) > 1 else lines[1:]
    n, m = int(rest[0][0]), int(rest[0][1])
    limits.require_present(n + m, 1, len(rest) - 1, "vertices and faces, one a line,")
    vertices = np.array([row[:3] for row in rest[1 : n + 1]], dtype=np.float64).reshape(-1, 3)
    triangles: list[list[int]] = []
    for row in rest[n + 1 : n + m + 1]:
        corners = [int(word) for word in row[1 : int(row[0]) + 1]]
        if len(corners) != int(row[0]) or (corners and not 0 <= min(corners) <= max(corners) < n):
            raise ValueError(f"the face {' '.join(row)[:60]!r} does not fit {n:,} vertices")
        triangles += cut(vertices, corners)
    return vertices, np.array(triangles, dtype=np.int64).reshape(-1, 3)


def cut(vertices: Array, corners: list[int]) -> list[list[int]]:
    """Triangles of a polygon, in its sense of turning, by cutting off ears (G. H. Meisters, 1975)."""
    if len(corners) <= 3:
        return [corners] if len(corners) == 3 else []
    p = vertices[corners]
    normal = np.cross(p, np.roll(p, -1, axis=0)).sum(axis=0)  # Newell's normal, twice the area
    left, found = list(range(len(corners))), []
    while len(left) > 3:
        ears = [k for k in range(len(left)) if _is_ear(p, normal, left, k)]
        k = max(ears, key=lambda k: _shape(p, left, k)) if len(left) < 64 and ears else (ears or [0])[0]
        found.append([corners[left[j % len(left)]] for j in (k - 1, k, k + 1)])
        left.pop(k)
    return [*found, [corners[i] for i in left]]


def _is_ear(p: Array, normal: Array, left: list[int], k: int) -> bool:
    a, b, c = (p[left[j % len(left)]] for j in (k - 1, k, k + 1))
    if np.cross(b - a, c - b) @ normal <= 0.0:
        return False
    ends = {left[j % len(left)] for j in (k - 1, k, k + 1)}
    others = p[[i for i in left if i not in ends]]
    sides = [np.cross(v - u, others - u) @ normal for u, v in ((a, b), (b, c), (c, a))]
    return not bool((np.minimum.reduce(sides) >= 0.0).any())


def _shape(p: Array, left: list[int], k: int) -> float:
    """Area over the squared edges of an ear: larger for better triangles."""
    a, b, c = (p[left[j % len(left)]] for j in (k - 1, k, k + 1))
    edges = float(np.square(b - a).sum() + np.square(c - b).sum() + np.square(a - c).sum())
    return float(np.linalg.norm(np.cross(b - a, c - a))) / max(edges, 1e-300)
