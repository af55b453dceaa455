"""Least squares with unknown components of variance: the solution, its interval, and how often it covers."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.world.registration.deletion import Linearised

_RATIO = 60.0  # largest factor between the true and the usual ratio of position to rotation errors
_SPREAD = np.log(4.0)  # standard deviation of the logarithm of that factor, known beforehand
_RATIOS, _SHARES = 13, 5  # points of the grid over both ratios
_NEGLIGIBLE = 1e-3  # probability relative to the largest below which ratios are left out of the second grid
_TEMPER = 0.7  # power of the likelihood of the ratios: at 1, 95 % ellipsoids held the truth in 1145 of 1249 noisy sets
_DRAWS = 4000  # for the quantile of the distance between the truth and the solution
_ROUNDING = 1e-9  # smaller residuals of exact data are rounding, in usual errors


@dataclass(frozen=True)
class Components:
    """A linear fit ``r = J theta + e`` to N measurements with position and rotation, and the covariances of e.

    The covariance of measurement i is ``s^2 (ratio^2 P + (1 - share) I_r + share L_i L_i')``: position errors, rotation
    errors about the measured place, and rotation errors about a place away from it. s, ratio and share are unknown.
    """

    r: Array  #: (N, 6) residuals in usual errors
    J: Array  #: (N, 6, p) derivatives of the prediction
    L: Array  #: (N, 6, 3) effect of a rotation error about the other place

    @property
    def freedom(self) -> int:
        """Measured numbers less parameters."""
        return int(self.r.size - self.J.shape[2])

    def fits(self) -> Fits:
        """Fits for a grid of the two ratios, refined where they are probable."""
        logs = np.linspace(-np.log(_RATIO), np.log(_RATIO), _RATIOS)
        shares = np.linspace(0.0, 1.0, _SHARES)
        found = self._fits(logs, shares)
        likely = found.p > _NEGLIGIBLE * found.p.max()
        step = logs[1] - logs[0]
        low, high = np.log(found.ratio[likely].min()) - step, np.log(found.ratio[likely].max()) + step
        return self._fits(np.linspace(max(low, logs[0]), min(high, logs[-1]), _RATIOS), shares)

    def _fits(self, logs: Array, shares: Array) -> Fits:
        """Weighted least squares and restricted likelihood for each pair of ratios."""
        ratio, share = np.array(list(itertools.product(np.exp(logs), shares))).T
        P, R = np.diag([1.0, 1, 1, 0, 0, 0]), np.diag([0.0, 0, 0, 1, 1, 1])
        LL = self.L @ np.swapaxes(self.L, 1, 2)
        S = (ratio[:, None, None] ** 2 * P + (1.0 - share[:, None, None]) * R)[:, None] + share[
            :, None, None, None
        ] * LL
        W = np.linalg.inv(S)
        WJ = W @ self.J
        H = np.einsum("nip,gniq->gpq", self.J, WJ)
        theta = np.linalg.solve(H, np.einsum("gnip,ni->gp", WJ, self.r)[..., None])[..., 0]
        e = self.r - np.einsum("nip,gp->gni", self.J, theta)
        Q = np.maximum(np.einsum("gni,gnij,gnj->g", e, W, e), self.freedom * _ROUNDING**2)
        log_p = -0.5 * (
            np.linalg.slogdet(S)[1].sum(axis=1) + np.linalg.slogdet(H)[1] + self.freedom * np.log(Q)
        )  # fmt: skip
        log_p -= 0.5 * (np.log(ratio) / _SPREAD) ** 2
        p = np.exp(_TEMPER * (log_p - log_p.max()))
        return Fits(ratio, share, p / p.sum(), theta, np.linalg.inv(H), Q / self.freedom, W, self.freedom)

    def linearised(self) -> Linearised:
        """Residuals and derivatives whitened by the most probable ratios, for the deletion of wrong measurements."""
        fits = self._fits(np.linspace(-np.log(_RATIO), np.log(_RATIO), _RATIOS), np.array([0.0, 0.5, 1.0]))
        best = int(np.argmax(fits.p))
        U = np.swapaxes(np.linalg.cholesky(fits.W[best]), 1, 2)
        e = self.r - self.J @ fits.theta[best]
        return Linearised((U @ e[..., None])[..., 0], U @ self.J)


@dataclass(frozen=True)
class Fits:
    """Solutions for G pairs of ratios."""

    ratio: Array  #: (G,)
    share: Array  #: (G,)
    p: Array  #: (G,) probabilities
    theta: Array  #: (G, p)
    C: Array  #: (G, p, p) covariances for s = 1
    variance: Array  #: (G,) estimates of s^2
    W: Array  #: (G, N, 6, 6) weights of the measurements for s = 1
    freedom: int

    @property
    def solution(self) -> Array:
        """Mean (p,) over the ratios."""
        return np.asarray(self.p @ self.theta)

    def sigma(self) -> tuple[float, float]:
        """Standard deviations of the position and the rotation of one measurement along an axis, in usual errors."""
        position = float(np.sqrt(self.p @ (self.variance * self.ratio**2)))
        return position, float(np.sqrt(self.p @ self.variance))

    def covariance(self, part: slice, probability: float = 0.95) -> Array:
        """Covariance of some parameters, so that a normal distribution has the true ellipsoid of a probability.

        The parameters follow a mixture of Student's distributions over the ratios. Its covariance is scaled by the
        quantile of the distance over that of chi-square; for known ratios this is the factor of F over chi-square.
        """
        from scipy.special import chdtri

        rng = np.random.default_rng(0)
        chosen = rng.choice(len(self.p), _DRAWS, p=self.p)
        C = (self.variance[:, None, None] * self.C)[:, part, part]
        d = self.theta[:, part] - self.solution[part]
        size = d.shape[1]
        z = (np.linalg.cholesky(C)[chosen] @ rng.normal(size=(_DRAWS, size, 1)))[..., 0]
        drawn = d[chosen] + z * np.sqrt(self.freedom / rng.chisquare(self.freedom, (_DRAWS, 1)))
        V = np.einsum("g,gij->ij", self.p, C) + np.einsum("g,gi,gj->ij", self.p, d, d)
        distance = np.einsum("ni,ni->n", drawn, np.linalg.solve(V, drawn.T).T)
        return np.asarray(V * np.quantile(distance, probability) / chdtri(size, 1.0 - probability))
