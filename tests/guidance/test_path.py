"""Paths: nearest points against dense sampling, arc lengths against a circle, attitudes, crossings, ends."""

import numpy as np
import pytest
from effort import examples
from geometry_queries import assert_sound, slope
from geometry_queries import query_points as query
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from palpate import _guidance
from palpate.base.errors import GuidanceError
from palpate.scene.guidance.curve import path


def wander(seed, n=8, size=0.05):
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.normal(size=(n, 3)), axis=0) * size / n


def dense(points, closed=False, n=200_001):
    """Dense samples (n, 3) of the same spline, as a reference."""
    knots = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]
    curve = CubicSpline(knots, points, bc_type="periodic" if closed else "natural")
    return curve(np.linspace(0, knots[-1], n))


@settings(max_examples=examples(25))
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(3, 30))
def test_nearest_point_is_the_global_minimum(seed, n):
    """Reference: 200 001 samples. The distance is at most theirs, and smaller by at most half their spacing."""
    points = wander(seed, n)
    geometry = path(points, crossing=0.0)
    where = np.random.default_rng(seed).uniform(-0.1, 0.1, (300, 3)) + points.mean(axis=0)
    q = query(geometry, where)
    assert_sound(q)
    samples = dense(points)
    tree = cKDTree(samples, compact_nodes=False, balanced_tree=False)  # of sorted points: built in a moment
    found = tree.query(where)[0]
    gap = np.linalg.norm(np.diff(samples, axis=0), axis=1).max()
    assert (q["distance"] <= found + 1e-12).all()
    assert (found <= q["distance"] + 0.5 * gap + 1e-12).all()
    assert tree.query(q["point"])[0].max() <= gap


@settings(max_examples=examples(15))
@given(seed=st.integers(0, 2**32 - 1))
def test_distance_has_a_unit_gradient_along_the_normal(seed):
    points = wander(seed)
    geometry = path(points, crossing=0.0)
    near = dense(points, n=100) + np.random.default_rng(seed).normal(size=(100, 3)) * 1e-3
    q = query(geometry, near)
    shifted = [query(geometry, near + step)["point"] for step in 1e-6 * np.r_[np.eye(3), -np.eye(3)]]
    jumps = np.linalg.norm(np.array(shifted) - q["point"], axis=2).max(axis=0) > 1e-4
    assert jumps.mean() < 0.1
    # A difference over h errs by about (h / distance)^2: beside the path itself it says nothing about the normal.
    judged = ~jumps & (q["distance"] > 1e-5)
    assert judged.mean() > 0.8
    np.testing.assert_allclose(slope(geometry, near, 2e-8)[judged], q["normal"][judged], atol=1e-5)
    inner = (q["dimension"] == 1) & ~jumps
    assert abs((q["basis"][inner][:, :, 0] * q["normal"][inner]).sum(axis=1)).max() < 1e-9


def circle(n=60, radius=0.03):
    a = np.linspace(0, 2 * np.pi, n, endpoint=False)
    return radius * np.c_[np.cos(a), np.sin(a), 0 * a]


def test_closed_path_through_a_circle_has_its_length_and_no_ends():
    geometry = path(circle(), closed=True)
    assert geometry.length == pytest.approx(2 * np.pi * 0.03, rel=1e-6)
    a = np.linspace(0.1, 2 * np.pi, 500, endpoint=False)
    where = np.c_[0.04 * np.cos(a), 0.04 * np.sin(a), 0.01 + 0 * a]
    q = query(geometry, where)
    assert (q["dimension"] == 1).all()
    np.testing.assert_allclose(q["distance"], np.hypot(0.01, 0.01), atol=1e-7)
    np.testing.assert_allclose(q["along"], 0.03 * a, atol=1e-6)
    tangent = np.c_[-np.sin(a), np.cos(a), 0 * a]
    np.testing.assert_allclose(q["basis"][:, :, 0], tangent, atol=1e-4)


def test_arc_length_agrees_with_the_sampled_curve():
    points = wander(4, 12)
    geometry = path(points, crossing=0.0)
    samples = dense(points)
    along = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(samples, axis=0), axis=1))]
    assert geometry.length == pytest.approx(along[-1], rel=1e-9)
    np.testing.assert_allclose(query(geometry, samples[::777])["along"], along[::777], atol=1e-9)


