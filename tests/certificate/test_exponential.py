"""The exponential of a matrix against scipy's, and against a rotation in closed form."""

import numpy as np
import pytest
from scipy import linalg

from palpate.devices.certificate.exponential import expm


@pytest.mark.parametrize("size", [1e-8, 1e-3, 1.0, 5.0, 20.0])
def test_agrees_with_scipy(size):
    rng = np.random.default_rng(7)
    for n in range(1, 9):
        A = rng.normal(size=(n, n))
        A *= size / np.abs(A).sum(axis=0).max()
        theirs = linalg.expm(A)
        np.testing.assert_allclose(expm(A), theirs, rtol=0.0, atol=1e-13 * np.abs(theirs).max() * max(1.0, size))


@pytest.mark.parametrize("angle", [0.0, 0.3, 3.0, 40.0])
def test_exponential_of_a_skew_matrix_is_a_rotation(angle):
    c, s = np.cos(angle), np.sin(angle)
    np.testing.assert_allclose(expm(np.array([[0.0, -angle], [angle, 0.0]])), [[c, -s], [s, c]], atol=1e-13)
