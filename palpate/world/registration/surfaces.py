"""Registration of a partial cloud with a surface, from a rough pose or none: `surface`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import rigid, transform
from palpate.base.errors import MissingExtraError, RegistrationError
from palpate.world.registration import checks, icp, predict, trust
from palpate.world.registration.clouds import Cloud
from palpate.world.registration.fit import Indices

_COARSE, _MIDDLE, _FINE = 150, 400, 4000  # points of the moving cloud in the three stages
_NEAR = 64  # starts around a rough pose
_KEPT = 10  # minima that are followed into the second stage
_LAST = 10  # robust steps at the end
_APART = 3.0  # poses closer than this many noises of a point are one minimum


@dataclass(frozen=True)
class SurfaceRegistration:
    """Result of `surface`."""

    X: Array  #: pose (4, 4) of the moving frame in the fixed frame: fixed = X moving
    fre: float  #: rms distance of the explained points from the surface, along its normal [m]
    fle: float  #: noise of both clouds along the normal, estimated from their neighbourhoods or stated [m]
    tre: Array  #: (K,) predicted rms error at each target [m]
    covariance: Array  #: (6, 6) of the displacement of X (NOTATION.md)
    explained: float  #: share of the moving points within three standard deviations of the surface
    outliers: Indices  #: indices of the other points
    trusted: bool  #: False if the answer must be taken as wrong
    doubts: tuple[str, ...]  #: why it is not trusted
    targets: tuple[predict.Target, ...]
    rival: Array | None  #: second best pose (4, 4), if another minimum was found
    rival_ratio: float  #: its cost over the best cost; infinity without a rival


def surface(
    moving: npt.ArrayLike,
    fixed: npt.ArrayLike,
    start: npt.ArrayLike | None = None,
    targets: npt.ArrayLike | None = None,
    *,
    noise: float | None = None,
    overlap: float = 0.85,
    angle: float = np.radians(35.0),
    reach: float = 0.035,
) -> SurfaceRegistration:
    """The pose that lays a partial cloud onto a surface, and whether it can be trusted.

    Many starts are refined at once by robust point-to-plane steps on few points; the best distinct minima are refined
    with more points, and the best of these by small_gicp, by robust steps that leave the outliers out, and by least
    squares of the explained points, at most 4000 of the cloud's. The covariance is that of these points.

    Args:
        moving: cloud (N, 3) [m].
        fixed: dense points (M, 3) of the surface [m] (`clouds.sampled` makes them from a mesh).
        start: rough pose (4, 4), wrong by at most `angle` [rad] and `reach` [m] at the cloud's centroid. Default: none;
            starts all over the surface are tried.
        targets: points (K, 3) in the moving frame where the error is predicted [m].
        noise: standard deviation of the distances along the normal [m]. Default: estimated.
        overlap: share of the moving points that must lie on the surface in a trusted answer.
        angle: largest angle of the start's error [rad].
        reach: largest position error of the start [m].

    Raises:
        RegistrationError: too few points, other units, a start that is not rigid.
        MissingExtraError: small_gicp is not installed.
    """
    m = Cloud(checks.cloud("moving", moving, least=50))
    f = _prepared(checks.cloud("fixed", fixed, least=50).tobytes())
    checks.units(m.points, f.points)
    goals = np.zeros((0, 3)) if targets is None else checks.cloud("targets", targets, least=1)
    sigma = float(np.hypot(m.noise, f.noise)) if noise is None else noise
    if not sigma > 0.0:
        raise RegistrationError(f"the noise is {sigma!r} m", mend="state a positive --noise [m]")
    floor = float(np.hypot(sigma, f.spacing))
    if start is None:
        starts = icp.starts_anywhere(m, f)
    else:
        X0 = checks.poses("start", np.asarray(start, dtype=np.float64)[None], least=1)[0]
        starts = icp.starts_near(X0, m.points, angle, reach, _NEAR)
    X, cost, order = _minima(starts, m, f, floor)
    best = _refined(X[order[0]], m, f, 4.0 * floor)
    best = icp.iterate(best[None], m.thinned(_FINE), f, sigma, _LAST)[0][0]  # outliers pull small_gicp's answer
    best = icp.least_squares(best, m.thinned(_FINE), f, sigma, _LAST)
    verdict = trust.judge(best, m, f, sigma, overlap, _FINE)
    ratio, rival = np.inf, None
    if len(order) > 1:
        rival = X[order[1]]
        ratio = float(cost[order[1]] / icp.costs(best[None], m.thinned(_FINE), f, floor)[0])
    doubts = (*verdict.doubts, *trust.doubts_of_rival(ratio))
    found = tuple(predict.target(best, verdict.covariance, p) for p in goals)
    return SurfaceRegistration(
        X=best, fre=verdict.rms, fle=sigma, tre=np.array([one.tre for one in found]), covariance=verdict.covariance,
        explained=verdict.explained, outliers=verdict.outliers, trusted=not doubts, doubts=doubts, targets=found,
        rival=rival, rival_ratio=ratio,
    )  # fmt: skip


@lru_cache(maxsize=2)
def _prepared(points: bytes) -> Cloud:
    """The cloud of these coordinates [m]: clouds come one after the other, and the surface stays.

    The normals and trees of 40,000 points take as long as the registration.
    """
    return Cloud(np.frombuffer(points).reshape(-1, 3))


def _minima(starts: Array, m: Cloud, f: Cloud, floor: float) -> tuple[Array, Array, list[int]]:
    """Poses of the distinct minima, their costs over the whole cloud [m^2], and their order."""
    few, more, many = (m.thinned(n) for n in (_COARSE, _MIDDLE, _FINE))
    if len(starts) > _NEAR:
        starts, cost = icp.iterate(starts, few[::2], f.sparse(1500), 4.0 * floor, 4)
        starts = starts[np.argsort(cost)[:_NEAR]]
    X, cost = icp.iterate(starts, few, f.sparse(5000), 2.0 * floor, 12)
    keep = icp.distinct(X, cost, few, 2.0 * _APART * floor)[:_KEPT]
    X, _ = icp.iterate(X[keep], more, f, floor, 15)
    cost = icp.costs(X, many, f, floor)
    return X, cost, icp.distinct(X, cost, many, _APART * floor)


def _refined(X: Array, m: Cloud, f: Cloud, gate: float) -> Array:
    """The pose after small_gicp's point-to-plane registration with all points."""
    gicp = _small_gicp()
    target, tree = f.for_small_gicp
    found = gicp.align(
        target, gicp.PointCloud(m.thinned(_FINE)), tree, X, registration_type="PLANE_ICP",
        max_correspondence_distance=gate, max_iterations=50, rotation_epsilon=1e-6, translation_epsilon=1e-7,
    )  # fmt: skip
    T = np.asarray(found.T_target_source, dtype=np.float64)
    return rigid(T[:3, :3], transform(T, np.zeros((1, 3)))[0])


def require() -> None:
    """Check that the library for the registration of surfaces is installed.

    Raises:
        MissingExtraError: it is not.
    """
    _small_gicp()


def _small_gicp() -> Any:
    try:
        import small_gicp
    except ModuleNotFoundError as missing:
        raise MissingExtraError("small_gicp, which refines the registration of surfaces,", "registration") from missing
    return small_gicp
