"""Wrong markers: fiducials whose residual the localisation error cannot explain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import transform
from palpate.world.registration.deletion import FALSE_ALARM, Linearised, deletions
from palpate.world.registration.fit import Indices, chi_square, information, jacobians, residual_covariances, solve


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

    def whitened(self, X: Array) -> Array:
        """Residuals (N, 3) over their standard deviations."""
        L = np.linalg.inv(np.linalg.cholesky(self.S(X)))
        return np.asarray((L @ (self.fixed - transform(X, self.moving))[..., None])[..., 0])

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
    """Indices of wrong markers (`deletions`)."""

    def linearised(rows: list[int]) -> Linearised:
        part = pairs[rows]
        X = part.solve()
        L = np.linalg.inv(np.linalg.cholesky(part.S(X)))
        return Linearised(part.whitened(X), L @ jacobians(X, part.moving), uneven=True)

    return deletions(len(pairs), 3, linearised, known, false_alarm)
