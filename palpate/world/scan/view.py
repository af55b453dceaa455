"""One view of the scan, averaged over cells: what alignment and agreement compare."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.world.scan.views import small_gicp

MOST = 4000
"""Points of a view after averaging, about."""
_FEW = 300  # points of a view in a coarse alignment


@dataclass(frozen=True)
class View:
    """Averaged points of one view, in its own frame."""

    points: Array  #: (N, 3) [m]
    normals: Array  #: (N, 3) unit normals towards the sensor
    sensor: Array  #: (3,) position of the sensor [m]
    tree: Any  #: search tree of the points (scipy's cKDTree)
    rays: Any  #: search tree of the unit directions from the sensor to the points
    range: float  #: median distance of the points from the sensor [m]
    noise: float  #: standard deviation of the points across the surface, before averaging [m]
    cell: float  #: size of the cells [m]
    prepared: Any  #: the points for small_gicp: cloud and tree
    few: Any  #: some of them: cloud
    name: str


def view(points: Array, sensor: Array, noise: float, cell: float, name: str) -> View:
    """A view of points (N, 3) [m], averaged over cells [m], with normals towards the sensor at (3,) [m]."""
    from scipy.spatial import cKDTree

    library = small_gicp()
    cloud, tree = library.preprocess_points(points, downsampling_resolution=cell, num_neighbors=20)
    p, n = np.asarray(cloud.points())[:, :3].copy(), np.asarray(cloud.normals())[:, :3].copy()
    n *= np.where(np.einsum("ni,ni->n", n, sensor - p) < 0.0, -1.0, 1.0)[:, None]
    r = np.linalg.norm(p - sensor, axis=1)
    some = p[np.random.default_rng(0).permutation(len(p))[:_FEW]]
    few, _ = library.preprocess_points(some, downsampling_resolution=1e-3 * cell, num_neighbors=10)
    rays = cKDTree((p - sensor) / r[:, None])
    return View(p, n, sensor, cKDTree(p), rays, float(np.median(r)), noise, cell, (cloud, tree), few, name)
