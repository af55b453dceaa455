"""`scan`: views of a depth camera become one surface."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import transform
from palpate.base.errors import CloudError
from palpate.world import mesh
from palpate.world.clouds import PointCloud
from palpate.world.clouds.neighbourhoods import sampling
from palpate.world.scan import agreement, alignment, field, surface, view, views

TRUSTED = 1.25
"""Largest distance of the points from the surface over their noise, both rms: 0.75 to 1.28 where the views are aligned,
1.2 to 3.2 where they are not."""
IN_FRONT = 0.03
"""Largest share of a view's points in front of what another view saw: at most 0.003 where the views are aligned, 0.025
beside the flying pixels and the grazing noise of a depth camera; more where they are not."""
_EXACT = 2e-5  # smaller distances are those of exact points [m]
_NEAR = 3.0  # points farther from the surface than this many cells belong to no surface: flying pixels


@dataclass(frozen=True)
class Scan:
    """Result of `scan`, in the frame of the first view's pose."""

    vertices: Array  #: (n, 3) [m]
    triangles: surface.Triangles  #: (m, 3), counter-clockwise seen from outside
    poses: tuple[Array, ...]  #: pose (4, 4) of every view [m]
    points: int  #: points in use
    outliers: int  #: points left out
    noise: float  #: standard deviation of the points along the normal, estimated from their neighbourhoods [m]
    rms: float  #: rms distance of the points in use from the surface [m]
    spacing: float  #: size of a cell of the reconstruction [m]
    closed: bool  #: True if the surface has no boundary
    holes: tuple[surface.Hole, ...]  #: places that no view shows, closed by membranes or open
    seconds: float  #: time of the computation [s]
    in_front: tuple[float, str, str]  #: largest share of a view's points in front of what another one saw; their names

    @property
    def doubt(self) -> str:
        """Why the surface is doubted, in words; empty if it is trusted."""
        share, one, other = self.in_front
        if share > IN_FRONT:
            words = f"{100 * share:.1f} % of the points of {one} lie in front of what {other} saw, {100 * IN_FRONT:g} %"
            return f"{words} at most where all views agree: at least one view is not aligned"
        ratio = self.rms / max(self.noise, 1e-12)
        if ratio <= TRUSTED or self.rms < _EXACT or len(self.poses) < 2:
            return ""
        words = f"the points lie {ratio:.2f} times their noise from the surface, {TRUSTED:g} at most"
        return f"{words} where all views agree: at least one view is not aligned"

    def mesh(self) -> mesh.Mesh:
        """The surface as a mesh, ready for contact."""
        with mesh.quiet():
            return mesh.Mesh(self.vertices, self.triangles, name="scan")


def scan(
    clouds: Sequence[PointCloud],
    poses: Sequence[npt.ArrayLike] | None = None,
    *,
    spacing: float | None = None,
    reach: float | None = None,
    close: bool | None = None,
    align: bool = True,
) -> Scan:
    """One surface from one or more views.

    Args:
        clouds: the views, each in the frame of its camera; without `viewpoint`, the camera is at the origin.
        poses: rough poses (4, 4) of the views [m]; default: every camera is near the one before.
        spacing: size of a cell [m]; details smaller than two cells are lost. Default: from noise and spacing.
        reach: largest error of the rough poses at the points [m]; default: a tenth of the first view's size.
        close: close holes by smooth membranes; default: if they are at most a fifth of the area.
        align: False: the poses are exact.

    Raises:
        CloudError: no cloud, too few points, or views that do not overlap.
        MissingExtraError: scikit-image, or small_gicp for several views, is not installed.
    """
    began = time.perf_counter()
    _check(clouds, poses, spacing)
    clean = [views.inliers(_seen(cloud)) for cloud in clouds]
    found_in = [sampling(p) for p in clean]
    noise, step = (float(np.median([getattr(one, key) for one in found_in])) for key in ("noise", "spacing"))
    size = float(np.linalg.norm(np.ptp(clean[0], axis=0)))
    seen = _views(clouds, clean, noise, step) if len(clouds) > 1 else []
    if align and seen:
        X = _aligned(seen, poses, reach or 0.1 * size)
    else:
        X = [np.asarray(pose, dtype=np.float64) for pose in poses or [np.eye(4)] * len(clouds)]
    points = np.concatenate([transform(pose, p) for pose, p in zip(X, clean, strict=True)])
    cell = spacing or max(2.5 * noise, 1.5 * sampling(points).spacing)
    cell = max(cell, float(np.prod(np.ptp(points, axis=0) + 8.0 * cell) / field.MOST_NODES) ** (1.0 / 3.0))
    to_sensor = np.concatenate([_directions(c, p) @ T[:3, :3].T for c, p, T in zip(clouds, clean, X, strict=True)])
    found = surface.extract(field.fuse(points, to_sensor, cell), close)
    with mesh.quiet():
        away = mesh.Mesh(found.vertices, found.triangles).closest(points, _NEAR * cell)[0]
    near = np.isfinite(away)
    return Scan(
        found.vertices, found.triangles, tuple(X), int(near.sum()), sum(map(len, clouds)) - int(near.sum()), noise,
        float(np.sqrt(np.square(away[near]).mean())), cell, found.closed, found.holes, time.perf_counter() - began,
        agreement.worst(seen, X),
    )  # fmt: skip


def _check(clouds: Sequence[PointCloud], poses: Sequence[npt.ArrayLike] | None, spacing: float | None) -> None:
    if not clouds:
        raise CloudError("no view is given", mend="give one cloud at least")
    for cloud in clouds:
        views.require(cloud)
    if poses is not None and len(poses) != len(clouds):
        raise CloudError(f"{len(poses)} poses for {len(clouds)} views", mend="give one pose for each view, in order")
    if spacing is not None and not 0.0 < spacing < 1.0:
        raise CloudError(f"a cell of {spacing:g} m", mend="give e.g. spacing=0.002, for 2 mm")


def _views(clouds: Sequence[PointCloud], clean: Sequence[Array], noise: float, step: float) -> list[view.View]:
    cell = max(1.5 * step, 2.0 * noise, step * (max(map(len, clean)) / view.MOST) ** 0.5)
    return [view.view(p, _sensor(c), noise, cell, c.name) for c, p in zip(clouds, clean, strict=True)]


def _aligned(seen: Sequence[view.View], poses: Sequence[npt.ArrayLike] | None, reach: float) -> list[Array]:
    if poses is None:
        return alignment.in_order(seen, reach)
    return alignment.jointly(seen, [np.asarray(pose, dtype=np.float64) for pose in poses], reach)


def _seen(cloud: PointCloud) -> Array:
    """Points (N, 3) that the camera measured.

    Raises:
        CloudError: too few.
    """
    points = views.measured(cloud.points, _sensor(cloud))
    if len(points) < views.LEAST:
        what = f"{len(points)} of {len(cloud)} points are measurements, the others mark pixels that saw nothing"
        raise CloudError(what, where=cloud.name, mend=f"a view needs {views.LEAST} points at least")
    return points


def _sensor(cloud: PointCloud) -> Array:
    """Position (3,) of the sensor in the frame of a cloud [m]."""
    return np.zeros(3) if cloud.viewpoint is None else cloud.viewpoint


def _directions(cloud: PointCloud, points: Array) -> Array:
    """Unit directions (N, 3) from points of a cloud to its sensor."""
    towards = _sensor(cloud) - points
    return np.asarray(towards / np.maximum(np.linalg.norm(towards, axis=1, keepdims=True), 1e-9))
