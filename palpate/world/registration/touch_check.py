"""Check of a registration by touches: where contact is felt against where the registered surface predicts it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import transform
from palpate.world.registration.procedure import Organ
from palpate.world.registration.touches import Guess, Touched, distance_covariance, linearised

IMPLAUSIBLE = 0.01  # probability of the distances below which the predicted errors are wrong
_SIGMAS = 3.0  # standard deviations of a touch by which a distance may exceed the accuracy


@dataclass(frozen=True)
class TouchCheck:
    """Felt against predicted contact at k places."""

    distances: Array  #: (k,) felt minus predicted place along the outward normal [m]
    normals: Array  #: (k, 3) outward normals in W
    places: Array  #: (k, 3) felt places of the tip in W [m]
    mean: float  #: mean size of the distances [m]
    worst: float  #: largest size [m]
    direction: Array  #: (3,) unit vector in W from the predicted to the felt place of the worst
    shift: Array  #: (3,) displacement in W that explains the distances best [m]
    probability: float  #: of larger distances, if the predicted errors are right
    doubts: tuple[str, ...]  #: why the check failed; empty if it passed

    @property
    def passed(self) -> bool:
        """True if the registration may be used."""
        return not self.doubts


def check(organ: Organ, registered: Guess, touched: Touched, accuracy: float) -> TouchCheck:
    """Compare touches with a registered organ.

    The distances have the covariance of the touches, of the registration and of the tip's offset together. The check
    fails if their chi-squared is implausible, or if one exceeds the accuracy by more than a touch explains.

    Args:
        organ: the organ.
        registered: its pose X_WO with covariance.
        touched: k touches.
        accuracy: error that the registration claims to keep [m].
    """
    from scipy.special import chdtrc

    e, J = linearised(organ.surface, registered.X, np.zeros(3), touched)
    S = distance_covariance(J, registered.covariance, touched)
    probability = float(chdtrc(len(e), float(e @ np.linalg.solve(S, e))))
    normals, worst = -J[:, :3], int(np.argmax(np.abs(e)))
    shift = np.asarray(np.linalg.lstsq(normals, e, rcond=0.05)[0], dtype=np.float64)
    return TouchCheck(
        distances=e, normals=normals, places=touched.p_WT, mean=float(np.abs(e).mean()), worst=float(abs(e[worst])),
        direction=normals[worst] * np.sign(e[worst]), shift=shift, probability=probability,
        doubts=_doubts(float(abs(e[worst])), probability, shift, accuracy + _SIGMAS * touched.sigma),
    )  # fmt: skip


def _doubts(worst: float, probability: float, shift: Array, limit: float) -> tuple[str, ...]:
    found = []
    if worst > limit:
        found.append(f"one place differs by {1e3 * worst:.2f} mm, {1e3 * limit:.2f} mm are allowed")
    if probability < IMPLAUSIBLE:
        words = ", ".join(f"{1e3 * x:+.1f}" for x in shift)
        found.append(
            f"the predicted errors do not explain the distances (probability {probability:.1g}); the organ lies about "
            f"({words}) mm from its registered place"
        )
    return tuple(found)


def spread(
    organ: Organ, X_WO: Array, n: int, reaches: Callable[[Array, Array], bool] | None = None
) -> list[tuple[Array, Array]]:
    """Up to n places in W [m] with outward normals: each differs most in place and normal from those before.

    reaches: True for a place and normal in W that the tool can touch; default: all.
    """
    p_O, n_O = organ.touchable
    p, normals = transform(X_WO, p_O), n_O @ X_WO[:3, :3].T
    size = float(np.linalg.norm(np.ptp(p, axis=0)))
    gap = normals @ [0.0, 0.0, 1.0] + 1e3  # begin at the top
    found: list[tuple[Array, Array]] = []
    while len(found) < n and (gap > 0.0).any():
        k = int(np.argmax(gap))
        if reaches is not None and not reaches(p[k], normals[k]):
            gap[k] = 0.0
            continue
        found.append((p[k], normals[k]))
        away = np.linalg.norm(p - p[k], axis=1) / size + np.linalg.norm(normals - normals[k], axis=1)
        gap = np.where(gap > 0.0, np.minimum(gap, away), 0.0)
    return found
