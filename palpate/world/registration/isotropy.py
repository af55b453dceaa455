"""Whether the residuals of fiducials are as large in one direction as in another: `remarks`."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import transform
from palpate.world.registration.fit import jacobians

_LEVEL = 0.01  # probability with which equal errors are called unequal
_DRAWS = 2000
_LARGEST = 5e5  # numbers drawn at once
_EXACT = 1e-9  # residual over the layout's size that is rounding alone
_LEAST = 5  # fewest points: four leave too few residuals for three variances


def remarks(X: Array, moving: Array, fixed: Array) -> tuple[str, ...]:
    """A sentence if the errors of fiducials (n, 3) about the pose X (4, 4) are not equal in all directions [m].

    The statistic is Mauchly's (Annals of Mathematical Statistics 11, 1940): the determinant of the residuals' scatter
    over that of a sphere of the same trace. The fit takes a part of the errors that depends on the layout, so its
    distribution for equal errors is drawn with this layout.
    """
    n = len(moving)
    residual = fixed - transform(X, moving)
    S = residual.T @ residual
    if n < _LEAST or np.trace(S) < (_EXACT * np.ptp(moving)) ** 2:
        return ()
    J = jacobians(X, moving).reshape(-1, 6)
    Q = np.linalg.qr(J / np.linalg.norm(J, axis=0))[0]
    e = np.random.default_rng(0).normal(size=(int(min(_DRAWS, max(200, _LARGEST // (3 * n)))), 3 * n))
    drawn = (e - (e @ Q) @ Q.T).reshape(len(e), n, 3)
    roundness = _roundness(np.einsum("kni,knj->kij", drawn, drawn))
    if np.mean(roundness <= _roundness(S[None])[0]) >= _LEVEL:
        return ()
    value, axes = np.linalg.eigh(S)
    axis, ratio = ", ".join(f"{x:+.2f}" for x in axes[:, 2]), np.sqrt(value[2] / value[:2].mean())
    return (
        f"the errors along ({axis}) of the fixed frame are about {ratio:.1f} times those across it, which "
        "the predicted errors do not include: state them (columns sx, sy, sz)",
    )


def _roundness(S: Array) -> Array:
    """Determinant of each scatter (k, 3, 3) over that of a sphere with its trace, 0 to 1."""
    return np.asarray(np.linalg.det(S) / (np.trace(S, axis1=1, axis2=2) / 3.0) ** 3)
