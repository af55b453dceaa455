"""Kinematics of the arms against published test vectors, an independent DH chain and finite differences."""

import dh
import numpy as np
import pytest
from effort import examples
from hypothesis import given, settings
from hypothesis import strategies as st

import palpate
from palpate.base.errors import ArmError

# Tip poses for given joints, rounded to 1e-5 (1e-4 for two positions), computed from the published tables.
VECTORS = [
    ("psm", (0, 0, 0.12, 0, 0, 0), (0, 0, -0.1135), [[0, 1, 0], [1, 0, 0], [0, 0, -1]]),
    (
        "psm",
        (0.3, -0.2, 0.15, 0.5, 0.4, -0.3),
        (0.03991, 0.02532, -0.13478),
        [[0.48719, 0.85989, -0.15245], [0.86956, -0.49379, -0.00631], [-0.08070, -0.12949, -0.98829]],
    ),
    ("mtm", (0,) * 7, (0, -0.3645, -0.1288), [[0, 1, 0], [0, 0, 1], [1, 0, 0]]),
    (
        "mtm",
        (0.2, 0.3, 0.1, -0.4, 1.2, 0.3, 0.5),
        (0.07145, -0.35248, 0.01373),
        [[0.61696, 0.77349, -0.14516], [0.78378, -0.62055, 0.02458], [-0.07107, -0.12894, -0.98910]],
    ),
]


@pytest.mark.parametrize(("kind", "q", "p", "R"), VECTORS)
def test_tip_pose_is_the_published_one(kind, q, p, R):
    arm = palpate.Arm.psm() if kind == "psm" else palpate.Arm.mtm("right")
    X = arm.fk(np.array(q, dtype=float))
    assert np.abs(X[:3, 3] - p).max() < 1e-5
    assert np.abs(X[:3, :3] - R).max() < 1e-5


def test_tip_pose_is_the_product_of_the_dh_table(arm, poses):
    for q in poses:
        expected = dh.psm(q) if arm.n == 6 else dh.mtm(q)[-1]
        assert np.abs(arm.fk(q) - expected).max() < 1e-12


def test_jacobian_is_the_derivative_of_the_tip_pose(arm, poses):
    h = 1e-6
    for q in poses:
        J = arm.jacobian(q)
        for k in range(arm.n):
            step = h * np.eye(arm.n)[k]
            X1, X0 = arm.fk(q + step), arm.fk(q - step)
            W = (X1[:3, :3] - X0[:3, :3]) / (2 * h) @ arm.fk(q)[:3, :3].T
            numeric = np.r_[(X1[:3, 3] - X0[:3, 3]) / (2 * h), W[2, 1], W[0, 2], W[1, 0]]
            assert np.abs(J[:, k] - numeric).max() < 1e-8


def test_tip_acceleration_at_rest_joints_is_the_rate_of_the_jacobian_times_v(arm, poses):
    h, rng = 1e-6, np.random.default_rng(3)
    for q in poses:
        v = rng.normal(size=arm.n)
        numeric = (arm.jacobian(q + h * v) - arm.jacobian(q - h * v)) @ v / (2 * h)
        assert np.abs(arm.dynamics(q, v)[4] - numeric).max() < 1e-7


def test_remote_centre_moves_less_than_a_micrometre():
    """The shaft passes through the base's origin in every pose."""
    psm = palpate.Arm.psm()
    for q in np.random.default_rng(4).uniform(psm.q_min, psm.q_max, (500, 6)):
        X = psm.link_poses(q)["shaft"]
        along = X[:3, 2]  # direction of the shaft
        miss = X[:3, 3] - along * (along @ X[:3, 3])
        assert np.linalg.norm(miss) < 1e-6


def test_wrist_axes_meet_at_the_handle():
    """The position of the handle depends on the first three joints only."""
    mtm = palpate.Arm.mtm("right")
    q = np.array([0.2, 0.1, -0.1, 0.4, 0.5, -0.2, 1.0])
    assert np.abs(mtm.jacobian(q)[:3, 3:]).max() < 1e-15


@settings(max_examples=examples(150), deadline=None, derandomize=True)
@given(
    which=st.sampled_from(["mtm_right", "mtm_left", "psm_lnd"]), where=st.lists(st.floats(0, 1), min_size=7, max_size=7)
)
def test_inverse_kinematics_returns_to_any_reachable_pose(which, where):
    kind, name = which.split("_")
    arm = getattr(palpate.Arm, kind)(name)
    X = arm.fk(arm.q_min + np.array(where[: arm.n]) * (arm.q_max - arm.q_min))
    q = arm.ik(X)
    assert np.abs(arm.fk(q) - X).max() < 1e-6
    assert (q >= arm.q_min).all()
    assert (q <= arm.q_max).all()


def test_warm_started_inverse_kinematics_converges_in_a_few_steps(arm, poses):
    rng = np.random.default_rng(5)
    for q in poses:
        start = np.clip(q + rng.normal(0, 0.01, arm.n), arm.q_min, arm.q_max)
        near, result = arm.ik_from(arm.fk(q), start)
        assert result.converged
        assert result.iterations <= 5
        assert np.abs(near - start).max() < 0.2


def test_inverse_kinematics_of_an_unreachable_pose_states_the_residual(arm):
    X = arm.fk(arm.home)
    X[:3, 3] += [0, 0, 2.0]
    q, result = arm.ik_from(X, arm.home)
    assert not result.converged
    assert result.position_error > 1.0
    assert np.isfinite(q).all()
    with pytest.raises(ArmError, match="cannot reach the tip pose"):
        arm.ik(X, restarts=2)


def test_links_of_no_poses_are_no_poses():
    arm = palpate.Arm.psm()
    assert arm.link_poses(np.zeros((0, arm.n)), np.zeros(0))["tip"].shape == (0, 4, 4)
