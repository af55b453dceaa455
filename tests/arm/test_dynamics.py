"""Dynamics of the arms against MuJoCo on the same URDF, energy, and the gravity model of the real controller."""

from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

import palpate
from palpate.arm import models_folder

G = 9.81


@pytest.fixture(scope="module")
def twin(arm):
    """The same URDF in MuJoCo, with the joints that are only drawn welded."""
    robot = ElementTree.fromstring((models_folder() / f"{arm.name}.urdf").read_text())
    for joint in robot.findall("joint"):
        if joint.get("name") not in arm.joint_names:
            joint.set("type", "fixed")
            for tag in ("limit", "mimic", "axis"):
                for element in joint.findall(tag):
                    joint.remove(element)
    model = mujoco.MjModel.from_xml_string(ElementTree.tostring(robot, encoding="unicode"))
    return model, mujoco.MjData(model)


def test_mass_matrix_and_bias_agree_with_mujoco(arm, poses, twin):
    model, data = twin
    rng = np.random.default_rng(6)
    for q in poses:
        v = rng.normal(size=arm.n)
        data.qpos[:], data.qvel[:] = q, v
        mujoco.mj_forward(model, data)
        M = np.zeros((arm.n, arm.n))
        mujoco.mj_fullM(model, data, M)
        assert np.abs(arm.mass_matrix(q) - M).max() < 1e-10
        assert np.abs(arm.bias(q, v) - data.qfrc_bias).max() < 1e-10


def test_all_terms_at_once_equal_the_single_functions(arm, poses):
    """The plant uses our own Newton-Euler recursion; Pinocchio is the reference."""
    rng = np.random.default_rng(9)
    for q in poses:
        v = 3 * rng.normal(size=arm.n)
        M, bias, X, J, _ = arm.dynamics(q, v)
        assert np.abs(M - arm.mass_matrix(q)).max() < 1e-14
        assert np.abs(bias - arm.bias(q, v)).max() < 1e-12
        assert np.abs(X - arm.fk(q)).max() < 1e-14
        assert np.abs(J - arm.jacobian(q)).max() < 1e-14


def test_gravity_is_the_gradient_of_potential_energy(arm, poses):
    """Eq 10; Richardson extrapolation makes the difference quotient accurate to 1e-9."""
    for q in poses:
        G_q = arm.gravity(q)
        for k in range(arm.n):

            def slope(h, q=q, k=k):
                step = h * np.eye(arm.n)[k]
                return (arm.potential_energy(q + step) - arm.potential_energy(q - step)) / (2 * h)

            assert abs((4 * slope(1e-3) - slope(2e-3)) / 3 - G_q[k]) < 1e-9


def test_mass_matrix_is_symmetric_and_positive(arm, poses):
    for q in poses:
        M = arm.mass_matrix(q)
        assert (M == M.T).all()
        assert np.linalg.eigvalsh(M)[0] > 0


def test_inverse_dynamics_is_inertia_and_bias(arm, poses):
    rng = np.random.default_rng(7)
    for q in poses:
        v, a = rng.normal(size=(2, arm.n))
        assert np.abs(arm.inverse_dynamics(q, v, a) - (arm.mass_matrix(q) @ a + arm.bias(q, v))).max() < 1e-12
        assert np.abs(arm.bias(q, 0 * v) - arm.gravity(q)).max() < 1e-12


def regressor(q):
    """Gravity columns of the real controller, joints 2 to 6 (rows), parameters p0 to p9."""
    s2, c2, s23, c23 = np.sin(q[1]), np.cos(q[1]), np.sin(q[1] + q[2]), np.cos(q[1] + q[2])
    (s4, s5, s6), (c4, c5, c6) = np.sin(q[3:6]), np.cos(q[3:6])
    two = [
        s2, c2, c23, -s23, c23 * c4, -c23 * s4, -s23 * c5 - c23 * c4 * s5, c23 * c4 * c5 - s23 * s5,
        c23 * s4 * s6 + s23 * c6 * s5 - c23 * c4 * c5 * c6, c23 * c6 * s4 - s23 * s5 * s6 + c23 * c4 * c5 * s6,
    ]  # fmt: skip
    three = [0, 0, *two[2:]]
    four = [
        0, 0, 0, 0, -s23 * s4, -s23 * c4, s23 * s4 * s5, -s23 * c5 * s4,
        s23 * (c4 * s6 + c5 * c6 * s4), s23 * (c4 * c6 - c5 * s4 * s6),
    ]  # fmt: skip
    five = [
        0, 0, 0, 0, 0, 0, -(c23 * s5 + s23 * c4 * c5), c23 * c5 - s23 * c4 * s5,
        -c23 * c5 * c6 + s23 * c4 * c6 * s5, c23 * c5 * s6 - s23 * c4 * s5 * s6,
    ]  # fmt: skip
    six = [
        0, 0, 0, 0, 0, 0, 0, 0,
        s23 * c6 * s4 + c23 * s5 * s6 + s23 * c4 * c5 * s6, c23 * c6 * s5 - s23 * s4 * s6 + s23 * c4 * c5 * c6,
    ]  # fmt: skip
    return np.array([two, three, four, five, six])


@pytest.mark.parametrize(("side", "sign"), [("right", 1.0), ("left", -1.0)])
def test_gravity_of_the_master_arm_matches_the_real_controllers_model(side, sign):
    """Parameters from the CAD masses and centres of mass; p5 changes its sign on the left arm."""
    mtm = palpate.Arm.mtm(side)
    wrist = 0.14 + 0.04 + 0.05
    p = np.zeros(10)
    p[0] = 0.65 * (0.2794 - 0.38) + 0.2794 * (0.04 + wrist)
    p[2] = 0.04 * (0.3645 - 0.25) + 0.3645 * wrist
    p[3] = 0.14 * (0.1506 - 0.084) + 0.1506 * (0.04 + 0.05)
    p[5] = sign * (0.14 * 0.12 + 0.04 * 0.036)
    p[6] = 0.04 * -0.065 + 0.05 * -0.025
    p[8] = 0.05 * 0.05
    for q in np.random.default_rng(8).uniform(mtm.q_min, mtm.q_max, (100, 7)):
        tau = mtm.gravity(q)
        assert np.abs(tau[1:6] - G * regressor(q) @ p).max() < 1e-12
        assert abs(tau[0]) < 1e-12  # the axis is vertical
        assert abs(tau[6]) < 1e-12  # the handle is balanced


def test_scaled_model_changes_masses_but_not_kinematics(arm):
    q = 0.5 * (arm.q_min + arm.q_max)
    heavier = arm.with_scaled_masses(np.full(arm.n, 1.3))
    assert np.allclose(heavier.gravity(q), 1.3 * arm.gravity(q), atol=1e-14)
    assert np.allclose(heavier.mass_matrix(q), 1.3 * arm.mass_matrix(q), atol=1e-14)
    assert np.array_equal(heavier.fk(q), arm.fk(q))


def test_gravity_follows_the_mounting():
    mtm = palpate.Arm.mtm("right")
    upright = mtm.gravity(mtm.home)
    mtm.set_gravity(np.array([0.0, 0.0, 9.81]))
    assert np.allclose(mtm.gravity(mtm.home), -upright)
