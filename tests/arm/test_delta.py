"""The delta device's closed forms against its geometry, virtual work and MuJoCo."""

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import palpate
from palpate.base.errors import ArmError

PARAMETERS = {
    "base_radius": 0.10,
    "platform_radius": 0.03,
    "upper": 0.13,
    "rod": 0.26,
    "upper_mass": 0.08,
    "rod_mass": 0.03,
    "platform_mass": 0.12,
    "torque_max": 1.0,
}
AZIMUTHS = np.radians([0, 120, 240])


@pytest.fixture(scope="module")
def delta():
    return palpate.Arm.model("delta")


joints = st.tuples(*[st.floats(-0.7, 1.3)] * 3).map(np.array)


@settings(max_examples=60, deadline=None)
@given(joints)
def test_inverse_kinematics_inverts_forward_kinematics(delta, q):
    X = delta.fk(q)
    assert np.abs(delta.ik(X) - q).max() < 1e-9
    assert np.abs(delta.fk(delta.ik(X)) - X).max() < 1e-9
    assert np.array_equal(X[:3, :3], np.eye(3))


@settings(max_examples=60, deadline=None)
@given(joints)
def test_every_rod_has_its_nominal_length(delta, q):
    """Rod lengths from the geometry instead of the closed form: knees on circles, rods to the platform's rim."""
    p = delta.fk(q)[:3, 3]
    for angle, azimuth in zip(q, AZIMUTHS, strict=True):
        u = np.array([np.cos(azimuth), np.sin(azimuth), 0])
        knee = (0.10 + 0.13 * np.cos(angle)) * u - [0, 0, 0.13 * np.sin(angle)]
        assert np.linalg.norm(p + 0.03 * u - knee) == pytest.approx(0.26, abs=1e-12)
    assert p[2] < 0


@settings(max_examples=60, deadline=None)
@given(joints)
def test_jacobian_and_its_rate_match_finite_differences(delta, q):
    v, h = np.array([0.7, -1.1, 0.4]), 1e-6
    columns = [(delta.fk(q + h * e) - delta.fk(q - h * e))[:3, 3] / (2 * h) for e in np.eye(3)]
    J = delta.jacobian(q)
    assert np.abs(J[:3] - np.column_stack(columns)).max() < 1e-7
    assert not J[3:].any()
    rate = (delta.jacobian(q + h * v) - delta.jacobian(q - h * v)) @ v / (2 * h)
    assert np.abs(delta.dynamics(q, v)[4] - rate).max() < 1e-7


def test_virtual_work_of_force_and_torques_is_equal(delta):
    """A force on the platform and the torques that balance it do opposite work in any small motion."""
    rng = np.random.default_rng(1)
    for _ in range(20):
        q, F, step = rng.uniform(-0.5, 1.1, 3), rng.normal(size=3), 1e-6 * rng.normal(size=3)
        work = F @ (delta.fk(q + step) - delta.fk(q - step))[:3, 3]
        assert delta.jacobian(q)[:3].T @ F @ (2 * step) == pytest.approx(work, abs=1e-12)


def mujoco_twin():
    """The reduced model in MuJoCo: driven arms with half of the rods' mass at their ends."""
    arms = ""
    for i, azimuth in enumerate(AZIMUTHS):
        yaw = np.degrees(azimuth)
        arms += f"""
        <body pos="{0.10 * np.cos(azimuth)} {0.10 * np.sin(azimuth)} 0" euler="0 0 {yaw}">
          <joint name="q{i}" axis="0 1 0"/>
          <inertial pos="{0.13 / 2} 0 0" mass="0.08" diaginertia="1e-9 {0.08 * 0.13**2 / 12} {0.08 * 0.13**2 / 12}"/>
          <body pos="0.13 0 0"><inertial pos="0 0 0" mass="0.015" diaginertia="1e-9 1e-9 1e-9"/></body></body>"""
    return f"""<mujoco><compiler angle="degree"/><option gravity="0 0 -9.81"/><worldbody>{arms}</worldbody></mujoco>"""


def test_driven_arms_agree_with_mujoco(delta):
    """Without the platform, M and G equal those of three arms with point masses at their ends."""
    model = mujoco.MjModel.from_xml_string(mujoco_twin())
    data = mujoco.MjData(model)
    m = 0.12 + 1.5 * 0.03
    for q in np.random.default_rng(2).uniform(-0.6, 1.2, (10, 3)):
        data.qpos[:], data.qvel[:] = q, 0
        mujoco.mj_forward(model, data)
        J = delta.jacobian(q)[:3]
        M = np.zeros((3, 3))
        mujoco.mj_fullM(model, data, M)
        assert np.abs(delta.mass_matrix(q) - m * J.T @ J - M).max() < 1e-8
        assert np.abs(delta.gravity(q) - J.T @ [0, 0, 9.81 * m] - data.qfrc_bias).max() < 1e-8


def test_unreachable_pose_error_states_the_distance(delta):
    X = delta.fk(delta.home)
    X[2, 3] -= 1.0
    with pytest.raises(ArmError, match="nearest pose found is"):
        delta.ik(X)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rod": 0.15}, "rods are too short"),
        ({"upper": -0.1}, "upper = -0.1.* must be above zero"),
        ({"uper": 0.1}, "no parameter 'uper'.*there are: .*upper"),
        ({"upper": [0.1, 0.2]}, "upper must be one finite number"),
        ({"base_radius": 0.02, "platform_radius": 0.1}, "elbows cross"),
        ({"q_max": 2.0}, "q_min and q_max"),
        ({"upper": None}, "upper is missing"),
    ],
)
def test_invalid_device_parameters_are_reported(change, message):
    parameters = {k: v for k, v in {**PARAMETERS, **change}.items() if v is not None}
    with pytest.raises(ArmError, match=message):
        palpate.Arm.device("delta", parameters)
    with pytest.raises(ArmError, match="no kind of device 'hexapod'; there are: delta"):
        palpate.Arm.device("hexapod", parameters)
