"""Moving objects: the closed form of pose and velocity, against finite differences and textbook motions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core
from palpate.contact import render
from palpate.shapes.analytic import SHAPES

SQUARE = _core.Mesh(np.array([[-1.0, -1, 0], [1, -1, 0], [0, 1, 0]]), np.array([[0, 1, 2]], np.int32))
RADIUS, K = 2e-3, 500.0


def wave(shift=(0, 0, 0), turn=(0, 0, 0), period=1.0, phase=0.0):
    return _core.Wave(np.array(shift, float), np.array(turn, float), period, phase)


def motion_of(waves=(), **vectors):
    return _core.Motion(waves=list(waves), **{name: np.array(x, float) for name, x in vectors.items()})


def moving(X_WO=None, **motion):
    X = np.eye(4) if X_WO is None else X_WO
    return _core.Object("thing", SQUARE, X, motion=motion_of(**motion))


def test_at_rest_it_stays():
    thing = moving()
    np.testing.assert_array_equal(thing.pose(3.0), np.eye(4))
    np.testing.assert_array_equal(thing.velocity(np.ones(3), 3.0), np.zeros(3))


def test_breathing_is_a_sinusoid():
    thing = moving(waves=[wave(shift=[0, 0.002, 0.008], period=4.0), wave(shift=[1e-3, 0, 0], period=0.8)])
    for t in (0.0, 0.3, 1.0, 2.7):
        breath, beat = np.sin(2 * np.pi * t / 4.0), np.sin(2 * np.pi * t / 0.8)
        np.testing.assert_allclose(thing.pose(t)[:3, 3], [1e-3 * beat, 0.002 * breath, 0.008 * breath], atol=1e-15)
        np.testing.assert_array_equal(thing.pose(t)[:3, :3], np.eye(3))


def test_a_steady_spin_turns_about_its_centre():
    thing = moving(w=[0, 0, 2.0], about=[1.0, 0, 0])
    X = thing.pose(0.5)
    np.testing.assert_allclose(X[:3, :3] @ [1, 0, 0], [np.cos(1), np.sin(1), 0], atol=1e-15)
    np.testing.assert_allclose(X[:3, 3], [1 - np.cos(1), -np.sin(1), 0], atol=1e-15)
    np.testing.assert_allclose(thing.velocity(np.array([1.0, 0.3, 0]), 0.5), [-0.6, 0, 0], atol=1e-15)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), size=st.sampled_from([1e-5, 0.3, 3.0]))
def test_the_velocity_is_the_derivative_of_the_pose(seed, size):
    """Of a point that rides along, by central differences; turning about several axes at once."""
    rng = np.random.default_rng(seed)
    waves = [wave(rng.normal(size=3) * size, rng.normal(size=3) * size, p, rng.normal()) for p in (4.0, 0.9)]
    X = np.eye(4)
    X[:3, 3] = rng.normal(size=3)
    thing = moving(X, v=rng.normal(size=3), w=rng.normal(size=3) * size, waves=waves, about=rng.normal(size=3))
    t, h, p_O = rng.uniform(0, 5), 1e-6, np.append(rng.normal(size=3), 1.0)
    difference = (thing.pose(t + h) @ p_O - thing.pose(t - h) @ p_O)[:3] / (2 * h)
    velocity = thing.velocity((thing.pose(t) @ p_O)[:3], t)
    np.testing.assert_allclose(velocity, difference, atol=2e-8 * (1 + np.abs(difference).max() + size**3 * 100))
    R = thing.pose(t)[:3, :3]
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize("bad", [{"period": 0.0}, {"period": -1.0}, {"shift": [np.nan, 0, 0]}])
def test_a_wave_that_cannot_be_is_refused(bad):
    with pytest.raises(ValueError, match="period above zero"):
        wave(**bad)


def felt(motion, tips, rate=1000.0, damping=0.0, method="proxy", radius=RADIUS):
    """Force on tool positions by a box that moves."""
    material = _core.Material(np.full(3, K), np.full(3, damping))
    box = _core.Object("box", _core.Mesh(*SHAPES["box"].mesh(2000)), np.eye(4), material, motion=motion)
    options = _core.ContactOptions()
    options.radius = radius
    return _core.contact_render(_core.Snapshot([box]), np.ascontiguousarray(tips), method, options, rate)[0]


def test_a_box_that_rises_is_a_spring_and_a_damper_of_its_own_speed():
    """The tool rests 1 mm inside the surface's way; F = K depth + B v_surface while that rises, never below zero."""
    t = np.arange(4000) / 1000.0
    rise = 0.004 * np.sin(2 * np.pi * t / 2.0)
    speed = 0.004 * np.pi * np.cos(2 * np.pi * t / 2.0)
    tips = np.tile([0.003, -0.002, 0.02 + RADIUS + 0.001], (len(t), 1))
    depth = np.maximum(rise - 0.001, 0.0)
    motion = motion_of(waves=[wave(shift=[0, 0, 0.004], period=2.0)])
    force = felt(motion, tips, damping=5.0)
    np.testing.assert_allclose(force[:, 2], np.where(depth > 0, np.maximum(K * depth + 5.0 * speed, 0), 0), atol=1e-7)
    np.testing.assert_allclose(force[:, :2], 0, atol=1e-9)


