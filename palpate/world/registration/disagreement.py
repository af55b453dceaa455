"""Whether touches disagree with a first pose or with each other: why they do, and what they could not show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.arrays.rigid import displacement
from palpate.world.registration.touches import (
    Guess,
    Touched,
    TouchRegistration,
    distance_covariance,
    linearised,
    touches,
)

IMPLAUSIBLE = 1e-3  # probability of the touches below which they disagree; the test is repeated after every touch
_EXPLAINED = 0.01  # probability above which a hypothesis explains them
_FREE = np.diag([0.1**2] * 3 + [0.5**2] * 3)  # covariance of a first pose that says nothing [m^2, rad^2]
_FEWEST = 3  # touches on either side of a motion of the organ
_POWER = 0.9  # share of the motions that are told
_FARTHEST = 1.0  # [m]


def reasons(model: _core.Surface, first: Guess, touched: Touched, found: TouchRegistration) -> tuple[str, ...]:
    """What is wrong with the touches, in words; empty if the stated errors explain them.

    The first hypothesis that explains the touches is named: one wrong touch, a common displacement of all touches, or
    a motion of the organ between two touches.

    Args:
        model: the surface.
        first: pose before the touches.
        touched: the touches.
        found: their registration.
    """
    if found.probability >= IMPLAUSIBLE:
        return ()
    return (_one_wrong(model, first, touched) or _all_shifted(model, first, touched) or _moved(model, first, touched)
            or (f"no pose explains the touches: chi-square {found.chi_square:.0f} for {len(touched)} touches; another "
                "organ, or larger errors than stated",))  # fmt: skip


def smallest_motion(model: _core.Surface, first: Guess, touched: Touched, found: TouchRegistration) -> float:
    """Smallest motion of the organ after half of the touches that `reasons` tells in nine of ten cases [m].

    Of smaller ones more stay untold: a pose between the two places explains the touches. The motion is a displacement
    in any direction. chi_square of N touches is then non-central, with the squared change of their distances over its
    covariance (stated errors of touches, tip and first pose) as non-centrality. The arguments are those of `reasons`.
    NaN with fewer than six touches, or if no motion up to 1 m is told so often.
    """
    from scipy.optimize import brentq
    from scipy.special import chdtri, chndtr

    n = len(touched)
    if n < 2 * _FEWEST:
        return float("nan")
    _, J = linearised(model, found.X, found.offset, touched)
    change = np.zeros((n, 3))  # of the distances, by the displacement
    change[n // 2 :] = J[n // 2 :, :3]
    each = _directions() @ change.T
    S = distance_covariance(J, first.covariance, touched)
    per_m2 = np.sum(each * np.linalg.solve(S, each.T).T, axis=1)  # non-centrality of a motion by 1 m
    limit = chdtri(n, IMPLAUSIBLE)

    def missing(motion: float) -> float:
        return float(np.mean(chndtr(limit, n, motion**2 * per_m2))) - (1.0 - _POWER)

    return float(brentq(missing, 0.0, _FARTHEST)) if missing(_FARTHEST) < 0.0 else float("nan")


def _directions(n: int = 200) -> Array:
    """Directions (n, 3) that are spread evenly."""
    k = np.arange(n) + 0.5
    z, angle = 1.0 - 2.0 * k / n, np.pi * (1.0 + np.sqrt(5.0)) * k
    return np.column_stack([np.sqrt(1.0 - z**2) * np.cos(angle), np.sqrt(1.0 - z**2) * np.sin(angle), z])


def _one_wrong(model: _core.Surface, first: Guess, touched: Touched) -> tuple[str, ...]:
    n = len(touched)
    if n < _FEWEST + 1:
        return ()
    others = [touches(model, first, touched[[k for k in range(n) if k != i]]) for i in range(n)]
    best = int(np.argmax([one.probability for one in others]))
    if others[best].probability < _EXPLAINED:
        return ()
    away = touches(model, replace(others[best], covariance=1e-12 * np.eye(6)), touched[[best]]).residuals[0]
    return (f"touch {best + 1} lies {1e3 * abs(away):.1f} mm from where the others predict the surface",)


def _all_shifted(model: _core.Surface, first: Guess, touched: Touched) -> tuple[str, ...]:
    shifted = touches(model, first, replace(touched, tip=0.05))
    if shifted.probability < _EXPLAINED:
        return ()
    shift = touched.R_WT.mean(axis=0) @ shifted.offset
    words = ", ".join(f"{1e3 * x:+.1f}" for x in -shift)
    size = 1e3 * float(np.linalg.norm(shift))
    return (
        f"all touches lie {size:.1f} mm, ({words}) mm in the world, from the first pose: the tool's tip is calibrated "
        "wrongly, or the organ or the camera has moved since the first pose",
    )


def _moved(model: _core.Surface, first: Guess, touched: Touched) -> tuple[str, ...]:
    from scipy.special import chdtrc

    n, best = len(touched), (0.0, 0, np.zeros(6))
    for k in range(_FEWEST, n - _FEWEST + 1):
        before = touches(model, first, touched[:k])
        after = touches(model, Guess(before.X, _FREE), touched[k:])
        p = float(chdtrc(n, before.chi_square + after.chi_square))
        if p > best[0]:
            best = (p, k, displacement(before.X, after.X))
    p, k, xi = best
    if p < _EXPLAINED:
        return ()
    return (
        f"the organ moved after about touch {k}: by {1e3 * np.linalg.norm(xi[:3]):.1f} mm and "
        f"{np.degrees(np.linalg.norm(xi[3:])):.1f} deg",
    )
