"""Closed forms of indentation: each agrees with another theory in the limit where both hold."""

import numpy as np
import pytest

from palpate.world.tissue import indentation

R, E, NU = 8e-3, 5e3, 0.45
DEPTHS = np.linspace(0.05, 0.5, 10) * R


def test_sneddon_tends_to_hertz_for_shallow_depths():
    d = np.array([1e-6, 1e-5, 1e-4])
    error = indentation.sneddon(R, d, E, NU) / indentation.hertz(R, d, E, NU) - 1
    assert np.abs(error[0]) < 1e-4
    assert np.all(np.diff(np.abs(error)) > 0)


def test_sneddon_force_is_the_integral_of_stiffness_by_the_contact_radius():
    """Without adhesion dF/dd = 2 a E/(1 - nu^2) for any frictionless punch (Pharr, Oliver and Brotzen 1992)."""
    d = np.linspace(0.0, R, 4001)
    a = np.array([_radius_by_bisection(x) for x in d])
    slope = 2 * E / (1 - NU**2) * a
    force = np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(d))])
    np.testing.assert_allclose(indentation.sneddon(R, d[400:], E, NU), force[400:], rtol=1e-4)


def _radius_by_bisection(depth):
    low, high = 0.0, R * (1 - 1e-12)
    for _ in range(60):
        a = 0.5 * (low + high)
        low, high = (a, high) if 0.5 * a * np.log((R + a) / (R - a)) < depth else (low, a)
    return 0.5 * (low + high)


@pytest.mark.parametrize(("law", "half_space"), [("layer", "sneddon"), ("dimitriadis", "hertz")])
def test_a_thick_layer_is_a_half_space(law, half_space):
    force = getattr(indentation, law)(R, DEPTHS, E, NU, h=1e3 * R)
    np.testing.assert_allclose(force, getattr(indentation, half_space)(R, DEPTHS, E, NU), rtol=2e-3)


@pytest.mark.parametrize("law", [indentation.layer, indentation.dimitriadis])
def test_a_thin_layer_is_stiffer(law):
    force = [law(R, DEPTHS[::3], E, NU, h) for h in (1.0, 0.05, 0.02, 0.01)]
    assert np.all(np.diff(force, axis=0) > 0)


@pytest.mark.parametrize("nu", [0.3, 0.45, 0.5])
def test_polynomial_is_the_layer_while_the_contact_is_small(nu):
    chi = np.array([0.02, 0.05, 0.1])
    d = (chi * 1e-3) ** 2 / R  # so thin that the sphere is a paraboloid
    polynomial, exact = (law(R, d, E, nu, 1e-3) for law in (indentation.dimitriadis, indentation.layer))
    np.testing.assert_allclose(polynomial, exact, rtol=2e-3)


def test_incompressible_layer_agrees_with_the_longer_polynomial():
    """1 + 1.133 chi + 1.497 chi^2 + 1.469 chi^3 + .755 chi^4 (Garcia and Garcia 2018, Biophys. J. 114, nu = .5)."""
    chi = np.array([0.05, 0.2, 0.4])
    d = (chi * 1e-3) ** 2 / R
    ratio = indentation.layer(R, d, E, 0.5, h=1e-3) / indentation.hertz(R, d, E, 0.5)
    np.testing.assert_allclose(ratio, np.polynomial.polynomial.polyval(chi, [1, 1.133, 1.497, 1.469, 0.755]), rtol=5e-3)


@pytest.mark.parametrize("law", [indentation.hertz, indentation.sneddon])
def test_no_contact_no_force(law):
    assert law(R, [-1e-3, 0.0], E, NU).tolist() == [0.0, 0.0]
