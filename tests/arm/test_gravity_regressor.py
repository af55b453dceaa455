"""The gravity regressor and identified gravity models, against finite differences and Pinocchio."""

import numpy as np
import pinocchio
import pytest

from palpate import Arm, _core
from palpate.arm import models_folder

ARMS = {"mtm_right": Arm.mtm("right"), "mtm_left": Arm.mtm("left"), "psm_lnd": Arm.psm()}


def poses(arm, count=20):
    return np.random.default_rng(5).uniform(arm.q_min, arm.q_max, (count, arm.n))


def slope(function, q, h=1e-5):
    return np.array([(function(q + h * e) - function(q - h * e)) / (2 * h) for e in np.eye(len(q))])


@pytest.mark.parametrize("name", ARMS)
def test_regressor_is_linear_in_the_moments(name):
    arm = ARMS[name]
    for q in poses(arm):
        np.testing.assert_allclose(arm.gravity_regressor(q) @ arm.moments, arm.gravity(q), atol=1e-10)


@pytest.mark.parametrize("side", ["left", "right"])
def test_each_regressor_column_agrees_with_pinocchio(side):
    """Reference: Pinocchio's joint-torque regressor at rest, columns of mass and first moment of every link."""
    model = pinocchio.buildModelFromUrdf(str(models_folder() / f"mtm_{side}.urdf"))
    arm = Arm.mtm(side)
    locked = [j for j in range(1, model.njoints) if model.names[j] not in arm.joint_names]
    model = pinocchio.buildReducedModel(model, locked, np.zeros(model.nq))
    data, rest = model.createData(), np.zeros(model.nv)
    columns = [10 * k + i for k in range(model.nv) for i in range(4)]
    for q in poses(arm):
        Y = pinocchio.computeJointTorqueRegressor(model, data, q, rest, rest)
        np.testing.assert_allclose(arm.gravity_regressor(q), Y[:, columns], atol=1e-10)


def test_regressor_follows_the_gravity_direction():
    arm = Arm.mtm("right")
    arm.set_gravity(np.array([3.0, -4.0, 8.0]))
    q = poses(arm)[0]
    np.testing.assert_allclose(arm.gravity_regressor(q) @ arm.moments, arm.gravity(q), atol=1e-10)


def identified(arm, seed=0):
    rng = np.random.default_rng(seed)
    fields = [
        _core.Field([0, 1, 2], rng.uniform(-0.5, 0.5, (9, 3)), [0.9, 0.5, 1.5]),
        _core.Field([4], rng.uniform(-1, 3, (5, 1)), [2.0]),
    ]
    terms = _core.GravityTerms(degree=4, fields=fields)
    m = arm.gravity_columns(terms, np.zeros((1, arm.n))).shape[2]
    return terms, 0.1 * rng.standard_normal(m)


def test_identified_gravity_is_the_gradient_of_its_energy():
    arm = Arm.mtm("right")
    arm.set_gravity_model(*identified(arm))
    for q in poses(arm, 10):
        slopes = slope(lambda x: arm.potential_energy(x) + arm.elastic_energy(x), q)
        np.testing.assert_allclose(arm.holding(q), slopes, atol=1e-6)
        np.testing.assert_allclose(arm.elastic(q), arm.holding(q) - arm.gravity(q), atol=1e-15)


def test_regressor_times_parameters_is_the_holding_torque():
    arm = Arm.mtm("left")
    terms, theta = identified(arm)
    q = poses(arm)
    arm.set_gravity_model(terms, theta)
    np.testing.assert_allclose(arm.gravity_columns(terms, q) @ theta, [arm.holding(x) for x in q], atol=1e-13)


def test_urdf_moments_give_the_urdf_gravity():
    arm, plain = Arm.mtm("right"), Arm.mtm("right")
    arm.set_gravity_model(_core.GravityTerms(), arm.moments)
    for q in poses(arm):
        np.testing.assert_allclose(arm.holding(q), plain.gravity(q), atol=1e-10)


def test_copies_keep_the_identified_model():
    arm = Arm.mtm("right")
    arm.set_gravity_model(*identified(arm))
    q = poses(arm)[0]
    heavier = arm.with_scaled_masses(np.full(7, 1.3))
    np.testing.assert_allclose(heavier.holding(q), arm.holding(q), atol=1e-13)
    np.testing.assert_allclose(heavier.gravity(q), 1.3 * arm.gravity(q), atol=1e-12)


def test_gravity_terms_that_do_not_match_the_arm_are_rejected():
    arm = Arm.mtm("right")
    with pytest.raises(ValueError, match="needs 28 finite parameters; got 27"):
        arm.set_gravity_model(_core.GravityTerms(), np.zeros(27))
    with pytest.raises(ValueError, match="the arm's joints are 0 to 6"):
        arm.set_gravity_model(_core.GravityTerms(fields=[_core.Field([7], np.zeros((2, 1)), [1.0])]), np.zeros(30))
    with pytest.raises(ValueError, match=r"needs finite centres \(c, 1\)"):
        arm.set_gravity_model(_core.GravityTerms(fields=[_core.Field([1], np.zeros((2, 2)), [1.0])]), np.zeros(30))
    with pytest.raises(ValueError, match=r"shape \(k, 7\)"):
        arm.gravity_columns(_core.GravityTerms(), np.zeros((3, 6)))
