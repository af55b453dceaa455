"""The axisymmetric reference: its stress is the slope of its energy, and it tends to the closed forms at small strain.

The closed forms come from integral equations, the reference from finite elements.
"""

import numpy as np
import pytest

from palpate.world.tissue import indentation
from palpate_lab.verify.tissue import axisymmetric, reference, reference_force, solid
from palpate_lab.verify.tissue.axisymmetric import Indentation

R, E = 8e-3, 5e3


def test_stress_and_stiffness_are_derivatives_of_the_energy():
    F = np.eye(3) + 0.2 * np.random.default_rng(0).normal(size=(3, 3))
    step, values = 1e-6 * np.eye(9).reshape(9, 3, 3), (0.3, 3.0, 0.5)
    high, low = (solid.energy(F + s * step, *values) for s in (1, -1))
    _, P, A = solid.energy(F, *values)
    np.testing.assert_allclose((high[0] - low[0]) / 2e-6, P, atol=1e-8)
    np.testing.assert_allclose((high[1] - low[1]) / 2e-6, A, atol=1e-7)


def test_an_inverted_solid_has_no_finite_energy():
    assert solid.energy(np.diag([-1.0, 1.0, 1.0]), 1.0, 3.0, 0.0)[0] == np.inf


@pytest.mark.parametrize("nu", [0.3, 0.45])
def test_a_thin_layer_at_small_strain_agrees_with_the_integral_equation(nu, monkeypatch):
    """chi = 1, at 2 % of the thickness: there the polynomial of Dimitriadis lies 14 % below."""
    monkeypatch.setattr(axisymmetric, "_STEP", 2e-4)
    case = Indentation(poisson=nu, thickness=0.02, width=0.2, fine=400, near=0.04)
    force = case.forces([4e-4])[0]
    assert force == pytest.approx(float(indentation.layer(1.0, 4e-4, 1.0, nu, 0.02)), rel=0.015)
    assert force > 1.1 * float(indentation.dimitriadis(1.0, 4e-4, 1.0, nu, 0.02))


@pytest.mark.parametrize("nu", [0.4, 0.45, 0.49])
def test_half_space_tends_to_sneddon(nu):
    ratio = [float(reference_force(R, d * R, E, nu) / indentation.sneddon(R, d * R, E, nu)) for d in (0.02, 0.05, 0.5)]
    np.testing.assert_allclose(ratio[:2], 1.0, atol=0.025)
    assert abs(ratio[2] - 1) < 0.12


@pytest.mark.parametrize(("nu", "h"), [(0.45, 1.0), (0.45, 2.0), (0.49, 2.0), (0.45, 5.0)])
def test_layers_tend_to_the_integral_equation(nu, h):
    ratio = reference_force(R, 0.05 * R, E, nu, h=h * R) / indentation.layer(R, 0.05 * R, E, nu, h * R)
    assert float(ratio) == pytest.approx(1.0, abs=0.02)


def test_stiffening_tissue_needs_more_force():
    d = np.linspace(0.1, 0.7, 5) * R
    assert np.all(reference_force(R, d, E, 0.45, yeoh=1.0) > 1.01 * reference_force(R, d, E, 0.45))


def test_forces_scale_with_modulus_and_area():
    one, other = reference_force(R, 0.3 * R, E, 0.45), reference_force(2 * R, 0.6 * R, 3 * E, 0.45)
    assert float(other) == pytest.approx(12 * float(one))


@pytest.mark.parametrize(
    ("values", "words"),
    [({"nu": 0.31}, "no case nu 0.31"), ({"nu": 0.45, "h": 0.0123}, "no case"), ({"d": 2.0}, "beyond")],
)
def test_cases_and_depths_outside_the_table_are_refused(values, words):
    with pytest.raises(ValueError, match=words):
        reference_force(R, values.get("d", 0.1) * R, E, values.get("nu", 0.45), h=values.get("h", np.inf))


def test_every_case_of_the_table_rises_steadily():
    for case in reference.cases():
        assert np.all(np.diff(case["f"]) > 0), case
