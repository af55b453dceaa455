"""Localisation error of measured points: what a user may state, as one covariance per point."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.errors import RegistrationError

CONFIDENCE = 0.95
"""Of ellipsoids and upper bounds when the localisation error is estimated."""


def student_factor(freedom: int) -> float:
    """Factor of a covariance with an estimated size, so that a normal distribution has the true ellipsoid at a target.

    It is that of F with 3 numerator degrees of freedom over chi-square. The intervals of a single direction and the
    ellipsoid of all six parameters, which need other factors, then hold the truth in 93 to 97 %.
    """
    from scipy.special import chdtri, fdtri

    return float(3.0 * fdtri(3, freedom, CONFIDENCE) / chdtri(3, 1.0 - CONFIDENCE))


def covariances(fle: npt.ArrayLike, n: int) -> Array:
    """Covariances (n, 3, 3) [m^2] of n points from a localisation error in any of its forms.

    Args:
        fle: rms length of the error [m]: one number, its three components equal (Fitzpatrick's FLE); standard
            deviations along the axes (3,) or (n, 3) [m]; or covariances (3, 3) or (n, 3, 3) [m^2]. For three points,
            an array (3, 3) is one covariance if it is symmetric, and standard deviations otherwise.
        n: number of points.

    Raises:
        RegistrationError: another shape, or a covariance that is not symmetric and positive definite.
    """
    given = np.asarray(fle, dtype=np.float64)
    if given.ndim == 0:
        found = np.broadcast_to(given**2 / 3.0 * np.eye(3), (n, 3, 3))
    elif given.shape in ((3,), (n, 3)) and not _one_matrix(given):
        found = np.broadcast_to(given[..., None] ** 2 * np.eye(3), (n, 3, 3))
    elif given.shape in ((3, 3), (n, 3, 3)):
        found = np.broadcast_to(given, (n, 3, 3))
    else:
        raise RegistrationError(
            f"the localisation error has the shape {given.shape}",
            mend=f"give a number, (3,), ({n}, 3), (3, 3) or ({n}, 3, 3)",
        )
    if not np.isfinite(found).all() or (np.linalg.eigvalsh(found) <= 0).any() or not _symmetric(found):
        raise RegistrationError(
            f"the localisation error {given.tolist()} is not positive in every direction",
            mend="give positive lengths [m], or symmetric positive definite covariances [m^2]",
        )
    return found


def _one_matrix(given: Array) -> bool:
    return given.shape == (3, 3) and _symmetric(given)


def _symmetric(S: Array) -> bool:
    return bool(np.allclose(S, np.swapaxes(S, -1, -2), rtol=1e-6, atol=0.0))


def isotropic(S: Array) -> bool:
    """True if all covariances (n, 3, 3) are the same multiple of the identity."""
    return bool((np.abs(S - S[0, 0, 0] * np.eye(3)) <= 1e-9 * S[0, 0, 0]).all())
