"""Energy at the port of the hand: quadratures of the wrench along the motion, which share no code with the core."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array


def rotations(theta: Array) -> Array:
    """Rotation matrices (n, 3, 3) of rotation vectors (n, 3) [rad], by Rodrigues' formula."""
    angle = np.linalg.norm(theta, axis=1)
    safe = np.where(angle > 1e-12, angle, 1.0)
    K = np.zeros((len(theta), 3, 3))
    x, y, z = (theta / safe[:, None]).T
    K[:, 0, 1], K[:, 0, 2], K[:, 1, 0], K[:, 1, 2], K[:, 2, 0], K[:, 2, 1] = -z, y, z, -x, -y, x
    return np.asarray(np.eye(3) + np.sin(angle)[:, None, None] * K + (1 - np.cos(angle))[:, None, None] * (K @ K))


def rotation_steps(R: Array) -> Array:
    """Rotation vectors (n - 1, 3) from each rotation of (n, 3, 3) to the next, in the base's axes [rad]."""
    D = R[1:] @ np.swapaxes(R[:-1], 1, 2)
    w = 0.5 * np.stack([D[:, 2, 1] - D[:, 1, 2], D[:, 0, 2] - D[:, 2, 0], D[:, 1, 0] - D[:, 0, 1]], axis=1)
    sine = np.linalg.norm(w, axis=1)[:, None]
    return np.asarray(w * np.where(sine > 1e-9, np.arcsin(np.minimum(sine, 1.0)) / np.maximum(sine, 1e-9), 1.0))


def steps(X: Array) -> Array:
    """Motion (n - 1, 6) from each pose of (n, 4, 4) to the next, in the base's axes [m, rad]."""
    return np.concatenate([np.diff(X[:, :3, 3], axis=0), rotation_steps(X[:, :3, :3])], axis=1)


def work_at_rest(F: Array, X: Array) -> Array:
    """Work of the hand (n,) up to each pose, by the trapezoidal rule over wrenches that belong to these poses [J].

    Args:
        F: wrench on the hand (n, 6), felt at rest at each pose [N, N m].
        X: pose of the handle (n, 4, 4) [m].
    """
    return np.append(0.0, -np.cumsum((0.5 * (F[1:] + F[:-1]) * steps(X)).sum(axis=1)))


def work_held(F: Array, X: Array, axes: int = 6) -> Array:
    """Work of the hand (n,) up to each tick, where each wrench is held until the next one [J].

    Args:
        F: wrench (n, 6) that the loop returned for each pose [N, N m].
        X: pose of the handle (n, 4, 4) [m].
        axes: 6; 3 for a device that renders the force and no moment.
    """
    return np.append(0.0, -np.cumsum((F[:-1] * steps(X))[:, :axes].sum(axis=1)))
