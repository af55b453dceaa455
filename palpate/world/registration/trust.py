"""Whether a registration of surfaces can be trusted: what a wrong answer does to the residuals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import point_jacobian, transform
from palpate.world.registration import icp
from palpate.world.registration.clouds import Cloud
from palpate.world.registration.fit import Indices

LARGEST_SCALE = 1.35  # spread of the residuals over the noise of the clouds
LARGEST_PATCH = 2.0  # rms of patch means over their standard deviation, which is 1 in a right answer
LARGEST_ERROR = 3.0  # predicted rms error of the cloud's points over the noise
SMALLEST_RIVAL = 1.15  # cost of the second best minimum over the best
_NEAREST = (
    2.5  # factor of the surface's own variance: the nearest of noisy points is one whose error shortens residuals
)
_PATCH = 30  # points of a patch


@dataclass(frozen=True)
class Verdict:
    """Residuals of an answer, and why it is doubted."""

    rms: float  #: of the explained points, along the normal [m]
    explained: float  #: share of points within three standard deviations
    outliers: Indices  #: indices of the others
    covariance: Array  #: (6, 6)
    scale: float  #: robust spread of the residuals over the noise
    patches: float  #: rms of patch means over their standard deviation
    error: float  #: predicted rms error of the cloud's points [m]
    doubts: tuple[str, ...]


def judge(X: Array, m: Cloud, f: Cloud, sigma: float, overlap: float, used: int) -> Verdict:
    """Residuals of the pose X (4, 4) for clouds whose distances have the standard deviation `sigma` [m].

    A wrong answer leaves points unexplained, larger residuals than the noise of the clouds, or residuals that agree
    within patches of neighbours; or the surface lets the cloud slide. `used` points of the cloud were fitted.
    """
    found = icp.residuals(X, m.points, f, sigma)
    good = found.explained
    rows = m.rows(used)
    rows = rows[good[rows]]
    patches = _patches(m.points[good], found.r[good] / sigma, _PATCH)
    C = _covariance(found, rows, m, f, sigma)
    some = transform(X, m.points[good])[:: max(1, int(good.sum()) // 50)] - X[:3, 3]
    error = float(np.sqrt(np.mean([np.trace(K @ C @ K.T) for K in map(point_jacobian, some)]))) if len(some) else np.inf
    near = found.r[found.distance < 6.0 * sigma + 2.0 * f.spacing]
    scale = float(1.4826 * np.median(np.abs(near)) / sigma) if len(near) else np.inf
    explained = float(good.mean())
    return Verdict(
        rms=float(np.sqrt(np.square(found.r[good]).mean())) if good.any() else float("inf"), explained=explained,
        outliers=np.flatnonzero(~good), covariance=C, scale=scale, patches=patches, error=error,
        doubts=_doubts(explained, overlap, scale, patches, error, sigma),
    )  # fmt: skip


def _covariance(found: icp.Residuals, rows: Indices, m: Cloud, f: Cloud, sigma: float) -> Array:
    """Covariance (6, 6) of the least-squares pose from the fitted rows.

    Points with the same nearest point of the surface share its error; neighbours whose residuals agree count less.
    """
    J = found.J[rows]
    H = np.linalg.pinv(J.T @ J)
    _, group = np.unique(found.nearest[rows], return_inverse=True)
    sums = np.zeros((int(group.max(initial=-1)) + 1, 6))
    np.add.at(sums, group, J)
    fixed = sigma**2 * f.noise**2 / max(f.noise**2 + m.noise**2, 1e-300)  # the part of the surface's own noise
    C = H @ ((sigma**2 - fixed) * (J.T @ J) + _NEAREST * fixed * (sums.T @ sums)) @ H
    z = found.r[rows] / sigma
    shared = max([1.0, *(_patches(m.points[rows], z, size) for size in (_PATCH, 4 * _PATCH) if len(z) > 9 * size)])
    return np.asarray(shared**2 * C)


def _patches(points: Array, z: Array, size: int) -> float:
    """Rms of the means of residuals z (N,) over patches of neighbours, times the root of the patch size."""
    if len(points) < 3 * size:
        return float("inf")
    means = np.array([z[part].mean() * np.sqrt(len(part)) for part in _halved(points, np.arange(len(points)), size)])
    return float(np.sqrt(np.square(means).mean()))


def _halved(points: Array, rows: Indices, size: int) -> list[Indices]:
    """Patches of neighbours: the rows halved along their longest axis until they are small."""
    if len(rows) < 2 * size:
        return [rows]
    axis = int(np.argmax(np.ptp(points[rows], axis=0)))
    order = rows[np.argsort(points[rows, axis])]
    return _halved(points, order[: len(order) // 2], size) + _halved(points, order[len(order) // 2 :], size)


def _doubts(
    explained: float, overlap: float, scale: float, patches: float, error: float, sigma: float
) -> tuple[str, ...]:
    found = []
    if explained < overlap:
        found.append(f"{100 * explained:.0f} % of the points lie on the surface, {100 * overlap:.0f} % are expected")
    if scale > LARGEST_SCALE:
        found.append(f"the residuals are {scale:.2g} times as large as the noise of the clouds")
    if patches > LARGEST_PATCH:
        found.append(f"neighbouring residuals agree: patch means are {patches:.2g} times what the noise explains")
    if error > LARGEST_ERROR * sigma:
        found.append(f"the cloud can slide along the surface: its points are uncertain by {1e3 * error:.1f} mm rms")
    return tuple(found)


def doubts_of_rival(ratio: float) -> tuple[str, ...]:
    """The doubt that a second minimum of nearly the same cost causes."""
    if ratio < SMALLEST_RIVAL:
        return (f"another pose fits almost as well: its cost is {ratio:.2f} times the best",)
    return ()
