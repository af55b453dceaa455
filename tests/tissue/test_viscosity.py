"""Prony series: creep and relaxation are each other's inverse under convolution, and agree with an ODE of springs."""

import numpy as np
import pytest

from palpate.world.tissue import viscosity

PRONY = [(0.6, 0.02), (0.4, 0.3), (0.8, 4.0)]
ONE = [(1.5, 0.5)]


def test_one_term_creeps_as_the_standard_linear_solid():
    """Retardation time tau (1 + g), and jump 1/(1 + g) (Findley 1976, chapter 5)."""
    t = np.array([0.0, 0.2, 1.0, 10.0])
    np.testing.assert_allclose(viscosity.creep(ONE, t), 1 - 1.5 / 2.5 * np.exp(-t / (0.5 * 2.5)), rtol=1e-12)


@pytest.mark.parametrize("prony", [PRONY, ONE, [*PRONY, (0.1, 4.0)], [(0.0, 1.0), (0.3, 2.0)]])
def test_relaxation_convolved_with_creep_is_one(prony):
    """A stress that is a step gives a strain J(t), and this strain gives back the stress."""
    t = np.concatenate([[0.0], np.geomspace(1e-5, 60.0, 4000)])
    stress = viscosity.hereditary_force(prony, t, viscosity.creep(prony, t))
    np.testing.assert_allclose(stress, 1.0, rtol=2e-3)


def test_creep_agrees_with_springs_and_dashpots_in_small_steps():
    """Maxwell branches beside a spring, under a constant stress, by implicit steps of 50 us."""
    dt, g, tau = 5e-5, np.array([x for x, _ in PRONY]), np.array([x for _, x in PRONY])
    q, strain = np.full(3, 1.0 / (1.0 + g.sum())), 1.0 / (1.0 + g.sum())
    keep = 1.0 / (1.0 + dt / tau)
    for _ in range(10_000):
        new = (1.0 - (g * keep * (q - strain)).sum()) / (1.0 + (g * keep).sum())
        q, strain = keep * (q + new - strain), new
    assert strain == pytest.approx(float(viscosity.creep(PRONY, 0.5)), rel=1e-3)


def test_hold_after_a_fast_ramp_relaxes_as_the_series():
    t = np.concatenate([[0.0, 1e-6], np.linspace(0.01, 20.0, 50)])
    force = viscosity.hereditary_force(PRONY, t, np.concatenate([[0.0], np.full(51, 2.0)]))
    np.testing.assert_allclose(force[1:], 2.0 * viscosity.relaxation(PRONY, t[1:]), rtol=1e-4)


def test_no_terms_is_elastic():
    assert viscosity.creep([], [0.0, 1.0]).tolist() == [1.0, 1.0]
    assert viscosity.hereditary_force([], [0.0, 1.0], [0.0, 3.0]).tolist() == [0.0, 3.0]
