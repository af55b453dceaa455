"""Whether touches disagree with a first pose or with each other, and why they do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from palpate import _core
from palpate.base.arrays.rigid import displacement
from palpate.world.registration.organ_motion import FEWEST
from palpate.world.registration.touches import Guess, Touched, TouchRegistration, touches

IMPLAUSIBLE = 1e-3  # probability of the touches below which they disagree; the test is repeated after every touch
_EXPLAINED = 0.01  # probability above which a hypothesis explains them
_FREE = np.diag([0.1**2] * 3 + [0.5**2] * 3)  # covariance of a first pose that says nothing [m^2, rad^2]


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


def _one_wrong(model: _core.Surface, first: Guess, touched: Touched) -> tuple[str, ...]:
    n = len(touched)
    if n < FEWEST + 1:
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
    for k in range(FEWEST, n - FEWEST + 1):
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
