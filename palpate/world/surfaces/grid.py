"""Signed distance grids, made from a mesh, an array or a file."""

from __future__ import annotations

import os
import zipfile
import zlib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.base import limits
from palpate.base.arrays import Array
from palpate.base.errors import PalpateWarning, SurfaceError
from palpate.world.mesh import volume_files
from palpate.world.surfaces.surface import Surface, Triangles, length, nets, three

if TYPE_CHECKING:
    from palpate.world.mesh import Mesh, Unit

#: Largest number of nodes of a grid: 0.54 GB in the core, and twice that while it is made or read.
MAX_NODES = 512**3
_VOLUME = 0.05  # relative difference in volume above which a grid is too coarse for its mesh [-]


class DistanceGrid(Surface):
    """A signed distance sampled on a regular grid, with tricubic interpolation; negative inside.

    The solid ends at the boundary of the grid. Sampling rounds edges and loses walls thinner than two cells.

    Args:
        values: (nx, ny, nz) signed distance at origin + (i, j, k) * spacing [m].
        origin: (3,) the first node [m].
        spacing: distance between nodes, one number or (3,) [m].
        name: name in plots and messages.

    Raises:
        SurfaceError: wrong shape, values that are not distances, or more than ``MAX_NODES``.
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
            raise SurfaceError(
                str(error), where=name, mend="give signed distances in metres, negative inside"
            ) from None
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
            mesh: a closed mesh.
            spacing: distance between nodes [m]; details and walls thinner than two spacings are lost.
            margin: distance from the mesh to the boundary of the grid [m]; default: four spacings.
            on_progress: called with the number of layers done and the number of layers.

        Raises:
            SurfaceError: the mesh is open, the spacing is not a positive length, or it needs more than ``MAX_NODES``.
        """
        import warnings

        step = length("spacing", spacing)
        if not mesh.report.watertight:
            raise SurfaceError(
                f"the mesh is open: {mesh.report.open_edges:,} open edges",
                where=mesh.name,
                why="a signed distance needs a closed surface",
                mend="close its holes first, or use it as a mesh",
            )
        around = 4.0 * step if margin is None else max(float(margin), 2.0 * step)
        low, high = mesh.bounds[0] - around, mesh.bounds[1] + around
        nodes = np.ceil((high - low) / step).astype(int) + 1
        _require_size(tuple(nodes.tolist()), mesh.name, step)
        values, count = _sample(mesh, low, step, nodes, on_progress)
        inside = count * step**3
        if abs(inside - mesh.report.volume_m3) > _VOLUME * mesh.report.volume_m3:
            ratio = 100.0 * inside / mesh.report.volume_m3
            what = f"a grid of {1e3 * step:g} mm has {ratio:.0f} % of the mesh's volume"
            warnings.warn(
                PalpateWarning(
                    what, where=mesh.name, why="it is too coarse for thin parts", mend="use a finer spacing"
                ),
                stacklevel=2,
            )
        return cls(values, low, step, name=mesh.name)

    @classmethod
    def load(cls, path: str | os.PathLike[str], unit: Unit = "mm") -> DistanceGrid:
        """Read a grid: ``.npz`` as ``save`` writes it (metres), or a volume (``.nrrd``, ``.nii.gz``, ``.mha``).

        A volume lies in the frame LPS of the patient, as meshes from volumes do; its axes may be in any order.

        Args:
            path: the file.
            unit: unit of the lengths and distances of a volume whose header names none.

        Raises:
            SurfaceError: the file is missing, of another format, damaged, or holds no distances.
        """
        file = Path(path)
        if not file.is_file():
            raise SurfaceError("grid file not found", where=str(file), mend="check the path")
        if volume_files.is_volume(file):
            from palpate.world.surfaces import volume_grid

            return cls(*volume_grid.read(file, unit), name=file.stem)
        if file.suffix.lower() != ".npz":
            raise SurfaceError(
                f"{file.suffix or 'no ending'} is not a format of distance grids",
                where=str(file),
                mend="use .npz, .nrrd, .nii.gz or .mha",
            )
        try:
            data = limits.load_npz(file)
            return cls(data["distance"], data["origin"], data["spacing"], name=file.stem)
        except SurfaceError as error:
            raise SurfaceError(error.what, where=str(file), why=error.why, mend=error.mend) from None
        except KeyError as error:
            raise SurfaceError(
                f"array {error} is missing", where=str(file), mend="give distance, origin, spacing"
            ) from None
        except (
            EOFError,
            MemoryError,
            NotImplementedError,
            OSError,
            ValueError,
            zipfile.BadZipFile,
            zlib.error,
        ) as error:
            raise SurfaceError(
                "the grid cannot be read", where=str(file), why=str(error), mend="save it again"
            ) from None

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write ``distance`` (nx, ny, nz) float32, ``origin`` and ``spacing`` (3,), all in metres, as ``.npz``.

        The write is atomic: if it is interrupted, an existing file stays unchanged.
        """
        draft = Path(path).with_name(f".{Path(path).name}.{os.getpid()}")
        try:
            with draft.open("wb") as file:
                np.savez(file, distance=self.values, origin=self.origin, spacing=self.spacing)
            draft.replace(path)
        finally:
            draft.unlink(missing_ok=True)

    def __str__(self) -> str:
        """Number and spacing of the nodes."""
        nodes = " x ".join(f"{n}" for n in self.values.shape)
        steps = " x ".join(f"{1e3 * s:.3g}" for s in dict.fromkeys(self.spacing.tolist()))
        return f"distance grid, {nodes} nodes, {steps} mm apart"

    def _drawing(self) -> tuple[Array, Triangles]:
        highest = self.origin + self.spacing * (np.array(self.values.shape) - 1)
        return nets(self.core, self.origin, highest, float(self.spacing.min()))


@dataclass(frozen=True)
class GridError:
    """Error of a grid's distances against those of its mesh [m]: 99th percentiles and maxima."""

    near_p99: float
    """within two cells of the surface, 99th percentile"""
    near_worst: float
    box_p99: float
    """anywhere in the box of the grid, 99th percentile"""
    box_worst: float
    points: int
    """number of random sample points, half of them near the surface"""


