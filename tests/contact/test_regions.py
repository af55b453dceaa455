"""Regions of other stiffness: exact inside and outside, continuous in between, without energy gain."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core

RADIUS = 2e-3
SOFT = _core.Material(np.full(3, 300.0), np.full(3, 1.0), 0.1, 0.2)
HARD = _core.Material(np.full(3, 1500.0), np.full(3, 4.0), 0.5, 0.9)
NODULE = _core.Region(np.array([0.01, 0, -0.004]), radius=0.006, blend=0.003, material=HARD)
FLOOR = _core.Mesh(
    np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]], np.int32)
)


def floor(*regions, material=SOFT, X_WO=None):
    return _core.Object("floor", FLOOR, np.eye(4) if X_WO is None else X_WO, material, regions)


def render_path(tips, *objects, rate=1000.0):
    options = _core.ContactOptions()
    options.radius = RADIUS
    return _core.contact_render(_core.Snapshot(objects), np.ascontiguousarray(tips), "proxy", options, rate)[0]


def frictionless(m):
    return _core.Material(m.K, np.zeros(3), 0.0)


def test_stiffness_is_the_regions_inside_and_the_objects_outside():
    obj = floor(NODULE)
    inside, dK = obj.feel(np.array([0.012, 0.001, -0.003]))
    np.testing.assert_allclose([inside.K[0], inside.B[0], inside.mu, inside.mu_static], [1500, 4, 0.5, 0.9], rtol=1e-15)
    assert not dK.any()
    outside, dK = obj.feel(np.array([0.01, 0, 0.0051]))
    np.testing.assert_array_equal([outside.K[0], outside.B[0], outside.mu, outside.mu_static], [300, 1, 0.1, 0.2])
    assert not dK.any()


def test_box_region_has_corners_rounded_by_its_radius():
    box = _core.Region(np.zeros(3), np.array([0.01, 0.02, 0.03]), radius=0.001, blend=0.002, material=HARD)
    obj = floor(box)
    assert obj.feel(np.array([0.0109, 0, 0.0]))[0].K[0] == 1500
    assert obj.feel(np.array([0.0131, 0, 0.0]))[0].K[0] == 300
    corner = np.array([0.01, 0.02, 0.03]) + 0.0009 / 3**0.5
    assert obj.feel(corner)[0].K[0] == 1500


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_stiffness_gradient_matches_finite_differences(seed):
    """Central differences with two overlapping anisotropic regions."""
    rng = np.random.default_rng(seed)
    regions = [
        _core.Region(
            rng.normal(size=3) * 0.01,
            rng.uniform(0, 0.01, 3) * (k == 0),
            0.005,
            0.01,
            _core.Material(rng.uniform(0, 2000, 3)),
        )
        for k in range(2)
    ]
    obj, p, h = floor(*regions), rng.normal(size=3) * 0.015, 1e-7
    steps = h * np.eye(3)
    difference = np.stack([(obj.feel(p + e)[0].K - obj.feel(p - e)[0].K) / (2 * h) for e in steps], axis=1)
    np.testing.assert_allclose(obj.feel(p)[1], difference, atol=0.5 + 1e-4 * np.abs(difference).max())


def test_force_is_larger_over_the_nodule_and_continuous():
    x = np.arange(-0.005, 0.025, 2e-6)
    tips = np.stack([x, np.zeros_like(x), np.full_like(x, RADIUS - 0.002)], axis=1)
    down = np.linspace([x[0], 0, RADIUS + 0.001], tips[0], 500)
    nodule = _core.Region(NODULE.centre, NODULE.half, NODULE.radius, NODULE.blend, frictionless(HARD))
    force = render_path(np.concatenate([down, tips]), floor(nodule, material=frictionless(SOFT)))[len(down) :]
    np.testing.assert_allclose(force[np.abs(x - 0.01) < 0.004, 2], 1500 * 0.002, rtol=1e-9)
    np.testing.assert_allclose(force[np.abs(x - 0.01) > 0.0101, 2], 300 * 0.002, rtol=1e-9)
    assert np.abs(np.diff(force, axis=0)).max() < 2e-6 * 2 * 1200 / 0.003  # the slope of the blend, without a step
    assert (force[x < 0.0055, 0] <= 0).all()  # the force pushes the tool off the nodule
    assert (force[x > 0.0145, 0] >= 0).all()


def test_pressing_next_to_the_nodule_and_releasing_on_it_gains_no_energy():
    """Down on the soft side, across, up on the hard side: without the gradient term, 1/2 dK depth^2 would be gained."""
    nodule = _core.Region(NODULE.centre, NODULE.half, NODULE.radius, NODULE.blend, frictionless(HARD))
    high, low = RADIUS + 0.001, RADIUS - 0.003
    corners = [[-0.005, 0, high], [-0.005, 0, low], [0.01, 0.002, low], [0.01, 0.002, high], [-0.005, 0, high]]
    tips = np.concatenate([np.linspace(a, b, 8000) for a, b in pairwise(corners)])
    force = render_path(tips, floor(nodule, material=frictionless(SOFT)))
    work = 0.5 * ((force[1:] + force[:-1]) * np.diff(tips, axis=0)).sum()
    free = 0.5 * 1200 * 0.003**2
    assert abs(work) < 1e-3 * free


def test_regions_move_with_their_object():
    R = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    R *= np.sign(np.linalg.det(R))
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = R, [0.1, -0.2, 0.3]
    tips = np.linspace([0.005, 0.001, 0.004], [0.009, 0.0, -0.001], 300)
    one = render_path(tips, floor(NODULE))
    other = render_path(tips @ R.T + X[:3, 3], floor(NODULE, X_WO=X))
    np.testing.assert_allclose(other, one @ R.T, atol=1e-9)


@pytest.mark.parametrize("change", [{"blend": 0.0}, {"radius": -1.0}, {"half": [0, -1, 0]}, {"centre": [np.nan, 0, 0]}])
def test_invalid_region_is_rejected(change):
    given = {"centre": [0.0, 0, 0]} | change
    arguments = {k: v if isinstance(v, float) else np.array(v, float) for k, v in given.items()}
    with pytest.raises(ValueError, match="a region needs"):
        _core.Region(**arguments)
