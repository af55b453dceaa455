"""Section 3.3 of the paper in the plane: cases in which Eq 20 is exact and cases in which it fails."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate.scene.contact.lessons.face_angle import (
    OVERHANG,
    Slide,
    angle_noise,
    candidates,
    contact_normal_error,
    eq20,
    face_angle,
    locally_convex,
)

FACES = (15.0, 30.0, 45.0, 60.0, 75.0, 90.0)


@settings(max_examples=200, deadline=None)
@given(
    degrees=st.floats(1.0, 179.0),
    share=st.floats(0.02, 1.9),
    radius=st.floats(1e-3, 1.0),
    fraction=st.floats(0.02, 0.98),
)
def test_contact_point_path_has_the_face_angle_at_any_depth(degrees, share, radius, fraction):
    """Fig 11: the derivative of c from the circle's angle, to 1e-12 deg, and c_y = c_x tan phi_f."""
    slide = Slide(np.radians(degrees), radius, share * radius)
    x = slide.travel(101)
    x = x[[int(100 * fraction)]]
    rate, c = slide.rate(x)[0], slide.contact(x)[0]
    if np.linalg.norm(rate) > 1e-2:  # if the point moves along the face
        slope = np.degrees(np.arctan2(*(np.sign(rate @ slide.face) * rate)[::-1]))  # the direction may be reversed
        assert abs(slope - degrees) < 1e-12 / min(1.0, np.linalg.norm(rate))
    assert abs(c[1] * np.cos(slide.phi_f) - c[0] * np.sin(slide.phi_f)) < 1e-14 * radius * 10
    assert np.linalg.norm(c - slide.centre(x)[0]) == pytest.approx(radius, rel=1e-14)


@pytest.mark.parametrize("degrees", [*FACES, 120.0, -20.0, -60.0])
def test_rate_agrees_with_finite_differences(degrees):
    slide = Slide(np.radians(degrees))
    x = slide.travel(9)
    h = 1e-7
    numeric = (slide.contact(x + h) - slide.contact(x - h)) / (2 * h)
    np.testing.assert_allclose(numeric, slide.rate(x), atol=1e-7)


def test_at_ninety_degrees_c_y_is_the_sine_and_c_x_is_constant():
    slide = Slide(np.pi / 2, 1.0, 1.0)  # the centre is at the height of the edge
    x = slide.travel(50)
    np.testing.assert_allclose(slide.contact(x)[:, 1], np.sin(slide.phi_n(x)), atol=1e-15)
    np.testing.assert_allclose(np.diff(slide.contact(x)[:, 0]), 0.0, atol=1e-15)


@pytest.mark.parametrize(("noise", "degrees"), [(1e-6, 1.0), (10e-6, 10.0), (100e-6, 82.0)])
def test_noise_of_eq_18(noise, degrees):
    """At 250 Hz and 20 mm/s the baseline is 80 um."""
    assert angle_noise(noise) == pytest.approx(degrees, rel=0.06)
    assert angle_noise(1e-7) == pytest.approx(np.degrees(2**0.5 * 1e-7 / 80e-6), rel=0.01)


def test_eq_19_and_20():
    left, right = candidates(np.radians(30.0))
    np.testing.assert_allclose(left @ [np.cos(np.radians(30)), np.sin(np.radians(30))], 0.0, atol=1e-16)
    np.testing.assert_allclose(left, -right)
    assert locally_convex((left, right), [0, 1]) is left
    assert locally_convex((left, right), [0, -1]) is right


@pytest.mark.parametrize("degrees", [-80, -45, -10, 10, 45, 89])
def test_eq_20_is_right_on_convex_and_blunt_concave_edges(degrees):
    slide = Slide(np.radians(degrees))
    n, fails = eq20(slide)
    assert fails == ""
    np.testing.assert_allclose(n, slide.normal, atol=1e-9)


@pytest.mark.parametrize("degrees", [91, 120, 170])
def test_eq_20_fails_on_sharp_concave_edges_and_the_error_is_named(degrees):
    slide = Slide(np.radians(degrees))
    n, fails = eq20(slide)
    assert fails == OVERHANG
    np.testing.assert_allclose(n, -slide.normal, atol=1e-9)


def test_normals_from_surface_points_become_wrong_with_depth():
    assert contact_normal_error(15e-3, 1e-12) < 1e-3
    assert contact_normal_error(15e-3, 7.5e-3) == pytest.approx(60.0)
    assert contact_normal_error(15e-3, 20e-3) > 90.0  # the centre is below the face


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Slide(0.5, 0.01, 0.03), "depth must be between 0 and two radii"),
        (lambda: Slide(0.0), "phi_f must be between -180 and 180 degrees and not 0"),
        (lambda: face_angle([0, 0], [1e-6, 0], 5e-6), "moved 1 um, less than the baseline of 5 um"),
        (lambda: face_angle([0, 0], [0, 0]), "moved 0 um"),
    ],
)
def test_undefined_configurations_are_rejected(make, message):
    with pytest.raises(ValueError, match=message):
        make()
