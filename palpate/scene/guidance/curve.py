"""Smooth curves through waypoints, as Bezier pieces for the core (core/palpate/guidance/geometry/path.hpp)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.errors import GuidanceError
from palpate.scene.guidance.sections import CROSSING

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline  # scipy takes seconds to import: import it only for scenes with a path

    from palpate import _guidance


#: Maximum turn of a piece, with which the core's arc lengths are accurate to 1e-9 [rad].
TURN = 0.2
_SAME = 1e-7  # waypoints closer than this are merged [m]
_LONGEST = 10.0  # a longer path is most likely given in another unit [m]
_MAX_PIECES = 200_000


def path(
    waypoints: npt.ArrayLike,
    rotations: npt.ArrayLike | None = None,
    *,
    closed: bool = False,
    crossing: float = CROSSING,
    name: str = "path",
) -> _guidance.PathGeometry:
    """The natural cubic spline through waypoints, parametrised by chord length: twice continuously differentiable.

    Args:
        waypoints: (n, 3), at least two distinct points; repeated points are dropped [m].
        rotations: (n, 3, 3) attitudes of the tool at the waypoints, for `orient`; when left out, the
            rotation-minimising frame of the tangent (Wang et al. 2008, double reflection).
        closed: the end joins the beginning smoothly.
        crossing: smallest distance allowed between two stretches of the path; 0 allows crossings [m].
        name: name of the path in messages.

    Raises:
        GuidanceError: the waypoints make no path, the path crosses itself, or its unit is most likely wrong.
    """
    from scipy.interpolate import CubicSpline

    from palpate import _guidance

    p, R = _distinct(waypoints, rotations, closed, name)
    knots = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))]
    if knots[-1] > _LONGEST:
        raise GuidanceError(
            f"the path is {knots[-1]:.4g} m long",
            where=name,
            why="waypoints are in metres here",
            mend="is the unit mm?",
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

        try:
            attitudes = RotationSpline(knots, Rotation.from_matrix(R))(u).as_matrix()
        except ValueError as error:  # rates of turn beyond all numbers
            why, mend = str(error), "space the places more evenly, or leave attitudes out"
            raise GuidanceError("no smooth turn passes through the attitudes", where=name, why=why, mend=mend) from None
    return _guidance.PathGeometry(np.ascontiguousarray(controls), np.ascontiguousarray(attitudes), R is None, closed)


def frames_along(places: Array, tangents: Array) -> Array:
    """Rotation-minimising frames (n, 3, 3) along ``places`` (n, 3) [m]; their z axes follow ``tangents`` (n, 3).

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
        least = 4  # three points, and the first one repeated
    if len(p) < least:
        least_text = "three or more apart" if closed else "two or more apart"
        raise GuidanceError(f"a path needs waypoints, {least_text}; {len(keep)} are given", where=name, mend="add some")
    return p, R


def _breaks(spline: CubicSpline, knots: Array, name: str) -> Array:
    """The knots, with values inserted between them so that no piece turns by more than TURN."""
    fraction = np.linspace(0.0, 1.0, 17)
    u = knots[:-1, None] + np.diff(knots)[:, None] * fraction  # (n, 17)
    d = spline(u, 1)
    speed = np.linalg.norm(d, axis=2)
    if speed.min() < 1e-3:  # speed: arc length per chord length
        at = knots[np.unravel_index(speed.argmin(), speed.shape)[0]]
        raise GuidanceError(
            f"the path turns on the spot {1e3 * at:.3g} mm from its start",
            where=name,
            mend="leave out a waypoint there",
        )
    d /= speed[..., None]
    turn = np.arctan2(np.linalg.norm(np.cross(d[:, 1:], d[:, :-1]), axis=2), (d[:, 1:] * d[:, :-1]).sum(axis=2))
    parts = np.ceil(16 * turn.max(axis=1) / TURN).clip(min=1).astype(int)
    if parts.sum() > _MAX_PIECES:
        raise GuidanceError(f"the path has too many bends: {parts.sum():,} pieces", where=name, mend="fewer waypoints")
    inner = [np.linspace(a, b, k, endpoint=False) for a, b, k in zip(knots[:-1], knots[1:], parts, strict=True)]
    return np.concatenate([*inner, knots[-1:]])


def _refuse_crossing(ends: Array, nearest: float, closed: bool, name: str) -> None:
    """Refuse two stretches closer than `nearest` that lie more than ten times as far apart along the path."""
    from scipy.spatial import cKDTree

    steps = np.maximum(np.ceil(np.linalg.norm(np.diff(ends, axis=0), axis=1) / nearest), 1).astype(int)
    if steps.sum() > _MAX_PIECES * 10:
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
            why="the nearest point of the path, and with it the force, would jump there",
            mend="split the path into two fixtures, or allow the crossing with crossing: 0",
        )