def test_path_is_a_point_beyond_its_ends():
    geometry = path([[0, 0, 0], [0.01, 0, 0], [0.02, 0, 0]])
    q = query(geometry, [[-0.01, 0, 0], [0.005, 0.001, 0], [0.03, 0, 0.01]])
    np.testing.assert_array_equal(q["dimension"], [0, 1, 0])
    np.testing.assert_allclose(q["point"], [[0, 0, 0], [0.005, 0, 0], [0.02, 0, 0]], atol=1e-15)
    np.testing.assert_allclose(q["along"], [0, 0.005, 0.02], atol=1e-15)
    np.testing.assert_allclose(path([[0, 0, 0], [0.02, 0.01, 0]]).length, np.hypot(0.02, 0.01), rtol=1e-14)


def test_attitudes_follow_the_tangent_or_the_recording():
    points = dense(wander(3), n=9)
    samples = dense(points, n=2000)[1:-1]
    q = query(path(points, crossing=0.0), samples)
    np.testing.assert_allclose(q["attitude"][:, :, 2], q["basis"][:, :, 0], atol=1e-9)
    turned, bent = (np.linalg.norm(np.diff(a.reshape(len(a), -1), axis=0), axis=1) for a in
                    (q["attitude"], q["basis"][:, :, 0]))  # fmt: skip
    assert (turned <= 1.5 * bent + 1e-9).all(), "the attitude turns no more than the tangent"
    R = Rotation.from_rotvec(np.linspace(0, 1, 9)[:, None] * [0.5, -1.0, 0.2]).as_matrix()
    recorded = query(path(points, R, crossing=0.0), points)
    np.testing.assert_allclose(recorded["attitude"], R, atol=1e-6)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-7, 1e-3, 1.0, 3.0])
@pytest.mark.parametrize("seed", range(5))
def test_attitudes_opposite_to_the_tangent_turn_by_half_a_turn(angle, seed):
    """The rotation to the tangent is a rotation, turns z into the tangent, and is the smallest that does."""
    u, aside = Rotation.random(random_state=seed).as_matrix()[:2]
    z = -np.cos(angle) * u + np.sin(angle) * aside
    R, _ = Rotation.align_vectors(z, [0, 0, 1])
    line = np.linspace(0, 0.03, 4)[:, None] * u
    straight = _guidance.PathGeometry(line[None], np.stack([R.as_matrix()] * 2), True, False)
    (found,) = query(straight, line[1:2])["attitude"]
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-9)  # 1 + cos is known to 1e-16, and is 5e-7
    np.testing.assert_allclose(found[:, 2], u, atol=1e-7)
    assert np.linalg.det(found) == pytest.approx(1.0)
    assert Rotation.from_matrix(found @ R.as_matrix().T).magnitude() == pytest.approx(np.pi - angle, abs=1e-6)


def test_frame_along_a_plane_curve_has_no_twist():
    q = query(path(circle()[:40]), circle()[1:39])
    assert np.ptp(q["attitude"][:, 2, :2], axis=0).max() < 1e-6, "x and y out of the plane are constant"


@pytest.mark.parametrize(
    ("points", "options", "message"),
    [
        ([[0, 0, 0]], {}, r"a path needs waypoints, two or more apart; 1 are given"),
        ([[0, 0, 0], [0, 0, 0]], {}, "two or more apart"),
        ([[0, 0, 0], [0.01, 0, 0]], {"closed": True}, "three or more apart"),
        ([[0, 0], [1, 1]], {}, r"of shape \(n, 3\). Got: \(2, 2\)"),
        ([[0, 0, np.nan], [1, 1, 1]], {}, "must be finite"),
        ([[0, 0, 0], [30.0, 0, 0]], {}, r"30 m long\n  why: waypoints are in metres here\n  mend: is the unit mm"),
        ([[0, 0, 0], [2, 2, 0], [2, 0, 0], [0, 2, 0]], {}, r"the path crosses itself at \(.*\) mm, .* from its start"),
    ],
)
def test_invalid_paths_are_reported(points, options, message):
    scale = 1.0 if np.nanmax(points) > 10 else 0.01
    with pytest.raises(GuidanceError, match=message):
        path(np.array(points, float) * scale, **options)


def test_crossing_of_a_path_can_be_allowed():
    assert path(0.01 * np.array([[0, 0, 0], [2, 2, 0], [2, 0, 0], [0, 2, 0.0]]), crossing=0.0).length > 0.05
