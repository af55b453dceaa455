"""Whether the errors of rows that were recorded one after the other are alike: `remarks`."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array

_LEVEL = 0.01  # probability with which independent errors are called alike
_DRAWS, _EFFORT = 1000, 2_000_000  # most random orders, and rows in all of them
_LEAST = 8  # fewest rows
_NEAR = 5  # rows apart from which on two do not count as neighbours
_EXACT = 1e-12  # residual that is rounding alone


def remarks(residuals: Array) -> tuple[str, ...]:
    """A sentence if the residuals (n, k) of neighbouring rows are more alike than those of any two.

    Something that drifts while it is recorded, or rows that follow each other faster than the noise changes, hold less
    than rows with independent errors, as which the covariances count them. The statistic is the sum of the products of
    neighbours, weighted by their distance (Bartlett's window); it is compared with that of rows in random order.
    """
    n = len(residuals)
    r = residuals.reshape(n, -1)
    if n < _LEAST or float(np.abs(r).max()) < _EXACT:
        return ()
    rng, draws = np.random.default_rng(0), int(np.clip(_EFFORT // n, 200, _DRAWS))
    found = _alike(r)
    as_much = sum(_alike(r[rng.permutation(n)]) >= found for _ in range(draws))
    if (1.0 + as_much) / (1.0 + draws) >= _LEVEL:
        return ()
    return (
        "the errors of neighbouring rows are alike: something drifted meanwhile, or the rows follow each other "
        "too fast; the predicted error takes them as independent and is too small",
    )


def _alike(r: Array) -> float:
    """Sum of the products of neighbouring rows of r (n, k), weighted by their distance."""
    return sum((1.0 - k / _NEAR) * float(np.vdot(r[:-k], r[k:])) for k in range(1, _NEAR))
