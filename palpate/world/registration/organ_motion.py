"""Motion of the organ between touches that agree with one pose: a test at the end of a session, and its power."""

from __future__ import annotations

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.world.registration.touches import (
    Guess,
    Touched,
    TouchRegistration,
    distance_covariance,
    linearised,
)

FEWEST = 3
"""Touches on either side of a motion of the organ [-]."""
_LEVEL = 0.01  # probability with which the test calls an organ at rest moved; a session makes it once, at its end
_POWER = 0.9  # share of the motions that are told
_FARTHEST = 1.0  # [m]
_WEAK = 1e-6  # eigenvalue over the largest below which the touches cannot show a direction


def told(model: _core.Surface, first: Guess, touched: Touched, found: TouchRegistration) -> tuple[str, ...]:
    """The motion of the organ that the touches show, in words; empty if they show none.

    For each place between two touches, a displacement of the organ there is estimated by generalised least squares,
    beside the pose and the tip's offset. Its square over its covariance is chi-square with up to three degrees of
    freedom. The smallest probability counts times the number of places (Bonferroni).

    Args:
        model: the surface.
        first: pose before the touches.
        touched: the touches.
        found: their registration.
    """
    from scipy.special import chdtrc

    n = len(touched)
    if n < 2 * FEWEST:
        return ()
    e, J = linearised(model, found.X, found.offset, touched)
    S = distance_covariance(J, first.covariance, touched)
    weighted = e / touched.sigma**2  # residuals before the touches, over S: found is the most likely pose
    best = (1.0, 0, np.zeros(3))
    for k in range(FEWEST, n - FEWEST + 1):
        late = _late(J, k)
        M, u = late.T @ np.linalg.solve(S, late), late.T @ weighted
        value, axes = np.linalg.eigh(M)
        seen = value > _WEAK * value[-1]
        d = axes[:, seen] @ (axes[:, seen].T @ u / value[seen])
        p = float(chdtrc(int(seen.sum()), float(u @ d)))
        if p < best[0]:
            best = (p, k, d)
    p, k, d = best
    if p * _places(n) >= _LEVEL:
        return ()
    return (f"the organ moved after about touch {k}, by about {1e3 * np.linalg.norm(d):.1f} mm",)


def smallest(model: _core.Surface, first: Guess, touched: Touched, found: TouchRegistration) -> float:
    """Smallest motion of the organ after half of the touches that `told` tells in nine of ten cases [m].

    The motion is a displacement in any direction. Of smaller ones more stay untold: a pose between the two places
    explains the touches. The test's chi-square is then non-central; the arguments are those of `told`. NaN with fewer
    than six touches, or if no motion up to 1 m is told so often.
    """
    n = len(touched)
    if n < 2 * FEWEST:
        return float("nan")
    return smallest_told(information(model, first, touched, found, n // 2), 3, _LEVEL / _places(n))


def information(model: _core.Surface, first: Guess, touched: Touched, found: TouchRegistration, before: int) -> Array:
    """Inverse covariance (3, 3) of a displacement of the organ before this touch, estimated beside all else [1/m^2]."""
    _, J = linearised(model, found.X, found.offset, touched)
    late = _late(J, before)
    return np.asarray(late.T @ np.linalg.solve(distance_covariance(J, first.covariance, touched), late))


def smallest_told(M: Array, freedom: int, level: float) -> float:
    """Smallest displacement in a random direction that a chi-square test tells in nine of ten cases [m], or NaN.

    Args:
        M: inverse covariance (3, 3) of the displacement [1/m^2].
        freedom: degrees of freedom of the test.
        level: its probability of a false alarm.
    """
    from scipy.optimize import brentq
    from scipy.special import chdtri, chndtr

    d = directions()
    per_m2 = np.einsum("ni,ij,nj->n", d, M, d)  # non-centrality of a motion by 1 m
    limit = chdtri(freedom, level)

    def missing(motion: float) -> float:
        return float(np.mean(chndtr(limit, freedom, motion**2 * per_m2))) - (1.0 - _POWER)

    return float(brentq(missing, 0.0, _FARTHEST)) if missing(_FARTHEST) < 0.0 else float("nan")


def _places(n: int) -> int:
    """Number of places between n touches at which a motion is looked for."""
    return n - 2 * FEWEST + 1


def _late(J: Array, k: int) -> Array:
    """Change (n, 3) of the distances by a displacement of the organ before touch k."""
    late = np.zeros((len(J), 3))
    late[k:] = J[k:, :3]
    return late


def directions(n: int = 200) -> Array:
    """Directions (n, 3) that are spread evenly."""
    k = np.arange(n) + 0.5
    z, angle = 1.0 - 2.0 * k / n, np.pi * (1.0 + np.sqrt(5.0)) * k
    return np.column_stack([np.sqrt(1.0 - z**2) * np.cos(angle), np.sqrt(1.0 - z**2) * np.sin(angle), z])
