"""The dynamics regressor against inverse dynamics of arms with other inertial parameters."""

import numpy as np
import pytest

import palpate

ARMS = {"mtm": palpate.Arm.mtm("left"), "psm": palpate.Arm.psm(), "six": palpate.Arm.model("six_axis")}


def bodies(n: int, rng: np.random.Generator) -> np.ndarray:
    """Inertial parameters of n random bodies, each a sum of point masses."""
    links = []
    for _ in range(n):
        m, p = rng.uniform(0.01, 2.0, 6), rng.normal(0.0, 0.2, (6, 3))
        inertia = sum(mk * (pk @ pk * np.eye(3) - np.outer(pk, pk)) for mk, pk in zip(m, p, strict=True))
        links.append([m.sum(), *(m @ p), *inertia[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]])
    return np.array(links).ravel()


@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_regressor_predicts_arms_with_other_bodies(arm):
    rng = np.random.default_rng(0)
    for _ in range(5):
        q, v, a = rng.uniform(arm.q_min, arm.q_max), rng.normal(0, 2, arm.n), rng.normal(0, 5, arm.n)
        Y = arm.torque_regressor(q, v, a)
        assert Y.shape == (arm.n, 10 * arm.n)
        np.testing.assert_allclose(Y @ arm.inertial_parameters, arm.inverse_dynamics(q, v, a), atol=1e-10)
        pi = bodies(arm.n, rng)
        other = arm.with_inertial_parameters(pi)
        np.testing.assert_allclose(other.inertial_parameters, pi, rtol=1e-9, atol=1e-12)
        tau = other.inverse_dynamics(q, v, a)
        np.testing.assert_allclose(Y @ pi, tau, atol=1e-10 * np.abs(tau).max())


def test_unphysical_inertial_parameters_are_rejected():
    arm = ARMS["psm"]
    pi = bodies(arm.n, np.random.default_rng(1))
    pi[20] = -0.1
    with pytest.raises(RuntimeError, match="'insertion' is no body's"):
        arm.with_inertial_parameters(pi)
    pi[20], pi[27:30] = 0.1, 1.0  # violates the triangle inequality, with a distant centre of mass
    pi[21:24] = 10.0
    with pytest.raises(RuntimeError, match="pseudo-inertia"):
        arm.with_inertial_parameters(pi)
    with pytest.raises(RuntimeError, match="60 finite numbers, ten per moving link; got 7"):
        arm.with_inertial_parameters(np.ones(7))


def test_device_without_links_has_no_inertial_parameters():
    delta = palpate.Arm.model("delta")
    assert delta.inertial_parameters.size == 0
    with pytest.raises(RuntimeError, match="not made of links"):
        delta.with_inertial_parameters(np.ones(30))
