"""Poses whose quaternions were read in the wrong order: x, y, z, w as w, x, y, z."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import rigid
from palpate.base.arrays.so3 import matrices, quaternions
from palpate.base.errors import RegistrationError

_LARGE, _BETTER = 2e-3, 0.1  # residual that may be a misreading [m], share of it that the other order leaves


def reordered(X: Array) -> Array:
    """The poses (N, 4, 4) of a file whose quaternions x, y, z, w were read as w, x, y, z, read in the right order."""
    q = quaternions(X[:, :3, :3])
    return rigid(matrices(np.roll(q, 1, axis=1)), X[:, :3, 3])


def require_order(name: str, X: Array, misfit: Callable[[Array], float]) -> None:
    """Check that the poses do not fit much better with their quaternions in the other order.

    Args:
        name: of the poses, in the message.
        X: poses (N, 4, 4).
        misfit: residual of a fit to poses [m].

    Raises:
        RegistrationError: they do.
    """
    as_given = misfit(X)
    if as_given > _LARGE and misfit(reordered(X)) < _BETTER * as_given:
        raise RegistrationError(
            f"{name} have quaternions in the other order",
            why=f"as given, the residual is {1e3 * as_given:.0f} mm; read as x, y, z, w, less than a tenth of it",
            mend="name the quaternion's columns after their values: qw is the cosine of half the angle",
        )
