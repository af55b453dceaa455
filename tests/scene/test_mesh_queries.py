"""The wide BVH against brute force; meshes that build() corrects, keeps and rejects."""

import numpy as np
import pytest
from brute_force import distance_by_segments_and_planes
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core
from palpate.world.shapes.analytic import SHAPES


@pytest.mark.parametrize("triangles", [12, 1000, 20_000])
@pytest.mark.parametrize("name", sorted(SHAPES))
def test_closest_point_agrees_with_brute_force(name, triangles):
    vertices, faces = SHAPES[name].mesh(triangles)
    points = np.random.default_rng(1).uniform(-0.06, 0.06, (100, 3))
    distance, point, normal, triangle = _core.Mesh(vertices, faces).closest(points)
    np.testing.assert_allclose(distance, distance_by_segments_and_planes(vertices, faces, points), rtol=0, atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(points - point, axis=1), distance, rtol=0, atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, atol=1e-12)
    on = distance_by_segments_and_planes(vertices, faces[triangle[:1]], point[:1])
    assert on[0] < 1e-15  # the returned triangle contains the returned point


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 400), exponent=st.integers(-6, 6))
def test_closest_point_in_random_soups_agrees_with_brute_force(seed, n, exponent):
    rng = np.random.default_rng(seed)
    scale = 10.0**exponent
    vertices = scale * rng.normal(size=(3 * n, 3)) + scale * rng.normal(size=3) * rng.choice([0, 100])
    vertices[rng.integers(0, 3 * n, n // 3)] = vertices[0]  # repeated corners
    triangles = np.arange(3 * n, dtype=np.int32).reshape(-1, 3)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    surface = ~((a == b).all(1) | (b == c).all(1) | (c == a).all(1))  # the others are lines, which are dropped
    if not surface.any():
        return
    points = vertices[rng.integers(0, 3 * n, 20)] + scale * rng.normal(size=(20, 3))
    distance = _core.Mesh(vertices, triangles).closest(points)[0]
    truth = distance_by_segments_and_planes(vertices, triangles[surface], points)
    np.testing.assert_allclose(distance, truth, rtol=1e-12, atol=1e-13 * np.abs(vertices).max())


def test_kernels_agree():
    vertices, faces = SHAPES["torus"].mesh(20_000)
    mesh = _core.Mesh(vertices, faces)
    points = np.random.default_rng(2).uniform(-0.06, 0.06, (2000, 3))
    if not _core.bvh_has_avx2():
        pytest.skip("this machine has no AVX2: the portable kernel is the only one")
    fast, portable = mesh.closest_by_kernel(points, "avx2"), mesh.closest_by_kernel(points, "portable")
    np.testing.assert_allclose(fast, portable, rtol=1e-12, atol=1e-16)


def test_nothing_is_found_beyond_max_distance():
    mesh = _core.Mesh(*SHAPES["sphere"].mesh(1000))
    distance, _, _, triangle = mesh.closest(np.array([[0.1, 0.0, 0.0], [0.031, 0.0, 0.0]]), 0.005)
    assert np.isinf(distance[0])
    assert triangle[0] == -1
    assert triangle[1] >= 0


def test_normals_distinguish_inside_and_outside():
    for name in ("sphere", "torus", "box", "plate"):
        shape = SHAPES[name]
        mesh = _core.Mesh(*shape.mesh(20_000))
        points = np.random.default_rng(3).uniform(-0.05, 0.05, (2000, 3))
        phi, _ = shape.distance(points)
        clear = np.abs(phi) > 1e-4  # the distance of facets to the true surface is smaller
        np.testing.assert_array_equal(mesh.contains(points[clear]), phi[clear] < 0)


def test_soup_is_welded_and_reported():
    vertices, faces = SHAPES["box"].mesh(3000)
    soup = vertices[faces].reshape(-1, 3)
    triangles = np.arange(len(soup), dtype=np.int32).reshape(-1, 3)
    extra = np.concatenate([triangles, triangles[:7], [[0, 0, 1]]]).astype(np.int32)
    report = _core.Mesh(soup, extra).report
    assert (report.duplicate, report.degenerate, report.triangles) == (7, 1, len(faces))
    assert report.closed
    assert report.vertices == len(faces) // 2 + 2  # Euler
    assert report.volume == pytest.approx(0.04**3, rel=1e-12)


def test_open_branching_and_inconsistent_edges_are_counted():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]], float)
    sheet = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    report = _core.Mesh(square, sheet).report
    assert (report.boundary_edges, report.inconsistent_edges, report.closed) == (4, 0, False)
    against = _core.Mesh(square, np.array([[0, 1, 2], [0, 3, 2]], np.int32)).report
    assert (against.turned, against.inconsistent_edges) == (1, 0)
    assert _core.Mesh(square, np.array([[0, 1, 2], [0, 2, 3], [0, 2, 4]], np.int32)).report.branching_edges == 1


def test_inside_out_mesh_is_corrected():
    vertices, faces = SHAPES["sphere"].mesh(1000)
    mesh = _core.Mesh(vertices, np.ascontiguousarray(faces[:, ::-1]))
    assert mesh.report.inverted
    assert mesh.report.volume > 0
    assert mesh.closest(np.array([[0.04, 0.0, 0.0]]))[2][0, 0] > 0.99


@pytest.mark.parametrize(
    ("vertices", "triangles", "message"),
    [
        (np.eye(3), np.zeros((0, 3), np.int32), "no triangles"),
        (np.eye(3), np.array([[0, 1, 3]], np.int32), "triangle 0 names vertex 3"),
        (np.eye(3), np.array([[0, 1, -1]], np.int32), "names vertex -1"),
        (np.array([[0, 0, 0], [1, 0, np.nan], [0, 1, 0]]), np.array([[0, 1, 2]], np.int32), "vertex 1 is not finite"),
        (np.eye(3), np.array([[0, 0, 1]], np.int32), "all 1 triangles are degenerate"),
    ],
)
def test_invalid_meshes_are_rejected(vertices, triangles, message):
    with pytest.raises(ValueError, match=message):
        _core.Mesh(vertices, triangles)


def test_sweep_stops_before_the_surface_and_misses_nothing():
    mesh = _core.Mesh(*SHAPES["plate"].mesh(2000))
    above, below = np.array([0.001, 0.002, 0.05]), np.array([0.001, 0.002, -0.05])
    for radius in (1e-4, 1e-3, 5e-3):
        gone = mesh.sweep(above, below, radius)
        reach = 0.05 - 0.0005 - radius
        assert reach - 0.06 * radius <= gone <= reach + 1e-12
    offset = np.array([0.05, 0.0, 0.0])
    assert mesh.sweep(above + offset, below + offset, 1e-3) == pytest.approx(0.1)
