"""Sequential deletion of wrong measurements from a least-squares fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from palpate.arrays import Array

FALSE_ALARM = 0.003  # share of sets without a wrong measurement in which one is named
_ROUNDING = 1e-9  # smaller residuals of exact data are rounding, in the residuals' own unit


@dataclass(frozen=True)
class Linearised:
    """Whitened residuals of a fit and their derivatives: each has the covariance I, or s^2 I with an unknown s."""

    residuals: Array  #: (N, d)
    J: Array  #: (N, d, p) derivatives of the prediction with respect to the p fitted parameters

    def probabilities(self, known: bool) -> Array:
        """Probability (N,) of a residual at least as large as the one found, for each measurement, if it is right.

        Leaving measurement i out, its squared Mahalanobis distance from the prediction by the others is
        ``d = r' (I - H)^-1 r`` with its diagonal block H of the hat matrix, and the others' sum of squares falls by d
        (Cook and Weisberg, Residuals and Influence in Regression, 1982). d follows chi-square, or F if s is unknown.
        """
        from scipy.special import chdtrc, fdtrc

        n, size, parameters = self.J.shape
        information = np.einsum("nip,niq->pq", self.J, self.J)
        H = self.J @ np.linalg.pinv(information) @ np.swapaxes(self.J, 1, 2)
        free = np.eye(size) - H + 1e-12 * np.eye(size)
        d = np.einsum("ni,nij,nj->n", self.residuals, np.linalg.inv(free), self.residuals)
        if known:
            return np.asarray(chdtrc(size, d))
        freedom = (n - 1) * size - parameters
        rest = np.maximum(np.square(self.residuals).sum() - d, freedom * _ROUNDING**2)
        return np.asarray(fdtrc(size, freedom, d / size / (rest / freedom)))


def deletions(
    n: int, least: int, linearised: Callable[[list[int]], Linearised], known: bool, false_alarm: float = FALSE_ALARM
) -> list[int]:
    """Indices of wrong measurements among n, by sequential deletion with the decision at the end.

    Each step deletes the measurement that the others predict worst. The last step whose Bonferroni-corrected
    probability is below `false_alarm` decides, so that two wrong measurements do not hide each other (Rosner,
    Technometrics 25(2), 1983). Measurements that fit the others after all are taken back.

    Args:
        n: number of measurements.
        least: number of measurements that always remain.
        linearised: the fit to the measurements in these rows.
        known: True if the residuals are whitened by known covariances.
        false_alarm: probability of a false alarm.
    """
    left, deleted, found = list(range(n)), [], 0
    for step in range(min(n - least, (n - 1) // 2)):
        p = linearised(left).probabilities(known)
        worst = int(np.argmin(p))
        found = step + 1 if len(left) * p[worst] < false_alarm else found
        deleted.append(left.pop(worst))
    kept = [k for k in range(n) if k not in deleted[:found]]
    for k in reversed(deleted[:found]):  # an early deletion may have been the effect of a later one
        if n * linearised([*kept, k]).probabilities(known)[-1] >= false_alarm:
            kept.append(k)
    return sorted(set(range(n)) - set(kept))
