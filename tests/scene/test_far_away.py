"""Queries with extreme numbers: a valid result or none, never an access outside the memory."""

import numpy as np
import pytest

from palpate import _core
from palpate.world.mesh import Mesh
from palpate.world.shapes import analytic


@pytest.mark.parametrize("far", [1e30, 1e100, 1e155, 1e300])
def test_extremely_distant_points(far):
    mesh = Mesh(*analytic.Sphere().mesh(1000))
    distance, point, _, triangle = mesh.closest([[far, 0, 0], [0, -far, far]], np.inf)
    assert ((triangle >= -1) & (triangle < len(mesh.triangles))).all()
    assert np.isfinite(point[triangle >= 0]).all()
    assert not np.isnan(distance).any()


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("far", [1e16, 1e19, 1e38, 1e39, 1e100, 1e300])
def test_mesh_of_one_triangle_is_far_from_distant_points(far, sign):
    """Seven of the eight children of its only node are unused: a query of a point at -1e39 m visited them."""
    mesh = _core.Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]], np.int32))
    distance, _, _, triangle = mesh.closest(np.full((1, 3), sign * far), np.inf)
    assert triangle[0] in (-1, 0)
    assert distance[0] == np.inf or distance[0] == pytest.approx(np.sqrt(3) * far)


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf])
def test_invalid_point_has_no_nearest_point(number):
    mesh = _core.Mesh(*analytic.Sphere().mesh(1000))
    distance, _, _, triangle = mesh.closest(np.array([[number, 0.0, 0.0], [0.0, 0.0, number]]), np.inf)
    assert (triangle == -1).all()
    assert not (distance < np.inf).any()