def test_a_turning_box_damps_with_the_velocity_of_the_touched_point():
    """A tool at x = 8 mm on a face that turns about y: the surface there moves along z with -w x."""
    w, x = 0.2, 0.008
    tips = np.tile([x, 0.0, 0.02 + RADIUS - 0.001], (3, 1))
    force = felt(motion_of(w=[0, w, 0]), tips, rate=1e6, damping=5.0)
    np.testing.assert_allclose(force[0, 2], K * 0.001 - 5.0 * w * x, rtol=1e-6)


@pytest.mark.parametrize("thickness", [1e-3, 0.5e-3])
def test_a_plate_that_comes_at_a_resting_tool_never_pops_through(thickness):
    """0.5 m/s from above, and the tool 20 mm on the other side of the plate at the end: still pushed down."""
    plate = _core.Mesh(*_box(0.06, 0.06, thickness))
    n = 60
    tips = np.tile([0.0011, -0.0023, 0.0], (n, 1))
    X = np.tile(np.eye(4), (n, 1, 1))
    X[:, 2, 3] = 0.01 - np.arange(n) * 0.5e-3
    force = render(plate, tips, radius=RADIUS, stiffness=K, poses=X).force
    np.testing.assert_allclose(force[:, 2], -K * np.maximum(RADIUS + thickness / 2 - X[:, 2, 3], 0), atol=1e-6)


def test_poses_and_motion_are_the_same_thing():
    """A box swung by its closed form, and by a list of poses taken from it: same forces, damping apart by sampling."""
    motion = motion_of(waves=[wave([0.002, 0, 0.003], [0.1, 0.2, 0.05], 0.7)])
    tips = np.tile([0.003, -0.002, 0.02 + RADIUS - 0.001], (700, 1))
    thing = _core.Object("box", SQUARE, np.eye(4), motion=motion)
    X = np.array([thing.pose(i / 1000.0) for i in range(len(tips))])
    box = _core.Mesh(*SHAPES["box"].mesh(2000))
    listed = render(box, tips, radius=RADIUS, stiffness=K, poses=X).force
    np.testing.assert_allclose(listed, felt(motion, tips), atol=1e-9)
    listed = render(box, tips, radius=RADIUS, stiffness=K, damping=2.0, poses=X).force
    np.testing.assert_allclose(listed[1:], felt(motion, tips, damping=2.0)[1:], atol=2e-3)


def test_the_paper_s_method_sees_where_the_object_is_now():
    rise = motion_of(v=[0, 0, 0.01])
    tips = np.tile([0.003, -0.002, 0.02 + 0.015], (200, 1))
    force = felt(rise, tips, method="paper-alg1", radius=0.0149)
    assert not force[:5].any()
    assert 0.3 < force[-1, 2] / (K * 0.002) < 1.1  # one collision period behind, and the average of facets


@pytest.mark.parametrize(
    ("poses", "message"),
    [
        (np.zeros((3, 4, 4)), r"poses must have shape \(2, 4, 4\)"),
        (np.stack([np.eye(4), 2 * np.eye(4)]), r"poses\[1\] is not"),
        (np.stack([np.eye(4), np.full((4, 4), np.nan)]), r"poses\[1\] is not"),
    ],
)
def test_bad_poses_are_named(poses, message):
    with pytest.raises(ValueError, match=message):
        render(SQUARE, np.zeros((2, 3)), radius=RADIUS, stiffness=K, poses=poses)


def _box(x, y, z):
    corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * np.array([x, y, z]) / 2
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.int32)
