"""Query results are independent of position, scale and order of the triangles."""

import numpy as np
import pytest
from brute_force import distance_by_segments_and_planes
from effort import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core
from palpate.world.shapes.analytic import SHAPES


def rotation(rng) -> np.ndarray:
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def degenerate_mesh(rng, n: int) -> tuple[np.ndarray, np.ndarray]:
    """A mesh of n triangles with needles, caps, duplicates, T-junctions and edges of many triangles."""
    v = rng.normal(size=(3 * n, 3))
    t = np.arange(3 * n).reshape(-1, 3)
    kind = rng.integers(0, 5, n)
    along = rng.uniform(size=(n, 1))
    line = v[t[:, 0]] + along * (v[t[:, 1]] - v[t[:, 0]])
    v[t[kind == 1, 2]] = line[kind == 1] + 10.0 ** rng.uniform(-16, -6) * rng.normal(size=3)  # caps
    v[t[kind == 2, 1]] = v[t[kind == 2, 0]] + 10.0 ** rng.uniform(-14, -6) * rng.normal(size=3)  # needles
    t[kind == 3, :2] = t[0, :2]  # fans around one edge
    extra = t[rng.integers(0, n, n // 4)]
    return v, np.concatenate([t, extra, extra[:, [0, 2, 1]]]).astype(np.int32)


@settings(max_examples=examples(60), deadline=None)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 200), exponent=st.integers(-6, 6))
def test_closest_point_agrees_with_brute_force_on_damaged_meshes(seed, n, exponent):
    rng = np.random.default_rng(seed)
    v, t = degenerate_mesh(rng, n)
    v *= 10.0**exponent
    points = 10.0**exponent * rng.normal(size=(20, 3))
    points[:5] = v[rng.integers(0, len(v), 5)]  # on the surface itself
    mesh = _core.Mesh(v, t)
    distance, point, normal, triangle = mesh.closest(points)
    truth = distance_by_segments_and_planes(mesh.vertices, mesh.triangles, points)
    size = np.abs(v).max()
    np.testing.assert_allclose(distance, truth, rtol=1e-9, atol=1e-12 * size)
    on = [distance_by_segments_and_planes(mesh.vertices, mesh.triangles[i : i + 1], p[None])[0]
          for i, p in zip(triangle, point, strict=True)]  # fmt: skip
    np.testing.assert_allclose(on, 0.0, atol=1e-12 * size)
    assert np.isfinite(normal).all()
    if _core.bvh_has_avx2():
        kernels = (mesh.closest_by_kernel(points, name) for name in ("avx2", "portable"))
        np.testing.assert_allclose(*kernels, rtol=1e-9, atol=1e-12 * size)


@settings(max_examples=examples(30), deadline=None)
@given(seed=st.integers(0, 2**32 - 1), name=st.sampled_from(sorted(SHAPES)))
def test_queries_move_with_the_mesh(seed, name):
    rng = np.random.default_rng(seed)
    v, t = SHAPES[name].mesh(1000)
    R, p, scale = rotation(rng), rng.normal(size=3), 2.0 ** rng.integers(-12, 13)
    points = rng.uniform(-0.06, 0.06, (50, 3))
    original, moved = _core.Mesh(v, t), _core.Mesh(scale * (v @ R.T + p), t[rng.permutation(len(t))])
    d, _, _ = original.nearest(points)
    d_moved, q_moved, n_moved = moved.nearest(scale * (points @ R.T + p))
    np.testing.assert_allclose(np.abs(d_moved), scale * np.abs(d), rtol=1e-9, atol=1e-12 * scale)
    clear = np.abs(d) > 1e-9  # on the surface the sign is arbitrary
    np.testing.assert_array_equal(np.sign(d_moved[clear]), np.sign(d[clear]))
    np.testing.assert_allclose(np.linalg.norm(n_moved, axis=1), 1.0, atol=1e-9)
    feet = distance_by_segments_and_planes(scale * (v @ R.T + p), t, q_moved)  # there may be two nearest points
    np.testing.assert_allclose(feet, 0.0, atol=1e-12 * scale)


def winding_number(v, t, points) -> np.ndarray:
    """Sum of the solid angles over 4 pi (van Oosterom and Strackee 1983): 1 inside, 0 outside."""
    a, b, c = (v[t[:, k]][None] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=2) for x in (a, b, c))
    dot = lambda x, y: np.einsum("ijk,ijk->ij", x, y)  # noqa: E731
    omega = 2 * np.arctan2(dot(a, np.cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)
    return omega.sum(axis=1) / (4 * np.pi)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), name=st.sampled_from(["sphere", "torus", "box", "plate"]))
