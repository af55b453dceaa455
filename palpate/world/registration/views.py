"""Views of an organ by a camera at rest: the first pose, and the organ's motion between two views."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import composed_covariance, displacement, inverse, inverse_covariance, transform
from palpate.base.errors import RegistrationError
from palpate.world.registration.organ_motion import smallest_told
from palpate.world.registration.surfaces import surface
from palpate.world.registration.touches import Guess

_LEVEL = 1e-3  # probability with which two views of an organ at rest are called a motion


def seen(points: Array, view: Array, before: Guess | None = None) -> Guess:
    """Pose X_CO of an organ in the camera's frame C.

    Args:
        points: (M, 3) spread over the organ's surface, in its frame O [m].
        view: points (N, 3) of the organ that the camera sees [m].
        before: the pose in an earlier view; default: none.

    Raises:
        RegistrationError: the view does not show this organ, or not enough of it.
    """
    found = surface(view, points, None if before is None else inverse(before.X))
    if not found.trusted:
        raise RegistrationError(
            "the camera's view cannot be registered with the organ" + ("" if before is None else " after the touches"),
            why="; ".join(found.doubts),
            mend="show more of the organ, or name the right scan",
        )
    return Guess(inverse(found.X), inverse_covariance(found.X, found.covariance))


def placed(seen_at: Guess, X_WC: Array, covariance: Array) -> Guess:
    """Pose X_WO of an organ that a camera sees at X_CO, with the camera's pose X_WC and its covariance."""
    return Guess(X_WC @ seen_at.X, composed_covariance(X_WC, covariance, seen_at.X, seen_at.covariance))


def motion(before: Guess, after: Guess, p_O: Array) -> tuple[str, ...]:
    """The motion of the organ between two views X_CO, in words; empty if their noise explains it.

    The displacement over the covariance of both views is chi-square with six degrees of freedom. The error of the
    camera's own pose is common to both and drops out.

    Args:
        before, after: the two poses.
        p_O: place (3,) of the organ whose displacement is named, such as a target [m].
    """
    from scipy.special import chdtrc

    d = displacement(before.X, after.X)
    if float(chdtrc(6, d @ np.linalg.solve(before.covariance + after.covariance, d))) >= _LEVEL:
        return ()
    away = transform(after.X, p_O[None])[0] - transform(before.X, p_O[None])[0]
    size = 1e3 * float(np.linalg.norm(away))
    return (f"organ or camera moved between the first view and the last, by about {size:.1f} mm at the first target",)


def require_rest(points: Array, before: Guess, view: Array, p_O: Array) -> None:
    """Check that the organ is where an earlier view saw it.

    Args:
        points, view: as for `seen`.
        before: pose in the earlier view.
        p_O: as for `motion`.

    Raises:
        RegistrationError: organ or camera moved, or the view does not show the organ.
    """
    moved = motion(before, seen(points, view, before), p_O)
    if moved:
        raise RegistrationError(
            "the organ does not lie where the touches began", why=moved[0], mend="fix what moved, and begin again"
        )


def smallest(before: Guess) -> float:
    """Smallest displacement that a second view as good as the first tells in nine of ten cases [m], or NaN."""
    M = np.asarray(np.linalg.inv(2.0 * before.covariance)[:3, :3], dtype=np.float64)
    return smallest_told(M, 6, _LEVEL)
