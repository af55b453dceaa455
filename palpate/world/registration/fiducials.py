"""Registration of fiducials: `points`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import transform
from palpate.base.errors import RegistrationError
from palpate.world.registration import checks, isotropy, matching, order, outliers, predict
from palpate.world.registration.fit import Indices, jacobians
from palpate.world.registration.noise import CONFIDENCE, covariances, student_factor
from palpate.world.registration.outliers import Matched

_IMPLAUSIBLE = 0.01  # probability below which the residuals contradict the stated localisation error
_OTHER_SIZE = 0.01  # probability below which the two sets have different sizes
_FLAT = 0.01  # probability above which the mirror image of the points fits, too


@dataclass(frozen=True)
class PointRegistration:
    """Result of `points`."""

    X: Array  #: pose (4, 4) of the moving frame in the fixed frame: fixed = X moving
    fre: float  #: rms residual of the fiducials used [m]
    fle: float  #: rms localisation error of both sets together, stated or estimated from the residuals [m]
    tre: Array  #: (K,) predicted rms error at each target [m]
    tre_95: Array  #: (K,) upper 95 % bound of the true rms error [m]; `tre` if the FLE is stated
    covariance: Array  #: (6, 6) of the displacement [dp; dtheta] of X in the fixed frame (NOTATION.md)
    size: float  #: size of the fixed set over that of the moving set; 1 for the same markers
    size_deviation: float  #: standard deviation of `size`
    outliers: tuple[int, ...]  #: moving points excluded as wrong markers
    correspondence: Indices  #: (N,) index of the fixed point of each moving point, -1 if it has none
    residuals: Array  #: (N,) distance of each moving point from its partner [m], NaN if it has none
    leave_one_out: Array  #: (N,) distance of each point from where the other points used predict it [m]
    targets: tuple[predict.Target, ...]  #: ellipsoid and direction of the error at each target
    addition: predict.Addition | None  #: where one more fiducial lowers the largest error most
    estimated: bool  #: True if the localisation error was estimated from the residuals
    warnings: tuple[str, ...]


def points(
    moving: npt.ArrayLike,
    fixed: npt.ArrayLike,
    targets: npt.ArrayLike | None = None,
    correspond: bool = True,
    *,
    fle: npt.ArrayLike | None = None,
    fle_moving: npt.ArrayLike | None = None,
    names: Sequence[str] | None = None,
    candidates: npt.ArrayLike | None = None,
) -> PointRegistration:
    """The pose that maps fiducials onto fiducials, with the error that it predicts at targets.

    Args:
        moving: fiducials (N, 3) in the moving frame [m].
        fixed: the same fiducials (M, 3) in the fixed frame [m]; M = N if they correspond.
        targets: points (K, 3) in the moving frame where the error is predicted [m].
        correspond: True if row i of both sets is the same fiducial; otherwise the correspondence is found.
        fle: localisation error of the fixed points: rms length [m], standard deviations (3,) or (M, 3) [m], or
            covariances (3, 3) or (M, 3, 3) [m^2] in the fixed frame. Default: estimated from the residuals, isotropic.
        fle_moving: the same for the moving points, in the moving frame. Default: none.
        names: names of the moving points, for messages.
        candidates: places (C, 3) in the moving frame where a fiducial could be added [m].

    Raises:
        RegistrationError: fewer than three, collinear, duplicated or mirrored points, other units, or a correspondence
            that is ambiguous or does not exist.
    """
    m, f = checks.cloud("moving", moving), checks.cloud("fixed", fixed)
    checks.units(m, f)
    labels = list(names) if names is not None else [str(i) for i in range(len(m))]
    checks.layout("moving", m, labels)
    checks.layout("fixed", f, labels if correspond and len(f) == len(m) else [str(i) for i in range(len(f))])
    goals = np.zeros((0, 3)) if targets is None else checks.cloud("targets", targets, least=1)
    known = fle is not None or fle_moving is not None
    S_m = _stated(fle_moving, len(m))
    S_f = _stated(fle if known else 1.0, len(f))  # unit covariances until the residuals give the scale
    partner = _partners(m, f, correspond, float(np.sqrt(_mean_trace(S_m) + _mean_trace(S_f))) if known else None)
    used = np.flatnonzero(partner >= 0)
    pairs = Matched(m[used], f[partner[used]], S_m[used], S_f[partner[used]])
    return _register(pairs, used, partner, goals, known, candidates)


def _stated(fle: npt.ArrayLike | None, n: int) -> Array:
    return np.zeros((n, 3, 3)) if fle is None else covariances(fle, n)


def _partners(m: Array, f: Array, correspond: bool, fle: float | None) -> Indices:
    if not correspond:
        return matching.partners(m, f, fle)
    if len(m) != len(f):
        raise RegistrationError(
            f"{len(m)} moving and {len(f)} fixed points cannot correspond row by row",
            mend="give the same points in the same order, or correspond=False (--unknown)",
        )
    checks.same_markers(m, f)
    return np.arange(len(m))


def _mean_trace(S: Array) -> float:
    return float(np.trace(S, axis1=1, axis2=2).mean())


def _register(
    pairs: Matched, used: Indices, partner: Indices, goals: Array, known: bool, candidates: npt.ArrayLike | None
) -> PointRegistration:
    """Register matched points whose index in the moving set is `used` (n,)."""
    wrong = outliers.find(pairs, known)
    kept = [k for k in range(len(pairs)) if k not in wrong]
    good = pairs[kept]
    X = good.solve()
    q, freedom = good.chi_square(X), 3 * len(good) - 6
    scale = 1.0 if known else q / freedom  # the stated covariances, or unit ones times the estimated variance
    wide = 1.0 if known else student_factor(freedom)
    covariance = np.asarray(wide * scale * np.linalg.inv(good.information(X)), dtype=np.float64)
    size = _Size.of(good, X, known)
    residual = np.linalg.norm(pairs.fixed - transform(X, pairs.moving), axis=1)
    found = tuple(predict.target(X, covariance, p) for p in goals)
    places = None if candidates is None else checks.cloud("candidates", candidates, least=1)
    S = np.asarray(scale * good.S(X).mean(axis=0), dtype=np.float64)
    tre = np.array([one.tre for one in found])
    extra = len(found) > 0 and q > 0
    return PointRegistration(
        X=X,
        fre=float(np.sqrt(np.square(residual[kept]).mean())),
        fle=float(np.sqrt(np.trace(S))),
        tre=tre,
        tre_95=tre if known else tre / np.sqrt(wide) * _upper(freedom),
        covariance=covariance,
        size=size.value,
        size_deviation=size.deviation,
        outliers=tuple(int(used[k]) for k in wrong),
        correspondence=partner,
        residuals=_spread(residual, used, len(partner)),
        leave_one_out=_spread(_left_out(pairs, kept), used, len(partner)),
        targets=found,
        addition=predict.next_point(X, covariance, wide * S, good.moving, goals, places) if extra else None,
        estimated=not known,
        warnings=(
            *_warnings(good, known, q, freedom),
            *_of_size(size, pairs, good, known),
            *_of_mirror(good, known, q),
            *order.remarks(good.whitened(X)),
            *(() if known else isotropy.remarks(X, good.moving, good.fixed)),
        ),
    )


def _spread(values: Array, used: Indices, n: int) -> Array:
    out = np.full(n, np.nan)
    out[used] = values
    return out


def _left_out(pairs: Matched, kept: list[int]) -> Array:
    """Distance of each point from the prediction by the kept others; NaN where fewer than three remain."""
    out = np.full(len(pairs), np.nan)
    for k in range(len(pairs)):
        others = [i for i in kept if i != k]
        if len(others) >= 3:
            out[k] = np.linalg.norm(outliers.without(pairs[[*others, k]], len(others))[0])
    return out


def _upper(freedom: int) -> float:
    """Factor of an estimated standard deviation to its upper bound."""
    from scipy.special import chdtri

    return float(np.sqrt(freedom / chdtri(freedom, CONFIDENCE)))


@dataclass(frozen=True)
class _Size:
    """Ratio of the sizes of two sets, as a seventh parameter."""

    value: float
    deviation: float
    p: float  # probability of such a ratio for sets of the same size

    @staticmethod
    def of(pairs: Matched, X: Array, known: bool) -> _Size:
        """The ratio that lowers the residuals of the pose X (4, 4) most, and its significance."""
        from scipy.special import ndtr, stdtr

        arms = (pairs.moving - pairs.moving.mean(axis=0)) @ X[:3, :3].T
        U = np.linalg.inv(np.linalg.cholesky(pairs.S(X)))
        J = (U @ np.concatenate([jacobians(X, pairs.moving), arms[..., None]], axis=2)).reshape(-1, 7)
        r = (U @ (pairs.fixed - transform(X, pairs.moving))[..., None]).ravel()
        C = np.linalg.inv(J.T @ J)
        xi = C @ (J.T @ r)
        freedom = len(r) - 7
        variance = 1.0 if known else float(np.square(r - J @ xi).sum()) / freedom
        deviation = float(np.sqrt(max(variance * C[6, 6], 1e-30)))
        t = -abs(float(xi[6])) / deviation
        return _Size(1.0 + float(xi[6]), deviation, float(2.0 * (ndtr(t) if known else stdtr(freedom, t))))


def _of_size(size: _Size, pairs: Matched, good: Matched, known: bool) -> list[str]:
    """The warning that the sets have different sizes, in the markers used or in all of them."""
    every = size if len(pairs) == len(good) else _Size.of(pairs, pairs.solve(), known)
    worst = min((size, every), key=lambda one: one.p)
    if worst.p >= _OTHER_SIZE or abs(worst.value - 1.0) < 1e-6:
        return []
    return [
        f"the fixed points are {worst.value:.4f} +- {worst.deviation:.4f} times as large as the moving points: a scale "
        "error of a scan or a tracker (voxel size, calibration), which the predicted errors do not include"
    ]


def _of_mirror(good: Matched, known: bool, q: float) -> list[str]:
    """The warning that a mirrored list would fit as well: the markers lie in a plane."""
    from scipy.special import chdtrc, fdtrc

    flat = good.moving - good.moving.mean(axis=0)
    normal = np.linalg.svd(flat)[2][2]
    mirrored = Matched(good.moving - 2.0 * np.outer(flat @ normal, normal), good.fixed, good.S_moving, good.S_fixed)
    other, freedom = mirrored.chi_square(mirrored.solve()), 3 * len(good) - 6
    fits = chdtrc(freedom, other) if known else fdtrc(freedom, freedom, other / max(q, 1e-30))
    if fits < _FLAT and other > 4.0 * q:
        return []
    thick = 2e3 * float(np.abs(flat @ normal).max())
    return [
        f"the markers lie in a plane within {thick:.2g} mm: a mirrored list (one axis with the opposite sign) would "
        "fit as well, with another pose; add a marker out of the plane, or check the axes"
    ]


def _warnings(good: Matched, known: bool, q: float, freedom: int) -> tuple[str, ...]:
    from scipy.stats import chi2

    found = []
    if known and chi2.sf(q, freedom) < _IMPLAUSIBLE:
        found.append(
            f"the residuals are {np.sqrt(q / freedom):.2g} times what the stated localisation error explains: the "
            "predicted errors are too small"
        )
    if not known and len(good) < 6:
        found.append(
            f"the localisation error is estimated from {freedom} degrees of freedom and uncertain by about "
            f"{100 / np.sqrt(2 * freedom):.0f} %: state it (fle, --fle), or measure more points"
        )
    return tuple(found)
