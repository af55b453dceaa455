"""Moving objects: pose and velocity against finite differences and closed forms."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core
from palpate.scene.contact import render
from palpate.world.shapes.analytic import SHAPES

SQUARE = _core.Mesh(np.array([[-1.0, -1, 0], [1, -1, 0], [0, 1, 0]]), np.array([[0, 1, 2]], np.int32))
RADIUS, K = 2e-3, 500.0


def wave(shift=(0, 0, 0), turn=(0, 0, 0), period=1.0, phase=0.0):
    return _core.Wave(np.array(shift, float), np.array(turn, float), period, phase)


def motion_of(waves=(), **vectors):
    return _core.Motion(waves=list(waves), **{name: np.array(x, float) for name, x in vectors.items()})


def moving(X_WO=None, **motion):
    X = np.eye(4) if X_WO is None else X_WO
    return _core.Object("object", SQUARE, X, motion=motion_of(**motion))


def test_object_without_motion_stays_at_rest():
    obj = moving()
    np.testing.assert_array_equal(obj.pose(3.0), np.eye(4))
    np.testing.assert_array_equal(obj.velocity(np.ones(3), 3.0), np.zeros(3))


def test_breathing_is_a_sinusoid():
    obj = moving(waves=[wave(shift=[0, 0.002, 0.008], period=4.0), wave(shift=[1e-3, 0, 0], period=0.8)])
    for t in (0.0, 0.3, 1.0, 2.7):
        breath, beat = np.sin(2 * np.pi * t / 4.0), np.sin(2 * np.pi * t / 0.8)
        np.testing.assert_allclose(obj.pose(t)[:3, 3], [1e-3 * beat, 0.002 * breath, 0.008 * breath], atol=1e-15)
        np.testing.assert_array_equal(obj.pose(t)[:3, :3], np.eye(3))


def test_constant_rotation_is_about_its_centre():
    obj = moving(w=[0, 0, 2.0], about=[1.0, 0, 0])
    X = obj.pose(0.5)
    np.testing.assert_allclose(X[:3, :3] @ [1, 0, 0], [np.cos(1), np.sin(1), 0], atol=1e-15)
    np.testing.assert_allclose(X[:3, 3], [1 - np.cos(1), -np.sin(1), 0], atol=1e-15)
    np.testing.assert_allclose(obj.velocity(np.array([1.0, 0.3, 0]), 0.5), [-0.6, 0, 0], atol=1e-15)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), size=st.sampled_from([1e-5, 0.3, 3.0]))
def test_velocity_is_the_derivative_of_the_pose(seed, size):
    """Central differences of a point of the object, with rotation about several axes."""
    rng = np.random.default_rng(seed)
    waves = [wave(rng.normal(size=3) * size, rng.normal(size=3) * size, p, rng.normal()) for p in (4.0, 0.9)]
    X = np.eye(4)
    X[:3, 3] = rng.normal(size=3)
    obj = moving(X, v=rng.normal(size=3), w=rng.normal(size=3) * size, waves=waves, about=rng.normal(size=3))
    t, h, p_O = rng.uniform(0, 5), 1e-6, np.append(rng.normal(size=3), 1.0)
    difference = (obj.pose(t + h) @ p_O - obj.pose(t - h) @ p_O)[:3] / (2 * h)
    velocity = obj.velocity((obj.pose(t) @ p_O)[:3], t)
    np.testing.assert_allclose(velocity, difference, atol=2e-8 * (1 + np.abs(difference).max() + size**3 * 100))
    R = obj.pose(t)[:3, :3]
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize("change", [{"period": 0.0}, {"period": -1.0}, {"shift": [np.nan, 0, 0]}])
def test_invalid_wave_is_rejected(change):
    with pytest.raises(ValueError, match="period above zero"):
        wave(**change)


def felt(motion, tips, rate=1000.0, damping=0.0, method="proxy", radius=RADIUS):
    """Forces (n, 3) [N] of a moving box at tool positions (n, 3) [m]."""
    material = _core.Material(np.full(3, K), np.full(3, damping))
    box = _core.Object("box", _core.Mesh(*SHAPES["box"].mesh(2000)), np.eye(4), material, motion=motion)
    options = _core.ContactOptions()
    options.radius = radius
    return _core.contact_render(_core.Snapshot([box]), np.ascontiguousarray(tips), method, options, rate)[0]


def test_rising_box_gives_spring_force_and_damping_of_its_speed():
    """The surface rises to 1 mm above a resting tool: F = K depth + B v_surface, never below zero."""
    t = np.arange(4000) / 1000.0
    rise = 0.004 * np.sin(2 * np.pi * t / 2.0)
    speed = 0.004 * np.pi * np.cos(2 * np.pi * t / 2.0)
    tips = np.tile([0.003, -0.002, 0.02 + RADIUS + 0.001], (len(t), 1))
    depth = np.maximum(rise - 0.001, 0.0)
    motion = motion_of(waves=[wave(shift=[0, 0, 0.004], period=2.0)])
    force = felt(motion, tips, damping=5.0)
    np.testing.assert_allclose(force[:, 2], np.where(depth > 0, np.maximum(K * depth + 5.0 * speed, 0), 0), atol=1e-7)
    np.testing.assert_allclose(force[:, :2], 0, atol=1e-9)


def test_rotating_box_damps_with_the_velocity_of_the_contact_point():
    """A tool at x = 8 mm on a face that rotates about y: the surface moves along z with -w x."""
    w, x = 0.2, 0.008
    tips = np.tile([x, 0.0, 0.02 + RADIUS - 0.001], (3, 1))
    force = felt(motion_of(w=[0, w, 0]), tips, rate=1e6, damping=5.0)
    np.testing.assert_allclose(force[0, 2], K * 0.001 - 5.0 * w * x, rtol=1e-6)


@pytest.mark.parametrize("thickness", [1e-3, 0.5e-3])
def test_plate_that_moves_into_a_resting_tool_never_passes_it(thickness):
    """The plate moves down at 0.5 m/s to 20 mm below the tool: the tool is still pushed down."""
    plate = _core.Mesh(*_box(0.06, 0.06, thickness))
    n = 60
    tips = np.tile([0.0011, -0.0023, 0.0], (n, 1))
    X = np.tile(np.eye(4), (n, 1, 1))
    X[:, 2, 3] = 0.01 - np.arange(n) * 0.5e-3
    force = render(plate, tips, radius=RADIUS, stiffness=K, poses=X).force
    np.testing.assert_allclose(force[:, 2], -K * np.maximum(RADIUS + thickness / 2 - X[:, 2, 3], 0), atol=1e-6)


def test_list_of_poses_equals_the_motion():
    """A box moved by its closed form and by sampled poses: equal forces, except for damping by the sampling."""
    motion = motion_of(waves=[wave([0.002, 0, 0.003], [0.1, 0.2, 0.05], 0.7)])
    tips = np.tile([0.003, -0.002, 0.02 + RADIUS - 0.001], (700, 1))
    obj = _core.Object("box", SQUARE, np.eye(4), motion=motion)
    X = np.array([obj.pose(i / 1000.0) for i in range(len(tips))])
    box = _core.Mesh(*SHAPES["box"].mesh(2000))
    listed = render(box, tips, radius=RADIUS, stiffness=K, poses=X).force
    np.testing.assert_allclose(listed, felt(motion, tips), atol=1e-9)
    listed = render(box, tips, radius=RADIUS, stiffness=K, damping=2.0, poses=X).force
    np.testing.assert_allclose(listed[1:], felt(motion, tips, damping=2.0)[1:], atol=2e-3)


def test_method_of_the_paper_uses_the_present_pose():
    rise = motion_of(v=[0, 0, 0.01])
    tips = np.tile([0.003, -0.002, 0.02 + 0.015], (200, 1))
    force = felt(rise, tips, method="paper-alg1", radius=0.0149)
    assert not force[:5].any()
    assert 0.3 < force[-1, 2] / (K * 0.002) < 1.1  # delayed by one collision period, with averaged facets


@pytest.mark.parametrize(
    ("poses", "message"),
    [
        (np.zeros((3, 4, 4)), r"poses must have shape \(2, 4, 4\)"),
        (np.stack([np.eye(4), 2 * np.eye(4)]), r"poses\[1\] is not"),
        (np.stack([np.eye(4), np.full((4, 4), np.nan)]), r"poses\[1\] is not"),
    ],
)
def test_invalid_poses_are_reported(poses, message):
    with pytest.raises(ValueError, match=message):
        render(SQUARE, np.zeros((2, 3)), radius=RADIUS, stiffness=K, poses=poses)


def _box(x, y, z):
    corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * np.array([x, y, z]) / 2
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.int32)
