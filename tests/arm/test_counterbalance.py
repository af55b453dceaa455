"""The counterbalance spring: it has a potential, loads joints 2 and 3, and leaves torque for the rendered force."""

import numpy as np
import pytest

import palpate
from palpate import _core
from palpate.record.ticks import STATUS

START = np.array([0.0, 0.0, 0.0, 0.0, np.pi / 2, 0.0, 0.0])


@pytest.fixture(scope="module", params=["right", "left"])
def mtm(request):
    return palpate.Arm.mtm(request.param)


def poses(arm, n=50):
    return np.random.default_rng(12).uniform(arm.q_min, arm.q_max, (n, arm.n))


def test_spring_torque_is_the_gradient_of_the_spring_energy(mtm):
    for q in poses(mtm):
        slope = [(mtm.elastic_energy(q + h) - mtm.elastic_energy(q - h)) / 2e-5 for h in 1e-5 * np.eye(7)]
        np.testing.assert_allclose(mtm.elastic(q), slope, atol=1e-9)


def test_spring_does_no_work_on_a_closed_path(mtm):
    """The published term, on joint 3 alone, would give 24 mJ per cycle."""
    angle = np.linspace(0.0, 2.0 * np.pi, 2001)
    q = np.zeros((2001, 7))
    q[:, 1], q[:, 2] = 0.4 + 0.2 * np.cos(angle), 0.2 * np.sin(angle)
    dq, middle = np.diff(q, axis=0), 0.5 * (q[1:] + q[:-1])
    tau = np.array([mtm.elastic(x) for x in middle])
    assert abs(np.einsum("ij,ij->", tau, dq)) < 1e-7
    assert abs(tau[:, 2] @ dq[:, 2]) > 0.02


def test_holding_torques_lie_in_the_range_of_real_arms(mtm):
    """Published magnitudes: joint 2 0.3 to 0.85 N m, joint 3 0.12 to 0.6 N m."""
    tau = mtm.holding(START)
    assert 0.3 < tau[1] < 0.85
    assert 0.12 < tau[2] < 0.6
    assert mtm.gravity(START)[2] > 0.85  # without the spring


def test_spring_does_not_change_the_gravity_model(mtm):
    bare = palpate.Arm.mtm(mtm.name.removeprefix("mtm_"))
    bare.set_counterbalance(0.0, np.zeros(7))
    for q in poses(mtm):
        np.testing.assert_array_equal(mtm.gravity(q), bare.gravity(q))
        np.testing.assert_array_equal(bare.holding(q), bare.gravity(q))
        np.testing.assert_allclose(mtm.holding(q), mtm.gravity(q) + mtm.elastic(q), atol=1e-15)


@pytest.mark.parametrize("direction", [*np.eye(3), *-np.eye(3)])
def test_drives_can_render_the_force_cap_in_every_direction_at_the_start_pose(mtm, direction):
    F = np.r_[3.0 * direction, 0, 0, 0]
    out, status = _core.Torque(_core.TorqueOptions(), mtm.tau_max).step(mtm, START, np.zeros(7), F)
    rendered, limited = out.F_H_L, status & STATUS["torque_limited"][0]
    assert not limited
    np.testing.assert_array_equal(rendered, F)


def test_invalid_spring_is_reported(mtm):
    with pytest.raises(ValueError, match=r"along must have shape \(7,\)"):
        mtm.set_counterbalance(0.5, np.zeros(3))
    with pytest.raises(RuntimeError, match="finite"):
        mtm.set_counterbalance(np.nan, np.zeros(7))
