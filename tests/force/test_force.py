"""The force law against its closed form (Eqs 6 and 8)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core

finite = st.floats(-1, 1, allow_nan=False)
vec = st.tuples(finite, finite, finite).map(np.array)
positive = st.tuples(*[st.floats(0, 1000)] * 3).map(np.array)


def force(K, B, normal, delta_x, v_WT, v_surface=(0, 0, 0), **scales):
    """F, spring and damping force (3,) [N] of contacts at the tip."""
    rows = [np.atleast_2d(np.asarray(a, float)) for a in (K, B, normal, delta_x)]
    return _core.force(*rows, np.asarray(v_WT, float), np.atleast_2d(np.asarray(v_surface, float)), **scales)[:3]


def unit(v):
    return v / np.linalg.norm(v)


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("side", [1, -1])
def test_each_axis_has_its_own_stiffness_and_damping(axis, side):
    """F_i = K_i d_i and B_i v_i, to rounding."""
    K, B = np.array([300.0, 400.0, 500.0]), np.array([5.0, 6.0, 7.0])
    n = side * np.eye(3)[axis]
    F, spring, damping = force(K, B, n, 0.004 * n, -0.1 * n)
    np.testing.assert_allclose(spring, K[axis] * 0.004 * n, rtol=1e-14)
    np.testing.assert_allclose(damping, B[axis] * 0.1 * n, rtol=1e-14)
    np.testing.assert_array_equal(F, spring + damping)


def test_force_is_exactly_zero_in_free_space():
    none = np.zeros((0, 3))
    for term in _core.force(none, none, none, none, np.array([1.0, 2.0, 3.0]), none):
        assert not term.any()


def test_pushing_into_a_floor_pushes_up():
    F, *_ = force([500] * 3, [0] * 3, [0, 0, 1], [0, 0, 0.002], [0, 0, 0])
    np.testing.assert_allclose(F, [0, 0, 1.0], rtol=1e-14)


@settings(max_examples=300, deadline=None)
@given(K=positive, B=positive, n=vec, depth=st.floats(0, 0.05), side=vec, v=vec, v_surface=vec)
def test_force_never_pulls_and_damping_never_adds_power(K, B, n, depth, side, v, v_surface):
    if np.linalg.norm(n) < 1e-3:
        return
    n = unit(n)
    delta = depth * n + 0.1 * depth * (side - n * (n @ side))
    F, spring, damping = force(K, B, n, delta, v, v_surface)
    scale = max(1.0, np.abs(spring).max(), np.abs(damping).max())
    assert F @ n >= -1e-12 * scale
    assert damping @ (v - v_surface) <= 1e-12 * scale
    np.testing.assert_allclose(F, spring + damping, atol=1e-12 * scale)


def test_surface_that_moves_with_the_tool_does_not_damp():
    _, _, damping = force([500] * 3, [10] * 3, [0, 1, 0], [0, 0.01, 0], [0.1, 0.2, 0.3], [0.0, 0.2, 0.0])
    np.testing.assert_allclose(damping, 0, atol=1e-15)


def test_fast_retraction_gives_zero_force_instead_of_a_pull():
    F, spring, damping = force([500] * 3, [100] * 3, [0, 0, 1], [0, 0, 0.001], [0, 0, 5.0])
    np.testing.assert_allclose(F, 0, atol=1e-15)
    np.testing.assert_allclose(damping, -spring, atol=1e-15)


def test_scales_multiply_and_contact_forces_add():
    K, B = np.full((2, 3), 400.0), np.full((2, 3), 2.0)
    n = np.array([[1.0, 0, 0], [0, 1.0, 0]])
    _, spring, damping, _ = _core.force(K, B, n, 0.002 * n, np.array([-0.1, -0.2, 0]), np.zeros((2, 3)), 0.5, 3.0)
    np.testing.assert_allclose(spring, [0.4, 0.4, 0], rtol=1e-14)
    np.testing.assert_allclose(damping, [0.6, 1.2, 0], rtol=1e-14)


@settings(max_examples=200, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 8))
def test_torque_is_the_sum_over_the_levers_and_damping_never_adds_power(seed, n):
    """Torque about T = sum p_TS x F; damping acts on v + w x p_TS, so its power F . v + torque . w is <= 0."""
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    K, B = np.full((n, 3), 400.0), rng.uniform(0, 10, (n, 3))
    delta_x, p_TS = normals * rng.uniform(0, 0.01, (n, 1)), rng.normal(size=(n, 3)) * 0.05
    v, w, rest = rng.normal(size=3) * 0.1, rng.normal(size=3), np.zeros((n, 3))
    F, spring, damping, torque = _core.force(K, B, normals, delta_x, v, rest, w_WT=w, p_TS=p_TS)
    np.testing.assert_allclose(F, spring + damping)
    alone = [
        _core.force(*(a[i : i + 1] for a in (K, B, normals, delta_x)), v + np.cross(w, p_TS[i]), rest[:1])
        for i in range(n)
    ]
    np.testing.assert_allclose(F, sum(f for f, *_ in alone), atol=1e-12)
    np.testing.assert_allclose(torque, sum(np.cross(p, f) for p, (f, *_) in zip(p_TS, alone, strict=True)), atol=1e-12)
    t_damping = torque - sum(np.cross(p, s) for p, (_, s, *_) in zip(p_TS, alone, strict=True))
    assert damping @ v + t_damping @ w <= 1e-12
