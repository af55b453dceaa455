"""Wrong markers: fiducials whose residual the localisation error cannot explain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.arrays import Array
from palpate.arrays.rigid import transform
from palpate.registration.fit import Indices, chi_square, information, jacobians, residual_covariances, solve

FALSE_ALARM = 0.003  # share of sets without a wrong marker in which one is named


@dataclass(frozen=True)
class Matched:
    """Corresponding points with the covariances of their errors."""

    moving: Array  #: (N, 3) [m]
    fixed: Array  #: (N, 3) [m]
    S_moving: Array  #: (N, 3, 3) in the moving frame [m^2]
    S_fixed: Array  #: (N, 3, 3) in the fixed frame [m^2]

    def __getitem__(self, keep: Indices | list[int]) -> Matched:
        return Matched(self.moving[keep], self.fixed[keep], self.S_moving[keep], self.S_fixed[keep])

    def __len__(self) -> int:
        return len(self.moving)

    def solve(self) -> Array:
        """Maximum likelihood pose (4, 4)."""
        return solve(self.moving, self.fixed, self.S_moving, self.S_fixed)

    def S(self, X: Array) -> Array:
        """Covariances (N, 3, 3) of the residuals in the fixed frame [m^2]."""
        return residual_covariances(X, self.S_moving, self.S_fixed)

    def chi_square(self, X: Array) -> float:
        """Sum of the squared residuals, each weighted by its covariance."""
        return chi_square(X, self.moving, self.fixed, self.S(X))

    def information(self, X: Array) -> Array:
        """Information matrix (6, 6) of the displacement of X."""
        return information(X, self.moving, self.S(X))


def without(pairs: Matched, i: int) -> tuple[Array, float, float]:
    """Residual (3,) of point i under the pose of the others [m], its squared Mahalanobis length, their chi-square."""
    rest = pairs[[k for k in range(len(pairs)) if k != i]]
    X = rest.solve()
    one = pairs[[i]]
    residual = (one.fixed - transform(X, one.moving))[0]
    J = jacobians(X, one.moving)[0]
    S = one.S(X)[0] + J @ np.linalg.inv(rest.information(X)) @ J.T
    return residual, float(residual @ np.linalg.solve(S, residual)), rest.chi_square(X)


def find(pairs: Matched, known: bool, false_alarm: float = FALSE_ALARM) -> list[int]:
    """Indices of wrong markers, by sequential deletion with the decision at the end (Rosner, Technometrics 25, 1983).

    Each step deletes the point that the others predict worst. The test value of a point is its squared Mahalanobis
    distance from that prediction: chi-square with 3 degrees of freedom if the localisation error is `known`, and F with
    3 and 3 (n - 1) - 6 if it is estimated from the other points. The last step whose Bonferroni-corrected probability
    is below `false_alarm` decides, so that two wrong markers do not hide each other.
    """
    left, deleted, found = list(range(len(pairs))), [], 0
    for step in range(min(len(pairs) - 3, (len(pairs) - 1) // 2)):
        tests = [_probability(pairs[left], k, known) for k in range(len(left))]
        worst = int(np.argmin(tests))
        found = step + 1 if len(left) * tests[worst] < false_alarm else found
        deleted.append(left.pop(worst))
    kept = [k for k in range(len(pairs)) if k not in deleted[:found]]
    for k in reversed(deleted[:found]):  # an early deletion may have been the effect of a later one
        if len(pairs) * _probability(pairs[[*kept, k]], len(kept), known) >= false_alarm:
            kept.append(k)
    return sorted(set(range(len(pairs))) - set(kept))


def _probability(pairs: Matched, i: int, known: bool) -> float:
    """Probability of a residual of point i at least as large as the one found, if the point is right."""
    from scipy.special import chdtrc, fdtrc

    _, d, q = without(pairs, i)
    freedom = 3 * (len(pairs) - 1) - 6
    return float(chdtrc(3, d) if known else fdtrc(3, freedom, d / 3.0 / max(q / freedom, 1e-300)))
