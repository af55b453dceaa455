"""Damaged distance grids, as `.npz` and `.nrrd`: each is read and answers with finite numbers, or is refused."""

from __future__ import annotations

import gzip
import io
import tempfile
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from palpate.base.errors import PalpateError
from palpate.world.surfaces import DistanceGrid
from palpate_lab.verify.fuzz import FaultError
from palpate_lab.verify.fuzz.damage import damaged


def case(seed: int) -> dict[str, int]:
    """Read one damaged grid and query it.

    Raises:
        FaultError: the grid was accepted, but a distance or a normal is not finite.
    """
    rng = np.random.default_rng(seed)
    kind = str(rng.choice([".npz", ".nrrd"]))
    with tempfile.TemporaryDirectory(prefix="palpate-fuzz-") as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = Path(folder) / f"grid{kind}"
        path.write_bytes(_npz(rng) if kind == ".npz" else _nrrd(rng))
        try:
            grid = DistanceGrid.load(path)
        except PalpateError:
            return {"refused": 1, kind: 1}
    highest = grid.origin + grid.spacing * (np.array(grid.values.shape) - 1)
    points = np.array([grid.origin, highest, 0.5 * (grid.origin + highest), [0.0, 0.0, 0.0]])
    for value in grid.nearest(points):
        if not np.isfinite(value).all():
            raise FaultError(f"{kind}: an answer is not finite")
    return {"read": 1, kind: 1}


def _values(rng: np.random.Generator, spacing: float) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    """The distance to a sphere on a grid of random size; sometimes with one critical value."""
    n = rng.integers(4, 9, 3)
    nodes = spacing * np.stack(np.meshgrid(*map(np.arange, n), indexing="ij"), axis=-1)
    values = np.linalg.norm(nodes - 0.5 * nodes[-1, -1, -1], axis=-1) - spacing
    if rng.uniform() < 0.2:
        values.flat[rng.integers(values.size)] = rng.choice([np.nan, np.inf, -np.inf, 1e38, 1e-40])
    return np.asarray(values, dtype=np.float32)


def _npz(rng: np.random.Generator) -> bytes:
    spacing = 10.0 ** rng.uniform(-4, -1)
    values, file = _values(rng, spacing), io.BytesIO()
    arrays: dict[str, Any] = {"distance": values, "origin": rng.normal(size=3), "spacing": np.full(3, spacing)}
    if rng.uniform() < 0.5:  # a sound file of unsuitable arrays
        name = str(rng.choice(list(arrays)))
        other = [np.zeros(3), np.full(3, np.nan), np.array(1.0), np.array(["a"]), -arrays[name], arrays[name][:1], None]
        arrays[name] = other[rng.integers(len(other))]
    arrays = {name: np.asarray(value, dtype=object if value is None else None) for name, value in arrays.items()}
    np.savez(file, **arrays)
    return damaged(rng, file.getvalue(), 1 if rng.uniform() < 0.5 else 0)


def _nrrd(rng: np.random.Generator) -> bytes:
    values = _values(rng, 1.0)
    kind, dtype = [("float", "<f4"), ("double", "<f8"), ("short", "<i2")][rng.integers(3)]
    with np.errstate(invalid="ignore"):
        data = values.astype(dtype).tobytes(order="F")
    encoding = str(rng.choice(["raw", "gzip"]))
    sizes = " ".join(str(k) for k in values.shape)
    head = f"NRRD0004\ntype: {kind}\ndimension: 3\nsizes: {sizes}\nencoding: {encoding}\nendian: little\n"
    head += (
        "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\n"
        if rng.uniform() < 0.5
        else "spacings: 1 1 1\n"
    )
    return damaged(rng, head.encode(), 2) + b"\n" + (gzip.compress(data) if encoding == "gzip" else data)
