"""Checks of fiducials before they are registered. Each error names the value, its likely cause and the correction."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import fault, transform
from palpate.base.errors import RegistrationError
from palpate.world.registration.fit import closed_form

LARGEST = 10.0  # largest distance between fiducials that is believed to be in metres [m]
_CLOSEST = 1e-6  # closer fiducials are one marker entered twice [m]
_COLLINEAR = 1e-3  # spread across a line relative to the spread along it
NO_FIT = 0.01
"""Rms error of a measured place above which nothing was measured [m]."""
_MIRRORED = 0.2  # residual of the mirrored fit relative to that of the rigid one


def cloud(name: str, points: npt.ArrayLike, least: int = 3) -> Array:
    """The points as an array (N, 3).

    Raises:
        RegistrationError: not finite, not (N, 3), or fewer than `least`.
    """
    found = np.asarray(points, dtype=np.float64)
    if found.ndim != 2 or found.shape[1] != 3:
        raise RegistrationError(
            f"{name} has the shape {found.shape}", mend="give one row of x, y, z per point: an array (N, 3)"
        )
    bad = np.flatnonzero(~np.isfinite(found).all(axis=1))
    if len(bad):
        raise RegistrationError(
            f"{name}: point {bad[0]} is {found[bad[0]].tolist()}", mend="remove points that were not measured"
        )
    if len(found) < least:
        raise RegistrationError(
            f"{name} has {len(found)} points", why=f"a pose needs at least {least}", mend="measure more points"
        )
    return found


def layout(name: str, points: Array, names: Sequence[str]) -> None:
    """Check that fiducials determine a pose.

    Raises:
        RegistrationError: duplicated or collinear points, or distances that are not in metres.
    """
    for i, j in itertools.combinations(range(len(points)), 2):
        if np.linalg.norm(points[i] - points[j]) < _CLOSEST:
            raise RegistrationError(
                f"{name}: the markers {names[i]!r} and {names[j]!r} are at the same place {points[i].tolist()}",
                why="one marker was entered twice",
                mend="remove one row, or measure the other marker",
            )
    spread = float(np.linalg.norm(np.ptp(points, axis=0)))
    if spread > LARGEST:
        raise RegistrationError(
            f"{name} extends over {spread:.4g} m", why="the values look like millimetres", mend="divide by 1000"
        )
    s = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if s[1] < _COLLINEAR * s[0]:
        raise RegistrationError(
            f"{name}: the {len(points)} points lie on one line",
            why="the rotation about that line is not determined",
            mend="add a point far from the line",
        )


def extent(points: Array) -> float:
    """Rms distance of points (N, 3) from their mean [m]."""
    return float(np.sqrt(np.square(points - points.mean(axis=0)).sum(axis=1).mean()))


def units(moving: Array, fixed: Array) -> None:
    """Check that the extents of both sets are of one order of magnitude; some points may be missing in either.

    Raises:
        RegistrationError: one set is in millimetres.
    """
    extents = extent(moving), extent(fixed)
    if min(extents) > 0.0 and not 0.002 < extents[1] / extents[0] < 500.0:
        unit_ratio(extents[1] / extents[0])


def unit_ratio(ratio: float) -> None:
    """Check the ratio of distances, fixed over moving.

    Raises:
        RegistrationError: one of them is in millimetres, or the sets are of different size.
    """
    for factor, small, large in ((ratio, "moving", "fixed"), (1.0 / ratio, "fixed", "moving")):
        if 500.0 < factor < 2000.0:
            raise RegistrationError(
                f"distances between the {large} points are {factor:.4g} times those between the {small} points",
                why=f"a ratio near 1000: the {large} points are in millimetres and the {small} points in metres",
                mend=f"divide the {large} points by 1000",
            )
        if factor > 1.5:
            raise RegistrationError(
                f"distances between the {large} points are {factor:.4g} times those between the {small} points",
                why="other units, other markers, or another order of the rows",
                mend="bring both to metres; give correspond=False (--unknown) if the order is not known",
            )


def same_markers(moving: Array, fixed: Array) -> None:
    """Check that corresponding points (N, 3) differ by a rigid motion in kind: same unit, same handedness.

    Raises:
        RegistrationError: the ratio of distances is not 1, or the sets are mirror images.
    """
    pairs = np.triu_indices(len(moving), 1)
    lengths = [np.linalg.norm(p[pairs[0]] - p[pairs[1]], axis=1) for p in (moving, fixed)]
    unit_ratio(float(np.median(lengths[1] / lengths[0])))
    rigid, mirrored = (fit_rms(moving * flip, fixed) for flip in (1.0, np.array([1.0, 1.0, -1.0])))
    if mirrored < _MIRRORED * rigid or _worse(rigid, mirrored, 3 * len(moving) - 6):
        raise mirror_error(rigid, mirrored)


def _worse(rms: float, other: float, freedom: int) -> bool:
    """True if a residual is larger than another by more than chance explains (F test at 0.1 %)."""
    from scipy.special import fdtrc

    return other > 0.0 and bool(fdtrc(freedom, freedom, (rms / other) ** 2) < 1e-3)


def require_fit(name: str, fle: float, spread: float, mend: str) -> None:
    """Check that something explains the measurements.

    Args:
        name: of the measurements, in the message.
        fle: error of one measured place that the fit leaves, rms [m].
        spread: rms distance of the measured places from their mean [m].
        mend: remedy, in the message.

    Raises:
        RegistrationError: the fit leaves centimetres, or a fifth of the motion and millimetres.
    """
    if fle > NO_FIT or (fle > 0.2 * NO_FIT and fle > 0.2 * spread):
        raise RegistrationError(
            f"{name} contradict each other: the best answer leaves {1e3 * fle:.3g} mm rms",
            why=f"a tracked place is right within a millimetre or two, and these move by {1e3 * spread:.3g} mm rms",
            mend=mend,
        )


def mirror_error(rigid: float, mirrored: float) -> RegistrationError:
    """The error for sets that fit only as mirror images; rms residuals of both fits [m]."""
    return RegistrationError(
        f"the fixed points are a mirror image of the moving points: rms residual {1e3 * rigid:.3g} mm as they are, "
        f"{1e3 * mirrored:.3g} mm mirrored",
        why="two swapped columns, one axis with the opposite sign, or a left-handed frame",
        mend="correct the order and signs of the columns",
    )


def fit_rms(moving: Array, fixed: Array) -> float:
    """Rms residual of the closed-form fit [m]."""
    return float(np.sqrt(np.square(fixed - transform(closed_form(moving, fixed), moving)).sum(axis=1).mean()))


def poses(name: str, X: npt.ArrayLike, least: int = 3) -> Array:
    """The poses as an array (N, 4, 4).

    Raises:
        RegistrationError: another shape, fewer than `least`, or matrices that are not rigid and right-handed.
    """
    found = np.asarray(X, dtype=np.float64)
    if found.ndim != 3 or found.shape[1:] != (4, 4):
        raise RegistrationError(f"{name} has the shape {found.shape}", mend="give poses as an array (N, 4, 4)")
    if len(found) < least:
        raise RegistrationError(
            f"{name} has {len(found)} poses", why=f"at least {least} are needed", mend="measure more poses"
        )
    for i, one in enumerate(found):
        wrong = fault(one)
        if wrong is not None:
            raise RegistrationError(f"{name}: pose {i} {wrong.what}", why=wrong.why, mend=wrong.mend)
    return found
