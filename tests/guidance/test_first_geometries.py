"""Queries of point, line and plane: closed forms, finite differences, a change of frame, extreme numbers."""

import threading

import numpy as np
import pytest
from geometry_queries import poses, query_points
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from palpate import _core, _guidance

A, B = np.array([0.01, -0.02, 0.03]), np.array([-0.04, 0.05, 0.0])
U = (B - A) / np.linalg.norm(B - A)


def to_line(p):
    return np.linalg.norm(np.cross(p - A, U), axis=1)


def to_segment(p):
    along = np.clip((p - A) @ U, 0.0, np.linalg.norm(B - A))
    return np.linalg.norm(p - A - along[:, None] * U, axis=1)


CLOSED = {
    "point": (_guidance.PointGeometry(), lambda p: np.linalg.norm(p, axis=1)),
    "line": (_guidance.LineGeometry(A, B, True), to_line),
    "segment": (_guidance.LineGeometry(A, B), to_segment),
    "plane": (_guidance.SurfaceGeometry(_core.Plane()), lambda p: p[:, 2]),
    "sphere": (_guidance.SurfaceGeometry(_core.Sphere(0.03)), lambda p: np.linalg.norm(p, axis=1) - 0.03),
}
POINTS = np.random.default_rng(1).uniform(-0.1, 0.1, (2000, 3))


@pytest.mark.parametrize("name", CLOSED)
def test_distance_has_the_closed_form_and_the_normal_is_its_gradient(name):
    geometry, exact = CLOSED[name]
    q = query_points(geometry, POINTS)
    np.testing.assert_allclose(q["distance"], exact(POINTS), atol=1e-15)
    np.testing.assert_allclose(q["point"] + q["distance"][:, None] * q["normal"], POINTS, atol=1e-15)
    h = 1e-6
    numeric = np.stack([(exact(POINTS + h * e) - exact(POINTS - h * e)) / (2 * h) for e in np.eye(3)], axis=1)
    np.testing.assert_allclose(q["normal"], numeric, atol=1e-6)


@pytest.mark.parametrize("name", CLOSED)
def test_basis_is_a_rotation_whose_last_column_is_the_normal(name):
    q = query_points(CLOSED[name][0], POINTS)
    for R in (q["basis"], q["attitude"]):
        np.testing.assert_allclose(R @ R.transpose(0, 2, 1), np.tile(np.eye(3), (len(R), 1, 1)), atol=1e-14)
        np.testing.assert_allclose(np.linalg.det(R), 1.0, atol=1e-14)
    np.testing.assert_array_equal(q["basis"][:, :, 2], q["normal"])


def test_line_leaves_one_direction_free_and_its_ends_none():
    q = query_points(CLOSED["segment"][0], POINTS)
    along = (POINTS - A) @ U
    inside = (along > 0) & (along < np.linalg.norm(B - A))
    assert 0.2 < inside.mean() < 0.8
    np.testing.assert_array_equal(q["dimension"], inside)
    np.testing.assert_allclose(q["basis"][inside][:, :, 0], np.tile(U, (inside.sum(), 1)), atol=1e-14)
    np.testing.assert_allclose(q["attitude"][:, :, 2], np.tile(U, (len(POINTS), 1)), atol=1e-14)
    np.testing.assert_allclose(q["along"], np.clip(along, 0.0, np.linalg.norm(B - A)), atol=1e-15)
    assert (query_points(CLOSED["line"][0], POINTS)["dimension"] == 1).all()


@pytest.mark.parametrize("name", CLOSED)
def test_queries_are_independent_of_the_frame(name):
    """If geometry and tool are moved together, the result moves with them."""
    geometry, _ = CLOSED[name]
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix(), [0.3, -0.2, 0.1]
    placed = _guidance.PlacedGeometry(geometry, np.eye(4), _core.MotionFrame(X))
    one, other = query_points(geometry, POINTS), placed.query(X @ poses(POINTS), np.zeros(len(POINTS)))
    np.testing.assert_allclose(other["distance"], one["distance"], atol=1e-15)
    np.testing.assert_allclose(other["along"], one["along"], atol=1e-15)
    np.testing.assert_allclose(other["normal"], one["normal"] @ X[:3, :3].T, atol=1e-11)
    np.testing.assert_allclose(other["point"], one["point"] @ X[:3, :3].T + X[:3, 3], atol=1e-15)
    np.testing.assert_allclose(other["attitude"], X[:3, :3] @ one["attitude"], atol=1e-14)


