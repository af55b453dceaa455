"""Signed distance grids: from a mesh, from an array, from a file."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.arrays import Array
from palpate.errors import PalpateWarning, SurfaceError
from palpate.surfaces.surface import Surface, Triangles, length, nets, three

if TYPE_CHECKING:
    from palpate.mesh import Mesh, Unit

#: Nodes a grid may have: 0.54 GB in the core, and as much again while it is made or read.
MAX_NODES = 512**3
_VOLUME = 0.05  # a grid that differs more in volume from its mesh is too coarse for it [-]


class DistanceGrid(Surface):
    """A signed distance sampled on a regular grid, tricubic in between; below zero inside.

    The solid ends at the edge of its grid. A grid rounds edges and loses walls thinner than two of its cells.

    Args:
        values: (nx, ny, nz) signed distance at origin + (i, j, k) * spacing [m].
        origin: (3,) the first node [m].
        spacing: of the nodes, one number or three [m].
        name: how plots and messages call it.

    Raises:
        SurfaceError: wrong shape, values that are no distance, more than ``MAX_NODES``.
    """

    core: _core.DistanceGrid
    values: npt.NDArray[np.float32]  #: (nx, ny, nz) [m], read-only
    origin: Array  #: (3,) [m]
    spacing: Array  #: (3,) [m]

    def __init__(
        self, values: npt.ArrayLike, origin: npt.ArrayLike, spacing: npt.ArrayLike, *, name: str = "distance grid"
    ) -> None:
        if np.ndim(values) != 3:
            raise SurfaceError(f"values must have shape (nx, ny, nz). Got: {np.shape(values)}", where=name)
        _require_size(np.shape(values), name)
        array = np.ascontiguousarray(values, dtype=np.float32)
        step = np.asarray(spacing, dtype=np.float64)
        self.spacing = three("spacing", np.full(3, step) if step.ndim == 0 else step)
        self.name, self.origin = name, three("origin", origin)
        try:
            self.core = _core.DistanceGrid(self.origin, self.spacing, array)
        except ValueError as error:
            raise SurfaceError(str(error), where=name, mend="signed distances in metres, below zero inside") from None
        self.values = self.core.values

    @classmethod
    def from_mesh(
        cls,
        mesh: Mesh,
        spacing: float,
        margin: float | None = None,
        on_progress: Callable[[int, int], None] = lambda done, of: None,
    ) -> DistanceGrid:
        """Sample the signed distance of a closed mesh.

        Args:
            mesh: closed.
            spacing: of the nodes [m]; details and walls below two of them are lost.
            margin: of nodes around the mesh [m]; four spacings when left out.
            on_progress: told how many layers of nodes are done, of how many.

        Raises:
            SurfaceError: an open mesh, a spacing that is no length, or one so fine that the nodes pass ``MAX_NODES``.
        """
        import warnings

        step = length("spacing", spacing)
        if not mesh.report.watertight:
            raise SurfaceError(
                f"the mesh is open: {mesh.report.open_edges:,} open edges",
                where=mesh.name,
                why="a signed distance needs an inside",
                mend="close its holes first, or touch it as a mesh",
            )
        around = 4.0 * step if margin is None else max(float(margin), 2.0 * step)
        low, high = mesh.bounds[0] - around, mesh.bounds[1] + around
        nodes = np.ceil((high - low) / step).astype(int) + 1
        _require_size(tuple(nodes.tolist()), mesh.name, step)
        values, count = _sample(mesh, low, step, nodes, on_progress)
        inside = count * step**3
        if abs(inside - mesh.report.volume_m3) > _VOLUME * mesh.report.volume_m3:
            ratio = 100.0 * inside / mesh.report.volume_m3
            what = f"a grid of {1e3 * step:g} mm holds {ratio:.0f} % of the mesh's volume"
            warnings.warn(
                PalpateWarning(what, where=mesh.name, why="it is too coarse for thin parts", mend="a finer spacing"),
                stacklevel=2,
            )
        return cls(values, low, step, name=mesh.name)

    @classmethod
    def load(cls, path: str | os.PathLike[str], unit: Unit = "mm") -> DistanceGrid:
        """Read a grid: ``.npz`` as ``save`` writes it (metres), or ``.nrrd`` with its header's spacing and origin.

        Args:
            path: the file.
            unit: of an NRRD's values and lengths when its header does not name one.

        Raises:
            SurfaceError: the file is missing, of another format, damaged, or holds no distance.
        """
        file = Path(path)
        if not file.is_file():
            raise SurfaceError("no such file", where=str(file), mend="check the path")
        if file.suffix.lower() == ".nrrd":
            from palpate.surfaces import nrrd

            return cls(*nrrd.read(file, unit), name=file.stem)
        if file.suffix.lower() != ".npz":
            raise SurfaceError(f"{file.suffix or 'no ending'} is no distance grid", where=str(file), mend=".npz, .nrrd")
        try:
            with np.load(file, allow_pickle=False) as data:
                return cls(data["distance"], data["origin"], data["spacing"], name=file.stem)
        except SurfaceError as error:
            raise SurfaceError(error.what, where=str(file), why=error.why, mend=error.mend) from None
        except KeyError as error:
            raise SurfaceError(f"array {error} is missing", where=str(file), mend="distance, origin, spacing") from None
        except (OSError, ValueError, zipfile.BadZipFile) as error:
            raise SurfaceError("cannot be read", where=str(file), why=str(error), mend="save it again") from None

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write ``distance`` (nx, ny, nz) float32, ``origin`` and ``spacing`` (3,), all in metres, as ``.npz``.

        Whole or not at all: an interrupted one leaves what was there before.
        """
        draft = Path(path).with_name(f".{Path(path).name}.{os.getpid()}")
        try:
            with draft.open("wb") as file:
                np.savez(file, distance=self.values, origin=self.origin, spacing=self.spacing)
            draft.replace(path)
        finally:
            draft.unlink(missing_ok=True)

    def __str__(self) -> str:
        """What it is."""
        nodes = " x ".join(f"{n}" for n in self.values.shape)
        steps = " x ".join(f"{1e3 * s:.3g}" for s in dict.fromkeys(self.spacing.tolist()))
        return f"distance grid, {nodes} nodes, {steps} mm apart"

    def _drawing(self) -> tuple[Array, Triangles]:
        highest = self.origin + self.spacing * (np.array(self.values.shape) - 1)
        return nets(self.core, self.origin, highest, float(self.spacing.min()))


