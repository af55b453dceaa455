"""Sequential deletion of wrong measurements from a least-squares fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array

FALSE_ALARM = 0.003  # share of sets without a wrong measurement in which one is named
_ROUNDING = 1e-9  # smaller residuals of exact data are rounding, in the residuals' own unit


@dataclass(frozen=True)
class Linearised:
    """Whitened residuals of a fit and their derivatives: each has the covariance I, or s^2 I with an unknown s."""

    residuals: Array  #: (N, d)
    J: Array  #: (N, d, p) derivatives of the prediction with respect to the p fitted parameters
    uneven: bool = False  #: the errors may be larger along some axes than stated, and smaller along others

    def probabilities(self, known: bool) -> Array:
        """Probability (N,) of a residual at least as large as the one found, for each measurement, if it is right.

        Leaving measurement i out, its squared Mahalanobis distance from the prediction by the others is
        ``d = r' (I - H)^-1 r`` with its diagonal block H of the hat matrix, and the others' sum of squares falls by d
        (Cook and Weisberg, Residuals and Influence in Regression, 1982). d follows chi-square, or F if s is unknown.
        Uneven errors count as equal ones in fewer dimensions, by the second moment of d (Satterthwaite 1946).
        """
        from scipy.special import chdtrc, fdtrc

        n, size, parameters = self.J.shape
        information = np.einsum("nip,niq->pq", self.J, self.J)
        gain = np.linalg.pinv(information) @ np.swapaxes(self.J, 1, 2)  # (N, p, d)
        free = np.eye(size) - self.J @ gain + 1e-12 * np.eye(size)
        solved = np.linalg.solve(free, self.residuals[..., None])[..., 0]
        without = np.asarray(solved, dtype=np.float64)  # residuals from the fit to the others
        d = np.einsum("ni,ni->n", self.residuals, without)
        k = self._dimensions(gain, without) if self.uneven else np.full(n, float(size))
        if known:
            return np.asarray(chdtrc(k, d * k / size))
        freedom = (n - 1) * size - parameters
        rest = np.maximum(np.square(self.residuals).sum() - d, freedom * _ROUNDING**2)
        return np.asarray(fdtrc(k, freedom * k / size, d / size / (rest / freedom)))

    def _dimensions(self, gain: Array, without: Array) -> Array:
        """Number (N,) of dimensions, 1 to d, in which equal errors vary as much as those of the other measurements.

        It is tr(S)^2 / tr(S^2) of their covariance S. Few residuals make it too small, hence the test careful; fewer
        than three times d do not show their axes at all.
        """
        n, size, parameters = self.J.shape
        if (n - 1) * size - parameters < 3 * size:
            return np.full(n, float(size))
        shifts = np.einsum("npd,nd->np", gain, without)  # of the parameters, when a measurement is left out
        others = self.residuals[None] + np.einsum("jdp,ip->ijd", self.J, shifts)  # of j, when i is left out
        others[np.arange(n), np.arange(n)] = 0.0
        C = np.einsum("ijd,ije->ide", others, others)
        trace = np.trace(C, axis1=1, axis2=2)
        dimensions: Array = np.clip(trace**2 / np.maximum(np.square(C).sum(axis=(1, 2)), 1e-300), 1.0, size)
        return dimensions


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
