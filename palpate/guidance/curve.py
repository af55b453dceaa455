"""Smooth curves through waypoints, in the pieces that the core wants (core/palpate/guidance/geometry/path.hpp)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.arrays import Array
from palpate.errors import GuidanceError

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline  # scipy takes seconds to import: only scenes that have a path wait for it


#: Most that a piece turns: the core's arc lengths are exact to 1e-9 then [rad].
TURN = 0.2
#: A path that comes nearer to itself than this crosses itself [m].
CROSSING = 2e-4
_SAME = 1e-7  # waypoints nearer than this are one [m]
_LONGEST = 10.0  # a path longer than this is most likely in another unit [m]
_MOST = 200_000  # pieces


def path(
    waypoints: npt.ArrayLike,
    rotations: npt.ArrayLike | None = None,
    *,
    closed: bool = False,
    crossing: float = CROSSING,
    name: str = "path",
) -> _core.PathGeometry:
    """The natural cubic spline through waypoints over their chord lengths: twice continuously differentiable.

    Args:
        waypoints: (n, 3), two or more apart; repeats are dropped [m].
        rotations: (n, 3, 3) of the tool at the waypoints, for `orient`; the tangent's own frame when left out, turned
            about it no more than it must be (Wang et al. 2008, double reflection).
        closed: the end goes smoothly over into the beginning.
        crossing: nearest that it may come to another stretch of itself; 0 allows what comes [m].
        name: how messages call it.

    Raises:
        GuidanceError: no path, one that crosses itself, or most likely one in another unit.
    """
    from scipy.interpolate import CubicSpline

    p, R = _distinct(waypoints, rotations, closed, name)
    knots = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))]
    if knots[-1] > _LONGEST:
        raise GuidanceError(
            f"the path is {knots[-1]:.4g} m long", where=name, why="waypoints are metres here", mend="unit: mm?"
        )
    spline = CubicSpline(knots, p, bc_type="periodic" if closed else "natural" if len(p) > 2 else "not-a-knot")
    u = _breaks(spline, knots, name)
    ends, slopes, h = spline(u), spline(u, 1), np.diff(u)[:, None] / 3.0
    controls = np.stack([ends[:-1], ends[:-1] + h * slopes[:-1], ends[1:] - h * slopes[1:], ends[1:]], axis=1)
    if crossing > 0.0:
        _refuse_crossing(ends, crossing, closed, name)
    if R is None:
        attitudes = frames_along(ends, slopes)
    else:
        from scipy.spatial.transform import Rotation, RotationSpline

        attitudes = RotationSpline(knots, Rotation.from_matrix(R))(u).as_matrix()
    return _core.PathGeometry(np.ascontiguousarray(controls), np.ascontiguousarray(attitudes), R is None, closed)


def frames_along(places: Array, tangents: Array) -> Array:
    """(n, 3, 3) rotations with z along ``tangents`` (n, 3), turning about them as little as can be.

    By double reflection (Wang, Juettler, Zheng and Liu, Computation of rotation minimizing frames, 2008).
    """
    z = tangents / np.linalg.norm(tangents, axis=1, keepdims=True)
    x = np.empty_like(z)
    start = np.eye(3)[np.argmin(abs(z[0]))]
    x[0] = start - (start @ z[0]) * z[0]
    for i in range(len(z) - 1):
        v = places[i + 1] - places[i]
        mirrored = x[i] - 2.0 / (v @ v) * (v @ x[i]) * v
        turned = z[i] - 2.0 / (v @ v) * (v @ z[i]) * v
        w = z[i + 1] - turned
        x[i + 1] = mirrored - 2.0 / (w @ w) * (w @ mirrored) * w if w @ w > 0.0 else mirrored
        x[i + 1] -= (x[i + 1] @ z[i + 1]) * z[i + 1]
        x[i + 1] /= np.linalg.norm(x[i + 1])
    x[0] /= np.linalg.norm(x[0])
    return np.stack([x, np.cross(z, x), z], axis=2)


def _distinct(
    waypoints: npt.ArrayLike, rotations: npt.ArrayLike | None, closed: bool, name: str
) -> tuple[Array, Array | None]:
    p = np.asarray(waypoints, dtype=np.float64)
    if p.ndim != 2 or p.shape[1] != 3 or not np.isfinite(p).all():
        raise GuidanceError(
            f"waypoints must be finite, of shape (n, 3). Got: {np.shape(waypoints)}", where=name, mend="x, y, z a row"
        )
    R = None if rotations is None else np.asarray(rotations, dtype=np.float64)
    if R is not None and R.shape != (len(p), 3, 3):
        raise GuidanceError(f"rotations must have shape ({len(p)}, 3, 3). Got: {R.shape}", where=name)
    keep = np.r_[True, np.linalg.norm(np.diff(p, axis=0), axis=1) > _SAME]
    p, R = p[keep], None if R is None else R[keep]
    least = 2
    if closed:
        if len(p) and np.linalg.norm(p[-1] - p[0]) > _SAME:
            p, R = np.r_[p, p[:1]], None if R is None else np.r_[R, R[:1]]
        else:
            p = np.r_[p[:-1], p[:1]]
        least = 4  # three, and the first again
    if len(p) < least:
        told = "three or more apart" if closed else "two or more apart"
        raise GuidanceError(f"a path needs waypoints, {told}; {len(keep)} are given", where=name, mend="add some")
    return p, R


def _breaks(spline: CubicSpline, knots: Array, name: str) -> Array:
    """The knots, and as many values between that no piece turns by more than TURN."""
    share = np.linspace(0.0, 1.0, 17)
    u = knots[:-1, None] + np.diff(knots)[:, None] * share  # (n, 17)
    d = spline(u, 1)
    speed = np.linalg.norm(d, axis=2)
    if speed.min() < 1e-3:  # of arc length per chord length
        at = knots[np.unravel_index(speed.argmin(), speed.shape)[0]]
        raise GuidanceError(
            f"the path turns on the spot {1e3 * at:.3g} mm from its start",
            where=name,
            mend="leave a waypoint out there",
        )
    d /= speed[..., None]
    turn = np.arctan2(np.linalg.norm(np.cross(d[:, 1:], d[:, :-1]), axis=2), (d[:, 1:] * d[:, :-1]).sum(axis=2))
    parts = np.ceil(16 * turn.max(axis=1) / TURN).clip(min=1).astype(int)
    if parts.sum() > _MOST:
        raise GuidanceError(f"the path is too winding: {parts.sum():,} pieces", where=name, mend="fewer waypoints")
    inner = [np.linspace(a, b, k, endpoint=False) for a, b, k in zip(knots[:-1], knots[1:], parts, strict=True)]
    return np.concatenate([*inner, knots[-1:]])


def _refuse_crossing(ends: Array, nearest: float, closed: bool, name: str) -> None:
    """Stretches that lie ten times as far apart along the path as `nearest` may not come as near as that."""
    from scipy.spatial import cKDTree

    steps = np.maximum(np.ceil(np.linalg.norm(np.diff(ends, axis=0), axis=1) / nearest), 1).astype(int)
    if steps.sum() > _MOST * 10:
        return
    pieces = [np.linspace(a, b, k, endpoint=False) for a, b, k in zip(ends[:-1], ends[1:], steps, strict=True)]
    samples = np.concatenate([*pieces, ends[-1:]])
    along = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(samples, axis=0), axis=1))]
    pairs = cKDTree(samples).query_pairs(nearest, output_type="ndarray")
    apart = abs(along[pairs[:, 1]] - along[pairs[:, 0]])
    if closed:
        apart = np.minimum(apart, along[-1] - apart)
    crossing = pairs[apart > 10.0 * nearest]
    if len(crossing):
        first, second = np.sort(along[crossing[0]])
        at = ", ".join(f"{1e3 * x:.4g}" for x in samples[crossing[0][0]])
        raise GuidanceError(
            f"the path crosses itself at ({at}) mm, {1e3 * first:.3g} and {1e3 * second:.3g} mm from its start",
            where=name,
            why="there the nearest place of the path, and with it the force, would jump",
            mend="split it into two fixtures, or crossing: 0 to allow it",
        )
