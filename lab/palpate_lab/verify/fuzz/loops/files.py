"""Files of generated meshes, grids and clouds, which the scenes of random loops name."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from palpate.base.arrays import Array

_HALF, _CELLS, _DEPTH = 0.02, 24, 0.02  # a relief: half its width, cells along it, height of its sides [m]


@cache
def _kept() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="palpate-loops-", ignore_cleanup_errors=True)


def folder() -> Path:
    """Folder of the files of this process, which is removed at its end."""
    return Path(_kept().name)


def _write(name: str, vertices: Array, faces: Array) -> str:
    """Write a mesh as OBJ unless it is there; the file's name."""
    path = folder() / f"{name}.obj"
    if not path.exists():
        lines = ["v {:.9g} {:.9g} {:.9g}".format(*v) for v in vertices]
        lines += ["f {} {} {}".format(*(f + 1)) for f in faces]
        path.write_text("\n".join(lines) + "\n")
    return path.name


def ball(R: float, n: int) -> str:
    """An icosahedron, each triangle of which is divided n times into four, with its corners on a sphere of R [m]."""
    g = (1 + 5**0.5) / 2
    v = [np.array(p, dtype=float) for a, b in ((1, g), (1, -g), (-1, g), (-1, -g))
         for p in ((0, a, b), (a, b, 0), (b, 0, a))]  # fmt: skip
    v = [p / np.linalg.norm(p) for p in v]
    near = min(np.linalg.norm(v[0] - p) for p in v[1:]) * 1.01
    faces = []
    for i in range(12):
        for j in range(i + 1, 12):
            for k in range(j + 1, 12):
                if max(np.linalg.norm(v[a] - v[b]) for a, b in ((i, j), (j, k), (i, k))) < near:
                    out = np.cross(v[j] - v[i], v[k] - v[i]) @ v[i] > 0
                    faces.append((i, j, k) if out else (i, k, j))
    for _ in range(n):
        v, faces = _divided(v, faces)
    return _write(f"ball-{R:g}-{n}", R * np.array(v), np.array(faces))


def _divided(v: list[Array], faces: list[tuple[int, int, int]]) -> tuple[list[Array], list[tuple[int, int, int]]]:
    middle: dict[tuple[int, int], int] = {}

    def between(a: int, b: int) -> int:
        key = (min(a, b), max(a, b))
        if key not in middle:
            middle[key] = len(v)
            m = v[a] + v[b]
            v.append(m / np.linalg.norm(m))
        return middle[key]

    found = []
    for a, b, c in faces:
        ab, bc, ca = between(a, b), between(b, c), between(c, a)
        found += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return v, found


def relief(z: Callable[[float, float], float], name: str) -> str:
    """A closed block whose upper side is the height z(x, y) [m]."""
    n = _CELLS + 1
    x = np.linspace(-_HALF, _HALF, n)
    top = np.array([(a, b, z(a, b)) for a in x for b in x])
    under = np.array([(a, b, top[:, 2].min() - _DEPTH) for a in x for b in x])
    at = np.arange(n * n).reshape(n, n)
    a, b, c, d = (q.ravel() for q in (at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]))
    upper = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    ring = np.concatenate([at[:-1, 0], at[-1, :-1], at[:0:-1, -1], at[0, :0:-1]])
    after = np.roll(ring, -1)
    low, low_after = ring + n * n, after + n * n
    sides = np.concatenate([np.stack([ring, low, low_after], axis=1), np.stack([ring, low_after, after], axis=1)])
    faces = np.concatenate([upper, upper[:, ::-1] + n * n, sides])
    return _write(name, np.concatenate([top, under]), faces)


def ball_grid(R: float) -> str:
    """A signed distance grid of a sphere of R [m]."""
    path = folder() / f"grid-{R:g}.npz"
    if not path.exists():
        from palpate.world.surfaces import DistanceGrid

        h = R / 12
        x = h * np.arange(-18, 19)
        grid = np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1)
        DistanceGrid(np.linalg.norm(grid, axis=-1) - R, np.full(3, x[0]), h).save(path)
    return path.name


def ball_cloud(R: float) -> str:
    """Points about 1 mm apart on a sphere of R [m], as PLY with normals."""
    path = folder() / f"cloud-{R:g}.ply"
    if not path.exists():
        n = int(4 * np.pi * R**2 / 1e-6)
        k = np.arange(n) + 0.5
        z, a = 1 - 2 * k / n, np.pi * (1 + 5**0.5) * k
        u = np.stack([np.sqrt(1 - z * z) * np.cos(a), np.sqrt(1 - z * z) * np.sin(a), z], axis=1)
        head = ["ply", "format ascii 1.0", f"element vertex {n}"]
        head += [f"property float {c}" for c in ("x", "y", "z", "nx", "ny", "nz")] + ["end_header"]
        rows = [" ".join(f"{c:.8g}" for c in (*(R * q), *q)) for q in u]
        path.write_text("\n".join(head + rows) + "\n")
    return path.name