def test_sign_agrees_with_the_winding_number(seed, name):
    """Closed deformed meshes with sharp ridges, where the nearest feature is often an edge or a vertex."""
    rng = np.random.default_rng(seed)
    v, t = SHAPES[name].mesh(120)
    mesh = _core.Mesh(v + rng.normal(scale=2e-4 if name == "plate" else 2e-3, size=v.shape), t)
    if not mesh.report.closed:  # the doubled edges of the plate have separated
        mesh = _core.Mesh(v * rng.uniform(0.5, 2.0, 3), t)
    points = rng.uniform(-0.05, 0.05, (200, 3))
    turns = np.round(winding_number(mesh.vertices, mesh.triangles, points))
    if np.isin(turns, (0, 1)).all():  # otherwise the deformed surface intersects itself
        np.testing.assert_array_equal(mesh.nearest(points)[0] < 0, turns == 1)


@pytest.mark.parametrize("name", ["sphere", "box"])
def test_both_kernels_find_the_same_point(name):
    if not _core.bvh_has_avx2():
        pytest.skip("this machine has no AVX2: the portable kernel is the only one")
    mesh = _core.Mesh(*SHAPES[name].mesh(5000))
    for scale in (1e-3, 1.0, 1e3):  # distant and near points
        points = np.random.default_rng(4).normal(size=(500, 3)) * 0.05 * scale
        fast, portable = (mesh.closest_by_kernel(points, kernel) for kernel in ("avx2", "portable"))
        np.testing.assert_allclose(fast, portable, rtol=1e-12, atol=1e-16)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), bumps=st.floats(0.0, 0.3), exponent=st.integers(-30, 20))
def test_closest_point_agrees_with_brute_force_on_fine_patches(seed, bumps, exponent):
    """The tight bound of a small smooth patch must contain the whole patch, for any size and position."""
    rng = np.random.default_rng(seed)
    n = 24
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n), indexing="ij")
    z = bumps * (np.sin(3 * x + rng.uniform(0, 6)) * np.cos(2 * y) + rng.uniform(-1, 1) * x * y)
    z += rng.choice([0.0, 1e-3, 1e-1]) * rng.normal(size=z.shape)
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    t = np.concatenate([np.c_[a, a + n, a + 1], np.c_[a + 1, a + n, a + n + 1]])
    R, scale = rotation(rng), 2.0**exponent
    v = np.stack([x, y, z], axis=-1).reshape(-1, 3) @ R.T + rng.choice([0.0, 10.0]) * rng.normal(size=3)
    feet = v[rng.integers(0, len(v), 60)]
    away = 10.0 ** rng.uniform(-9, 1, (60, 1)) * rng.normal(size=(60, 3))
    points = scale * np.concatenate([feet, feet + away, 1e4 * rng.normal(size=(3, 3))])
    mesh = _core.Mesh(scale * v, t[rng.permutation(len(t))].astype(np.int32))
    truth = distance_by_segments_and_planes(mesh.vertices, mesh.triangles, points)
    kernels = ["portable", "avx2"] if _core.bvh_has_avx2() else ["portable"]
    for kernel in kernels:
        found = mesh.closest_by_kernel(points, kernel)
        np.testing.assert_allclose(found, truth, rtol=1e-12, atol=1e-14 * scale * np.abs(v).max())


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), name=st.sampled_from(sorted(SHAPES)), spacing=st.floats(1e-4, 2e-2))
def test_grid_sampling_equals_queries_at_every_node(seed, name, spacing):
    """This holds also if the nearest triangles of neighbouring nodes are far apart."""
    rng = np.random.default_rng(seed)
    mesh = _core.Mesh(*SHAPES[name].mesh(2000))
    origin, steps = rng.uniform(-0.05, 0.03, 3), spacing * rng.uniform(0.5, 1.0, 3)
    values = np.full((7, 8, 9), np.nan, np.float32)
    _core.sample_distance(mesh, origin, steps, values)
    queried = mesh.nearest(origin + steps * np.moveaxis(np.indices(values.shape), 0, -1).reshape(-1, 3))[0]
    clear = np.abs(queried) > 1e-9  # on the surface the sign is arbitrary
    np.testing.assert_allclose(values.ravel()[clear], queried[clear], rtol=1e-6)
    np.testing.assert_allclose(values.ravel()[~clear], 0.0, atol=1e-8)