@dataclass(frozen=True)
class GridError:
    """How far a grid's distances are from those of the mesh it was made from [m]."""

    near_p99: float
    """within two cells of the surface"""
    near_worst: float
    box_p99: float
    """anywhere in its box"""
    box_worst: float
    points: int
    """random places asked, half of them near the surface"""


def error_of(grid: DistanceGrid, mesh: Mesh, points: int = 40_000, seed: int = 0) -> GridError:
    """Compare a grid with the exact distance of its mesh at random places."""
    rng, half = np.random.default_rng(seed), points // 2
    corners = mesh.vertices[mesh.triangles[rng.integers(0, len(mesh.triangles), half)]]
    weights = rng.dirichlet(np.ones(3), half)[:, :, None]
    near = (weights * corners).sum(axis=1) + rng.uniform(-2.0, 2.0, (half, 3)) * grid.spacing
    box = rng.uniform(grid.origin, grid.origin + grid.spacing * (np.array(grid.values.shape) - 1), (half, 3))
    off = [abs(grid.nearest(p)[0] - mesh.core.nearest(np.ascontiguousarray(p))[0]) for p in (near, box)]
    p99, worst = ([float(f(o)) for o in off] for f in (lambda o: np.percentile(o, 99), np.max))
    return GridError(p99[0], worst[0], p99[1], worst[1], 2 * half)


def _sample(
    mesh: Mesh, low: Array, step: float, nodes: npt.NDArray[np.int_], on_progress: Callable[[int, int], None]
) -> tuple[npt.NDArray[np.float32], int]:
    """Layer by layer on all cores, and how many nodes lie inside. Interrupted, it ends with the layers begun."""
    values = np.empty(nodes, np.float32)

    def fill(i: int) -> int:
        layer = values[i : i + 1]
        _core.sample_distance(mesh.core, low + np.array([i * step, 0.0, 0.0]), np.full(3, step), layer)
        return int(np.count_nonzero(layer < 0.0))

    inside = 0
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for done, count in enumerate(pool.map(fill, range(len(values))), start=1):
            inside += count
            on_progress(done, len(values))
    return values, inside


def _require_size(nodes: tuple[int, ...], name: str, step: float | None = None) -> None:
    count = int(np.prod(nodes, dtype=np.int64))
    if count <= MAX_NODES:
        return
    told = " x ".join(f"{n:,}" for n in nodes)
    mend = "a coarser grid"
    if step is not None:
        mend = f"a spacing of {1e3 * step * (count / MAX_NODES) ** (1 / 3) * 1.05:.2g} mm or more"
    raise SurfaceError(f"{told} nodes are more than {MAX_NODES:,}", where=name, mend=mend)
