"""The signals of Fig 3 of the paper exist and are consistent."""

import numpy as np
import pytest
from loop_rig import Q_FOLLOWER, Q_LEADER, floor, options, run, simulation

from palpate import _core
from palpate.arm import Arm
from palpate.record.ticks import as_ticks


def quat_to_R(q):
    w, x, y, z = np.moveaxis(q, -1, 0)
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], -1),
            np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], -1),
            np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1),
        ],
        -2,
    )


def test_contact_gives_a_force(pressed):
    assert pressed["depth"].max() > 1e-3
    assert np.linalg.norm(pressed["F_H_L"], axis=1).max() > 0.3
    assert (pressed["contacts"][:200] == 0).all()
    assert (pressed["contacts"][-50:] == 0).all()


def test_deflection_is_proxy_minus_tool(pressed):
    np.testing.assert_array_equal(pressed["delta_x"], pressed["p_WP"] - pressed["p_WT"])
    np.testing.assert_allclose(
        pressed["depth"], np.einsum("ij,ij->i", pressed["delta_x"], pressed["normal"]), atol=1e-15
    )


def test_force_is_its_terms_and_exactly_zero_when_free(pressed):
    np.testing.assert_allclose(pressed["F_T_W"], pressed["F_spring_W"] + pressed["F_damping_W"], atol=1e-15)
    free = pressed["contacts"] == 0
    for name in ("F_T_W", "delta_x", "normal", "depth"):
        assert not pressed[name][free].any()


def test_spring_is_stiffness_times_deflection(pressed):
    """F = K delta_x - B v in the running loop (Eq 6)."""
    np.testing.assert_allclose(pressed["F_spring_W"], 400.0 * pressed["delta_x"], rtol=1e-3, atol=1e-12)


def test_damping_power_on_the_hand_is_never_positive(pressed):
    X_WL = options().X_WL
    F_damping_L = pressed["F_damping_W"] @ X_WL[:3, :3]
    power = np.einsum("ij,ij->i", F_damping_L, pressed["v_LH"])
    assert (power <= 1e-15).all()
    assert power.min() < -1e-4


def test_torque_is_the_sum_of_its_terms(pressed):
    np.testing.assert_allclose(
        pressed["tau"], pressed["tau_force"] + pressed["tau_gravity"] + pressed["tau_platform"], atol=1e-12
    )


def test_force_torque_is_the_transposed_jacobian_by_finite_differences(pressed):
    """Reference: the Jacobian from finite differences of the handle's position."""
    arm, h = Arm.mtm("right"), 1e-6
    for row in pressed[900:2200:150]:
        J = np.array(
            [(arm.fk(row["q"] + h * e)[:3, 3] - arm.fk(row["q"] - h * e)[:3, 3]) / (2 * h) for e in np.eye(7)]
        ).T
        np.testing.assert_allclose(row["tau_force"], J.T @ row["F_H_L"], atol=1e-8)
        np.testing.assert_allclose(row["v_LH"], J @ row["v"], atol=1e-7)


def test_body_force_is_the_spatial_force_in_the_axes_of_the_handle(pressed):
    """The norms agree to 1e-12, and the rotation of the handle transforms one force into the other."""
    np.testing.assert_allclose(
        np.linalg.norm(pressed["F_H_H"], axis=1), np.linalg.norm(pressed["F_H_L"], axis=1), rtol=0, atol=1e-12
    )
    R_LH = quat_to_R(pressed["quat_LH"])
    np.testing.assert_allclose(np.einsum("kij,kj->ki", R_LH, pressed["F_H_H"]), pressed["F_H_L"], atol=1e-12)


def test_wrist_rotation_changes_only_the_body_force():
    """The same contact with other wrist angles of the leader."""
    X_WB = options().X_WB
    X_WB[2, 3] -= 0.0145  # the centre of the sphere is 2.5 mm inside
    rows = []
    for q6, q7 in ((0.0, 0.0), (0.4, -0.3), (-0.5, 1.0)):
        cycle = _core.Cycle(options(X_WB=X_WB), Arm.mtm("right"), Arm.psm("lnd"))
        q = Q_LEADER.copy()
        q[5:] = q6, q7
        for k in range(100):
            row, *_ = cycle.step(1e-3 * k, q, np.zeros(7), 0.0, Q_FOLLOWER, 0.0, floor())
        rows.append(as_ticks(row))
    rows = np.concatenate(rows)
    assert np.linalg.norm(rows["F_H_L"][0]) > 0.5
    for other in rows[1:]:
        np.testing.assert_array_equal(other["F_H_L"], rows["F_H_L"][0])
        np.testing.assert_array_equal(other["F_T_W"], rows["F_T_W"][0])
        assert np.linalg.norm(other["F_H_H"] - rows["F_H_H"][0]) > 0.1
    norms = np.linalg.norm(rows["F_H_H"], axis=1)
    np.testing.assert_allclose(norms, np.linalg.norm(rows["F_H_L"][0]), atol=1e-12)


def test_force_reaches_the_hand_in_the_leaders_frame(pressed):
    R_WL = options().X_WL[:3, :3]
    calm = pressed["status"] == 0
    assert calm.sum() > 2000
    np.testing.assert_allclose(pressed["F_H_L"][calm], pressed["F_T_W"][calm] @ R_WL, atol=1e-12)


def test_the_load_cell_reads_the_commanded_force_at_rest():
    """The difference is within the Coulomb friction of the arm."""
    from palpate import _core

    path = _core.HandPath([0.1, 1.0], np.array([[0, 0, 0.012], [0, 0, -0.008]]))
    o = {"leader__coulomb": np.zeros(7), "leader__viscous": np.full(7, 0.05), "leader__quantised": False}
    ticks = run(simulation(path=path, **o), 4.0)
    F, cell = ticks["F_H_L"][-1], ticks["F_cell_L"][-1]
    assert np.linalg.norm(F) > 0.5
    assert np.linalg.norm(cell - F) < 0.01 * np.linalg.norm(F)


def test_paper_torques_are_zero_at_the_wrist():
    ticks = run(simulation(torque__mode="paper"), 1.2)
    assert np.abs(ticks["tau_force"][:, :3]).max() > 0.01
    assert not ticks["tau_force"][:, 3:].any()


@pytest.mark.parametrize("rate", [0.0, 1e6, float("nan")])
def test_invalid_rate_is_reported(rate):
    with pytest.raises(ValueError, match="rate"):
        simulation(rate=rate)
