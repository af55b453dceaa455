"""Objects that the tip touches at once: which ones they are, and that their springs are judged together."""

import warnings

import numpy as np
import pytest

import palpate
from palpate.base.errors import PalpateWarning
from palpate.devices.certificate import certify_all
from palpate.devices.certificate.at_once import _gap, _points, _stroke, groups
from palpate.devices.certificate.scene import warn_outside
from palpate.devices.certificate.touched import touched
from palpate.scene.rig import build

REST = """
contact: {radius: 0.004}
operator: {path: [{t: 0, xyz: [0, 0, 0.03]}, {t: 1, xyz: [0, 0, 0.02]}]}
"""


def rig(*objects):
    return build(palpate.Scene.parse(f"objects: [{', '.join(objects)}]{REST}"))


def ball(name, x, more=""):
    return f"{{name: {name}, sphere: {{radius: 0.02}}, pose: {{xyz: [{x}, 0, 0]}}{more}}}"


@pytest.mark.parametrize(
    ("x", "more", "found"),
    [
        (0.046, "", [(0, 1)]),  # a gap of 6 mm, a tip of 8 mm
        (0.052, "", []),
        (0.030, "", [(0, 1)]),  # one within the other
        (0.052, ", motion: {amplitude: [0.006, 0, 0]}", [(0, 1)]),
        (0.052, ", motion: {velocity: [0.001, 0, 0]}", [(0, 1)]),
    ],
)
def test_objects_within_the_tips_diameter_are_a_group(x, more, found):
    assert groups(rig(ball("a", 0.0), ball("b", x, more))) == found


def test_a_tool_of_several_spheres_reaches_over_its_length():
    apart = rig(ball("a", 0.0), ball("b", 0.06))  # a gap of 20 mm
    assert (groups(apart, 0.018), groups(apart, 0.021)) == ([], [(0, 1)])


def test_surfaces_that_cross_far_from_all_vertices_are_a_group():
    long = "{{name: {}, box: {{size: [{}, {}, 0.01]}}}}"
    assert groups(rig(long.format("a", 0.3, 0.01), long.format("b", 0.01, 0.3))) == [(0, 1)]


def test_a_chain_is_not_taken_for_a_group_of_three():
    assert groups(rig(*(ball(f"b{i}", 0.046 * i) for i in range(3)))) == [(0, 1), (1, 2)]
    assert groups(rig(*(ball(f"b{i}", 0.01 * i) for i in range(3)))) == [(0, 1, 2)]


def test_points_are_spread_over_a_surface_by_area():
    """Reference: the spacing of 4000 squares of equal area, and the mean and spread of a uniform distribution."""
    points, spacing = _points(rig("{name: floor, plane: {size: 0.3}}").surfaces[0])
    assert spacing == pytest.approx(0.3 / np.sqrt(4000))
    np.testing.assert_allclose(points.mean(axis=0), 0.0, atol=0.005)
    np.testing.assert_allclose(points.std(axis=0), [0.3 / np.sqrt(12), 0.3 / np.sqrt(12), 0.0], rtol=0.03)
    points, spacing = _points(rig(ball("a", 0.1)).surfaces[0])
    assert spacing == pytest.approx(np.sqrt(4.0 * np.pi * 0.02**2 / 4000), rel=0.05)
    np.testing.assert_allclose(points.mean(axis=0), [0.1, 0.0, 0.0], atol=0.001)


def test_the_stroke_of_an_object_adds_its_amplitude_and_the_way_of_its_farthest_corner():
    moves = ", motion: {amplitude: [0.003, 0, 0.004], turn_deg: [0, 0, 30]}"
    one = rig(ball("a", 0.1, moves))
    corner = 0.5 * float(np.linalg.norm(np.diff(one.surfaces[0].bounds, axis=0)))
    assert corner == pytest.approx(0.02 * np.sqrt(3.0), rel=0.03)
    assert _stroke(one, 0, ()) == pytest.approx(0.005 + corner * np.pi / 6.0)
    assert _stroke(rig(ball("a", 0.1, ", motion: {spin_deg: [0, 0, 1]}")), 0, ()) == np.inf
    assert _stroke(rig(ball("a", 0.1)), 0, ()) == 0.0
    assert _stroke(rig(ball("a", 0.1)), 0, ("a",)) == np.inf


def plane(name, K):
    return f"{{name: {name}, plane: {{size: 0.3}}, stiffness: {K:g}, damping: 0}}"


def test_two_planes_in_one_place_are_judged_by_their_sum():
    """Each is stable, and together they are not (docs/certificate.md)."""
    both = rig(plane("a", 1400), plane("b", 1400))
    a, b, together = certify_all(both.scene, rig=both)
    assert (a.verdict, b.verdict, together.verdict) == ("stable", "stable", "unstable")
    assert together.K == 2800
    assert together.k_max <= a.k_max
    assert [one.name for one in touched(both)] == ["a", "b", "a and b at once"]
    assert [(one.index, one.others) for one in touched(both)] == [(0, ()), (1, ()), (0, (1,))]
    with pytest.warns(PalpateWarning, match="a and b at once"):
        warn_outside(both)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_outside(rig(plane("a", 1400)))


def test_a_gap_is_the_least_distance_less_the_spacing_and_zero_inside():
    surface = rig(ball("a", 0.1)).surfaces[0]
    outside = np.array([[0.13, 0.0, 0.0], [0.1, 0.025, 0.0]])
    assert _gap((outside, 0.001), surface) == pytest.approx(0.005 - 0.001, abs=2e-4)
    inside = np.array([[0.13, 0.0, 0.0], [0.1, 0.005, 0.0]])
    assert _gap((inside, 0.001), surface) == pytest.approx(-0.001, abs=1e-12)
