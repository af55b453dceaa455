"""The equation A_i X = Z C_i of hand-eye calibration: closed form, rotation checks and covariance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import displaced, displacement, inverse, log, rigid, transform
from palpate.base.arrays.so3 import cross_matrix

_STEPS, _SMALL = 30, 1e-10  # Gauss-Newton: largest number of steps, step that ends it [m, rad]
_TURNED = np.radians(5.0)  # least rms rotation about the second axis that determines X and Z [rad]


@dataclass(frozen=True)
class Chain:
    """Poses A_i (N, 4, 4) and C_i (N, 4, 4) with ``A_i X = Z C_i`` for unknown constant X and Z.

    The errors are those of C_i: `weights` holds the inverse standard deviations of its position [1/m] and its rotation
    [1/rad], repeated per axis (6,).
    """

    A: Array
    C: Array
    weights: Array
    on_arm: bool  #: True if A_i is the base in the tool (camera on the arm), False if it is the tool in the base

    def __getitem__(self, rows: list[int]) -> Chain:
        return Chain(self.A[rows], self.C[rows], self.weights, self.on_arm)

    def residuals(self, X: Array, Z: Array) -> Array:
        """Displacements (N, 6) from the predicted to the measured C_i [m, rad]."""
        return displacement(inverse(Z) @ self.A @ X, self.C)

    def closed_form(self) -> tuple[Array, Array]:
        """X and Z (4, 4): rotations by Kronecker products (Shah, J. Mechanisms Robotics 5(3), 2013), then positions."""
        K = sum(np.kron(c, a) for a, c in zip(self.A[:, :3, :3], self.C[:, :3, :3], strict=True))
        U, _, Vt = np.linalg.svd(np.asarray(K))
        R_X, R_Z = (_rotation(v.reshape(3, 3, order="F")) for v in (Vt[0], U[:, 0]))
        lhs = np.concatenate([self.A[:, :3, :3], np.broadcast_to(-np.eye(3), (len(self.A), 3, 3))], axis=2)
        rhs = self.C[:, :3, 3] @ R_Z.T - self.A[:, :3, 3]
        p = np.linalg.lstsq(lhs.reshape(-1, 6), rhs.ravel(), rcond=None)[0]
        return rigid(R_X, p[:3]), rigid(R_Z, p[3:])

    def refined(self) -> tuple[Array, Array, Array]:
        """Least-squares X and Z (4, 4) by Gauss-Newton, and the whitened derivatives (N, 6, 12) there."""
        X, Z = self.closed_form()
        for _ in range(_STEPS):
            J = self.derivatives(X, Z)
            r = (self.residuals(X, Z) * self.weights).ravel()
            xi = np.linalg.lstsq(J.reshape(-1, 12), r, rcond=None)[0]
            X, Z = displaced(X, xi[:6]), displaced(Z, xi[6:])
            if np.abs(xi).max() < _SMALL:
                break
        return X, Z, self.derivatives(X, Z)

    def derivatives(self, X: Array, Z: Array) -> Array:
        """Derivatives (N, 6, 12) of the predicted C_i by the xi of X and of Z, times the weights."""
        R_CZ = np.broadcast_to(Z[:3, :3].T, (len(self.A), 3, 3))
        R_CA = R_CZ @ self.A[:, :3, :3]
        arms = (self.A @ X)[:, :3, 3] - Z[:3, 3]
        J = np.zeros((len(self.A), 6, 12))
        J[:, :3, :3] = J[:, 3:, 3:6] = R_CA
        J[:, :3, 6:9] = J[:, 3:, 9:] = -R_CZ
        J[:, :3, 9:] = R_CZ @ np.stack([cross_matrix(arm) for arm in arms])
        return np.asarray(J * self.weights[:, None])

    def turned_tool(self, Z: Array) -> Array:
        """Displacements (N, 6, 3) of C_i by a rotation error of the arm, which turns the board about the tool."""
        centres = inverse(Z)[:3, 3] if self.on_arm else transform(inverse(Z), self.A[:, :3, 3])
        arms = self.C[:, :3, 3] - centres
        turned = np.zeros((len(self.A), 6, 3))
        turned[:, :3] = -np.stack([cross_matrix(arm) for arm in arms])
        turned[:, 3:] = np.eye(3)
        return turned


def _rotation(M: Array) -> Array:
    """The rotation nearest to a positive or negative multiple of itself."""
    U, _, Vt = np.linalg.svd(M * np.sign(np.linalg.det(M)))
    return np.asarray(U @ Vt)


def relative(X: Array) -> Array:
    """Rotation vectors (pairs, 3) from pose i to pose j in the frame that moves, for all i < j [rad]."""
    i, j = np.triu_indices(len(X), 1)
    return log(np.swapaxes(X[i, :3, :3], 1, 2) @ X[j, :3, :3])


def missing_axis(A: Array) -> tuple[Array, Array, float] | None:
    """Axes about which the poses turn and do not turn enough, and the rms angle about the latter; None if they suffice.

    Two rotation axes that are not parallel determine X and Z (Tsai and Lenz, IEEE T-RA 5(3), 1989).
    """
    turns = relative(A)
    values, vectors = np.linalg.eigh(turns.T @ turns / len(turns))
    angle = float(np.sqrt(max(values[1], 0.0)))
    return None if angle > _TURNED else (vectors[:, 2], vectors[:, 1], angle)
