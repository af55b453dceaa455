"""References that share no code with `palpate.world.registration`: Fitzpatrick's closed form, Horn's quaternions."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array


def fitzpatrick(fiducials: Array, fle: float, target: Array) -> float:
    """Rms target error [m] for equal isotropic errors of rms length `fle` [m] (IEEE TMI 17(5), 1998, Eq 46)."""
    middle = fiducials.mean(axis=0)
    axes = np.linalg.svd(fiducials - middle)[2]
    total = 1.0
    for k in range(3):
        across = np.delete(axes, k, axis=0)
        distance = np.square(across @ (target - middle)).sum()
        total += distance / np.square((fiducials - middle) @ across.T).sum(axis=1).mean() / 3.0
    return float(fle * np.sqrt(total / len(fiducials)))


def horn(moving: Array, fixed: Array) -> Array:
    """Least-squares pose (4, 4), fixed = X moving, from the largest eigenvector (Horn, JOSA A 4(4), 1987)."""
    m, f = moving.mean(axis=0), fixed.mean(axis=0)
    M = (moving - m).T @ (fixed - f)
    D = np.array([M[1, 2] - M[2, 1], M[2, 0] - M[0, 2], M[0, 1] - M[1, 0]])
    N = np.block([[np.trace(M), D[None]], [D[:, None], M + M.T - np.trace(M) * np.eye(3)]])
    w, x, y, z = np.linalg.eigh(N)[1][:, -1]
    R = np.array([
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ])  # fmt: skip
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = R, f - R @ m
    return X