def error_of(grid: DistanceGrid, mesh: Mesh, points: int = 40_000, seed: int = 0) -> GridError:
    """Compare a grid with the exact distance of its mesh at random points."""
    rng, half = np.random.default_rng(seed), points // 2
    corners = mesh.vertices[mesh.triangles[rng.integers(0, len(mesh.triangles), half)]]
    weights = rng.dirichlet(np.ones(3), half)[:, :, None]
    near = (weights * corners).sum(axis=1) + rng.uniform(-2.0, 2.0, (half, 3)) * grid.spacing
    box = rng.uniform(grid.origin, grid.origin + grid.spacing * (np.array(grid.values.shape) - 1), (half, 3))
    errors = [abs(grid.nearest(p)[0] - mesh.core.nearest(np.ascontiguousarray(p))[0]) for p in (near, box)]
    p99, worst = ([float(f(o)) for o in errors] for f in (lambda o: np.percentile(o, 99), np.max))
    return GridError(p99[0], worst[0], p99[1], worst[1], 2 * half)


def _sample(
    mesh: Mesh, low: Array, step: float, nodes: npt.NDArray[np.int_], on_progress: Callable[[int, int], None]
) -> tuple[npt.NDArray[np.float32], float]:
    """Distances at all nodes, and the number of cells inside; computed layer by layer on all cores."""
    values = np.empty(nodes, np.float32)

    def fill(i: int) -> float:
        layer = values[i : i + 1]
        _core.sample_distance(mesh.core, low + np.array([i * step, 0.0, 0.0]), np.full(3, step), layer)
        on_surface = np.abs(layer) < 1e-4 * step  # half of such a cell is inside: planes often lie on nodes
        return float(np.count_nonzero((layer < 0.0) & ~on_surface) + 0.5 * np.count_nonzero(on_surface))

    inside = 0.0
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for done, count in enumerate(pool.map(fill, range(len(values))), start=1):
            inside += count
            on_progress(done, len(values))
    return values, inside


def _require_size(nodes: tuple[int, ...], name: str, step: float | None = None) -> None:
    count = int(np.prod(nodes, dtype=np.int64))
    if count <= MAX_NODES:
        return
    size = " x ".join(f"{n:,}" for n in nodes)
    mend = "use a coarser grid"
    if step is not None:
        mend = f"use a spacing of {1e3 * step * (count / MAX_NODES) ** (1 / 3) * 1.05:.2g} mm or more"
    raise SurfaceError(f"{size} nodes are more than {MAX_NODES:,}", where=name, mend=mend)
