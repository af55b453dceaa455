"""Queries with extreme numbers: a valid result or none, never an access outside the memory."""

import numpy as np
import pytest

from palpate import _core
from palpate.mesh import Mesh
from palpate.shapes import analytic


@pytest.mark.parametrize("far", [1e30, 1e100, 1e155, 1e300])
def test_extremely_distant_points(far):
    mesh = Mesh(*analytic.Sphere().mesh(1000))
    distance, point, _, triangle = mesh.closest([[far, 0, 0], [0, -far, far]], np.inf)
    assert ((triangle >= -1) & (triangle < len(mesh.triangles))).all()
    assert np.isfinite(point[triangle >= 0]).all()
    assert not np.isnan(distance).any()


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf])
def test_invalid_point_has_no_nearest_point(number):
    mesh = _core.Mesh(*analytic.Sphere().mesh(1000))
    distance, _, _, triangle = mesh.closest(np.array([[number, 0.0, 0.0], [0.0, 0.0, number]]), np.inf)
    assert (triangle == -1).all()
    assert not (distance < np.inf).any()
