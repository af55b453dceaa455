"""The exponential of a small matrix, without scipy, whose import takes longer than the certificate of a scene."""

from __future__ import annotations

import math

import numpy as np

from palpate.base.arrays import Array

_ORDER = 13
_LARGEST = 5.371920351148152  # 1-norm up to which the approximant of this order is exact to rounding (Higham 2005)
#: Coefficients of the numerator of the diagonal Pade approximant of e^x; the denominator's alternate in sign.
_PADE = [math.comb(_ORDER, k) / math.perm(2 * _ORDER, k) for k in range(_ORDER + 1)]


def expm(A: Array) -> Array:
    """``e^A`` of a square matrix (n, n), by scaling and squaring (Higham, SIAM J. Matrix Anal. Appl. 26, 2005).

    A is halved until its 1-norm is at most 5.37, where the Pade approximant of order 13 is exact to rounding. The
    approximant is then squared once per halving.
    """
    norm = float(np.abs(A).sum(axis=0).max())
    halvings = math.ceil(math.log2(max(norm / _LARGEST, 1.0)))
    X = A / 2.0**halvings
    X2 = X @ X
    even, odd = _PADE[_ORDER - 1] * np.eye(len(A)), _PADE[_ORDER] * np.eye(len(A))
    for k in range(_ORDER - 3, -1, -2):  # Horner's scheme in X^2, separately for even and odd powers
        even, odd = even @ X2 + _PADE[k] * np.eye(len(A)), odd @ X2 + _PADE[k + 1] * np.eye(len(A))
    odd = X @ odd
    E = np.linalg.solve(even - odd, even + odd)
    for _ in range(halvings):
        E = E @ E
    return np.asarray(E)