def test_velocity_and_spin_on_a_moving_frame_are_those_of_its_material():
    """Reference: finite differences of the frame's pose at the nearest point."""
    wave = _core.Wave(shift=np.array([0.01, 0.0, 0.02]), turn=np.array([0.3, 0.2, -0.4]), period=2.0, phase=0.3)
    motion = _core.Motion(
        v=np.array([0.01, 0, 0]), w=np.array([0.1, 0.5, 0]), waves=[wave], about=np.array([0, 0.1, 0])
    )
    frame = _core.MotionFrame(np.eye(4), motion)
    X_FG = np.eye(4)
    X_FG[:3, 3] = [0.02, 0.01, -0.03]
    placed = _guidance.PlacedGeometry(_guidance.SurfaceGeometry(_core.Sphere(0.03)), X_FG, frame)
    for t in (0.0, 0.37, 1.9):
        q = query_points(placed, POINTS[:50], t)
        h = 1e-5
        before, now, after = (frame.at(s)[0] for s in (t - h, t, t + h))
        rate = (after - before) / (2 * h) @ np.linalg.inv(now)
        material = np.c_[q["point"], np.ones(50)] @ rate.T
        np.testing.assert_allclose(q["velocity"], material[:, :3], atol=1e-9)
        np.testing.assert_allclose(q["spin"], np.tile([rate[2, 1], rate[0, 2], rate[1, 0]], (50, 1)), atol=1e-8)
        np.testing.assert_allclose(frame.at(t)[1][:3], (after - before)[:3, 3] / (2 * h), atol=1e-9)


def test_live_frame_has_the_last_received_pose():
    frame = _core.LiveFrame()
    placed = _guidance.PlacedGeometry(_guidance.PointGeometry(), np.eye(4), frame)
    assert query_points(placed, [[0, 0, 0.1]])["distance"] == 0.1
    X = np.eye(4)
    X[:3, 3] = [0, 0, 0.1]
    frame.set(X, [1, 2, 3, 0, 0, 1])
    q = query_points(placed, [[0, 0, 0.3]], 5.0)
    np.testing.assert_allclose([q["distance"][0], *q["velocity"][0], *q["spin"][0]], [0.2, 1, 2, 3, 0, 0, 1])
    with pytest.raises(ValueError, match=r"V_WF must be six finite numbers: linear \[m/s\] over angular"):
        frame.set(X, [np.nan, 0, 0, 0, 0, 0])


def test_concurrent_reads_of_a_live_frame_are_consistent():
    """All entries of pose and velocity carry the same number, so a mixture of two updates would show."""
    frame, stop, torn = _core.LiveFrame(), threading.Event(), []

    def keep_querying():
        while not stop.is_set():
            X, V = frame.at(0.0)
            if not X[0, 3] == X[1, 3] == X[2, 3] == V[0] == V[5]:
                torn.append((X, V))

    frame.set(np.eye(4), np.zeros(6))
    threads = [threading.Thread(target=keep_querying) for _ in range(3)]
    for thread in threads:
        thread.start()
    for i in range(20_000):
        X = np.eye(4)
        X[:3, 3] = i
        frame.set(X, np.full(6, float(i)))
    stop.set()
    for thread in threads:
        thread.join()
    assert torn == []


def test_geometry_attached_to_the_tool_moves_with_it():
    frame = _core.LiveFrame()
    X_FG = np.eye(4)
    X_FG[:3, 3] = [0.01, 0.0, 0.0]
    ahead = _guidance.Fixture("ahead", _guidance.PlacedGeometry(_guidance.PointGeometry(), X_FG, frame), "guide")
    stage, fixtures = _guidance.Guidance(), _guidance.Fixtures([ahead], frame)
    stage.take(fixtures)
    for i in range(500):
        X_WT = np.eye(4)
        X_WT[:3, 3] = [1e-4 * i, 0.02, 0.0]
        stage.step(1e-3 * i, X_WT, [0.1, 0, 0, 0, 0, 0], X_WT)
        assert stage.gap(0) == pytest.approx(-0.01)
    np.testing.assert_allclose(stage.wrench(0)[:3], [4.0, 0, 0], atol=1e-9)


@given(p=st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=3, max_size=3), t=st.floats(0, 1e300))
def test_every_finite_pose_has_a_finite_result(p, t):
    frame = _core.MotionFrame(np.eye(4), _core.Motion(v=np.array([0.01, 0, 0]), w=np.array([0, 0.5, 0])))
    for geometry, _ in CLOSED.values():
        for queried in (geometry, _guidance.PlacedGeometry(geometry, np.eye(4), frame)):
            q = query_points(queried, [p], t)
            assert all(np.isfinite(values).all() for values in q.values())
            np.testing.assert_allclose(np.linalg.norm(q["normal"]), 1.0, atol=1e-9)


@pytest.mark.parametrize(("a", "b"), [(A, A), (A, A * np.nan)])
def test_line_needs_two_different_points(a, b):
    with pytest.raises(ValueError, match="a line needs two places that are finite and apart"):
        _guidance.LineGeometry(a, b)
