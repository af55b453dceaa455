"""The views of a scan: markers of invalid pixels and outliers, which are removed, and what a view must have."""

from __future__ import annotations

from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import CloudError, MissingExtraError
from palpate.world.clouds import PointCloud

LEAST = 200
"""Smallest number of points of a view."""
_NEIGHBOURS = 8
_FAR = 3.0  # outliers: deviations of the mean distance to the neighbours from its median, in robust deviations


_SENSOR = 0.02  # a camera sees nothing nearer than this to itself [share of the median range]
_REPEATED = 20  # points at one place that are a marker of invalid pixels, not measurements


def measured(points: Array, sensor: Array) -> Array:
    """Points (N, 3) without markers of pixels that saw nothing: at the camera, and many at exactly one place.

    Cameras write (0, 0, 0), or another constant such as a largest range, where they measured nothing.

    Args:
        points: (N, 3) [m].
        sensor: (3,) position of the camera [m].
    """
    away = np.linalg.norm(points - sensor, axis=1)
    good = away > 0.0
    if good.any():
        good &= away > _SENSOR * np.median(away[good])
    _, place, count = np.unique(points, axis=0, return_inverse=True, return_counts=True)
    return np.asarray(points[good & (count[place.reshape(-1)] < _REPEATED)])


def inliers(points: Array) -> Array:
    """Points (N, 3) without isolated ones, whose mean distance to their 8 neighbours is unusually large.

    R. B. Rusu et al., "Towards 3D point cloud based object maps for household environments", Robotics and Autonomous
    Systems 56, 2008, section 4.1; with the median and its absolute deviation instead of mean and standard deviation,
    and distances relative to the range, because the points of a camera spread with it.
    """
    from scipy.spatial import cKDTree

    distances, _ = cKDTree(points).query(points, k=_NEIGHBOURS + 1)
    away = distances[:, 1:].mean(axis=1)
    middle = np.median(away)
    deviation = 1.4826 * np.median(np.abs(away - middle))
    return np.asarray(points[away < middle + max(_FAR * deviation, middle)])


def require(view: PointCloud) -> None:
    """Refuse a view that has no surface.

    Raises:
        CloudError: too few points, or points that lie on a line or in one place.
    """
    if len(view) < LEAST:
        what, mend = f"{len(view)} points are too few for a view", f"a view needs {LEAST} points at least"
        raise CloudError(what, where=view.name, mend=mend)
    sizes = np.linalg.svd(view.points - view.points.mean(axis=0), compute_uv=False)
    if not sizes[1] > 1e-3 * sizes[0]:
        what = "all points lie in one place" if sizes[0] == 0.0 else "all points lie on one line"
        raise CloudError(what, where=view.name, mend="give a view of a surface")


def small_gicp() -> Any:
    """The library small_gicp.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        import small_gicp as library
    except ModuleNotFoundError as missing:
        raise MissingExtraError("small_gicp, which aligns the views,", "registration") from missing
    return library
