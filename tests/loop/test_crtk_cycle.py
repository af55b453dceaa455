"""The cycle of a CRTK leader: forces of a wall, clutch, clocks and losses, and any messages in any order."""

import numpy as np
import pytest
from crtk_rig import (
    BIT,
    DT,
    FORCE_CAP,
    GATES,
    IN,
    RATE_CAP,
    WALL0,
    Device,
    assert_zero_soon_without_a_step_back,
    pressed,
    silent,
)
from effort import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from loop_rig import HEIGHT, Q_FOLLOWER, Q_LEADER, floor, options
from scipy.spatial.transform import Rotation

from palpate import _core
from palpate.arm import Arm
from palpate.record import withheld
from palpate.record.ticks import as_ticks


def test_wall_force_matches_its_stiffness():
    device = pressed()
    tick, F, *_ = device.step()
    depth = 0.002 - (HEIGHT - 0.5 * IN)  # radius of the sphere minus the height of its centre [m]
    np.testing.assert_allclose(tick["depth"], depth, atol=1e-5)
    np.testing.assert_allclose(F[:3], -400.0 * depth * device.down, atol=0.02)
    assert not device.forces[: round(0.2 / DT)].any(), "no force in free space"


def test_tool_moves_as_in_the_cycle_of_arms_with_joints():
    """The cycle of arms with joint measurements is the reference: same poses, goals and contacts."""
    by_joints = _core.Cycle(options(), Arm.mtm("right"), Arm.psm("lnd"))
    device, arm = Device(), Arm.mtm("right")
    device.run(0.2)
    q, q_follower, rows, ticks = Q_LEADER.copy(), Q_FOLLOWER, [], []
    for k in range(600):
        step = np.linalg.pinv(arm.jacobian(q)[:3]) @ device.down * IN / 600
        q = q + (step if k else 0.0)
        X, twist = arm.fk(q), arm.jacobian(q) @ step / DT
        device.t += DT
        device.cycle.leader_twist(device.wall, twist[:3], twist[3:], device.t, device.wall)
        device.send(p=X[:3, 3], quat=Rotation.from_matrix(X[:3, :3]).as_quat())
        ticks.append(device.step()[0])
        row, q_follower, _ = by_joints.step(k * DT, q, step / DT, 0.0, q_follower, 0.0, device.scene)
        rows.append(row)
    joints, poses = as_ticks(np.array(rows)), np.array(ticks)
    assert joints["depth"].max() > 1e-3
    for name, atol in (("p_WT_goal", 1e-9), ("p_WT", 1e-6), ("delta_x", 1e-6), ("F_T_W", 1e-3)):
        np.testing.assert_allclose(poses[name], joints[name], atol=atol)


def test_offset_of_a_clock_within_the_limit_allows_the_force():
    for skew in (-0.02, 0.02):
        device = Device()
        device.skew = skew
        device.run(0.2)
        device.run(0.5, to=IN)
        assert device.forces[-1] > 0.5


def test_withheld_forces_add_up_to_what_the_hand_does_not_feel():
    device = pressed()
    for gate, value in (("clutch", True), ("clutch", False), ("no_listener", True), ("no_listener", False)):
        setattr(device.gates, gate, value)
        device.run(0.2)
    device.run(0.3, to=IN + 0.02)  # above the cap
    ticks = device.ticks
    felt = np.linalg.norm(ticks["F_H_L"], axis=1)
    np.testing.assert_allclose(ticks["F_asked"][:, 0] - ticks["F_withheld"].sum(axis=1), felt, atol=1e-9)
    names = withheld.NAMES
    capped = ticks[-1]
    assert names[int(np.argmax(capped["F_withheld"]))] == "force_cap"
    assert capped["F_asked"][0] == pytest.approx(capped["F_asked"][1], abs=0.05), "no guidance"
    pressed_ticks = ticks[ticks["status"].astype(np.int64) & BIT["clutched"] > 0][60:]
    gate = pressed_ticks["F_withheld"][:, names.index("gate")]
    np.testing.assert_allclose(gate, pressed_ticks["F_asked"][:, 0], atol=1e-9)


def test_shift_by_a_fault_is_known_and_taken_back_where_the_tool_is_free():
    """The wall is farther away by the hand's motion in the pause, until the shift is taken back."""
    device = pressed()
    before, moved = device.forces[-1], 0.02
    device.run(0.3, to=IN - 0.02, message=silent)
    device.run(0.4)
    shift = device.ticks["p_shift_W"][-1]
    np.testing.assert_allclose(shift, [0, 0, -0.5 * 0.02], atol=1e-6)  # the tool stays, the hand would have led it up
    device.run(0.4, to=IN - 0.02 - moved)
    controls = _core.Controls()
    controls.take_back_requests = 1
    device.cycle.set_controls(controls)
    device.run(1.0)
    np.testing.assert_allclose(device.ticks["p_shift_W"][-1], 0.0, atol=1e-12)
    speed = np.linalg.norm(np.diff(device.ticks["p_WT_goal"][-950:], axis=0), axis=1).max() / DT
    assert speed <= 0.02 + 1e-6
    device.run(0.6, to=IN)
    device.run(0.3)
    assert device.forces[-1] == pytest.approx(before, rel=0.02)


def test_clutch_chooses_a_new_relation_and_leaves_no_shift():
    device = pressed()
    device.run(0.3, to=IN - 0.01, message=silent)
    device.run(0.3)
    assert np.linalg.norm(device.ticks["p_shift_W"][-1]) > 0.004
    device.gates.clutch = True
    device.run(0.2, to=IN)
    device.gates.clutch = False
    device.run(0.2)
    assert not device.ticks["p_shift_W"][-1].any()


def test_unknown_states_forbid_the_force():
    device = Device()
    device.gates = _core.CrtkGates()
    device.run(0.3, to=IN)
    assert all(F is None for F in device.F)


def test_own_teleoperation_needs_an_operator_and_starts_at_the_tool():
    device = Device(virtual_follower=False, own_teleop=True)
    X_BT = Arm.psm("lnd").fk(Q_FOLLOWER)
    quat = Rotation.from_matrix(X_BT[:3, :3]).as_quat()

    def both(d):
        d.send()
        d.cycle.follower_pose(d.wall, X_BT[:3, 3], quat, d.t, d.wall)

    device.gates.operator_present = False
    tick, _, goal, _ = device.run(0.3, to=0.004, message=both)
    assert goal is None
    assert int(tick["status"]) & BIT["no_operator"]
    device.gates.operator_present = True
    *_, goal, _ = device.run(DT, message=both)
    np.testing.assert_allclose(goal, X_BT, atol=1e-9)
    *_, goal, _ = device.run(0.2, to=0.008, message=both)
    np.testing.assert_allclose(goal[:3, 3] - X_BT[:3, 3], [0, 0, -0.002], atol=1e-9)
    tick, _, goal, _ = device.run(0.5, to=0.2, message=both)  # the follower does not move
    status = np.bitwise_or.reduce(device.ticks["status"][-400:].astype(np.int64))
    assert status & BIT["lagging"]


def test_silent_follower_is_a_fault():
    device = Device(virtual_follower=False)
    X_BT = Arm.psm("lnd").fk(Q_FOLLOWER)
    X_BT[2, 3] -= HEIGHT  # penetration by the radius of the sphere
    quat = Rotation.from_matrix(X_BT[:3, :3]).as_quat()

    def above(d):
        d.send()
        d.cycle.follower_pose(d.wall, X_BT[:3, 3] + [0, 0, 0.01 * max(0.0, 0.5 - d.t)], quat, d.t, d.wall)

    device.run(1.0, message=above)
    assert device.forces[-1] == pytest.approx(400.0 * 0.002, rel=0.05)
    at = len(device.rows)
    tick, *_ = device.run(0.2)
    assert int(tick["status"]) & BIT["follower_stale"]
    assert_zero_soon_without_a_step_back(device, at, 0.08)


def test_lost_repeated_and_reordered_messages_are_no_fault():
    device, random = pressed(), np.random.default_rng(3)
    at = len(device.rows)

    def reorder(d):
        if random.random() < 0.2:
            return
        d.send()
        if random.random() < 0.2:
            d.send()
        if random.random() < 0.2:
            d.send(stamp=d.wall - 0.003)

    device.run(1.0, message=reorder)
    status = np.bitwise_or.reduce(device.ticks["status"][at:].astype(np.int64))
    caps = BIT["force_capped"] | BIT["rate_capped"] | BIT["passivity"]
    assert status & ~caps == 0
    assert device.forces[at:].min() > 0.9 * device.forces[at]


def test_leader_too_slow_for_the_cycle_is_reported_without_force():
    device = Device()

    def slow(d):
        if round(d.t / DT) % 10 == 0:
            d.send()

    tick, F, *_ = device.run(1.0, to=IN, message=slow)
    assert int(tick["status"]) & BIT["slow"]
    assert not F.any()


def test_stalled_cycle_restarts_at_zero_force():
    device = pressed()
    at = len(device.rows)
    device.t += 1.0  # suspended by the system, without messages
    device.run(0.3)
    status = device.ticks["status"][at].astype(np.int64)
    assert status & BIT["stalled"]
    assert device.forces[at] == 0.0
    assert_zero_soon_without_a_step_back(device, at)


def test_force_grows_from_zero_after_a_takeover_by_the_guardian():
    device = pressed()
    at = len(device.rows)
    device.cycle.drop()
    device.run(0.4)
    assert device.forces[at] == 0.0
    assert device.forces[at : at + 90].max() == 0.0
    assert device.forces[-1] > 0.5
    assert_zero_soon_without_a_step_back(device, at, 0.02)


def test_tip_frame_wrench_is_the_same_wrench_in_the_axes_of_the_handle():
    plain, tip = pressed(), pressed(tip_frame=True)
    R_LH = plain.X0[:3, :3]
    np.testing.assert_allclose(R_LH @ tip.F[-1][:3], plain.F[-1][:3], atol=1e-12)


def test_change_of_the_motion_scale_gives_no_force_step():
    device = pressed()
    device.cycle.set_scale(0.25)
    at = len(device.rows)
    device.run(0.3)
    assert abs(np.diff(device.forces[at - 1 :])).max() < 0.06


def test_invalid_options_are_rejected():
    o = options()
    with pytest.raises(ValueError, match="a virtual follower needs its arm"):
        _core.CrtkCycle(Device().options)
    o.source = "estimate"
    with pytest.raises(ValueError, match="CRTK does not report"):
        _core.CrtkCycle(_core.CrtkOptions(o, Q_FOLLOWER), Arm.psm("lnd"))


numbers = st.one_of(st.floats(-0.05, 0.05), st.sampled_from([np.nan, np.inf, -np.inf, 1e300, 0.0]))
stamps = st.one_of(st.floats(-0.05, 0.05), st.sampled_from([np.nan, np.inf, -WALL0, 3600.0, -3600.0, -0.1]))
acts = st.one_of(
    st.tuples(st.just("state"), st.floats(0.0, 0.06), st.integers(1, 60)),
    st.tuples(st.just("pose"), stamps, st.tuples(numbers, numbers, numbers, numbers)),
    st.tuples(st.just("twist"), stamps, st.tuples(numbers, numbers, numbers)),
    st.tuples(st.just("gate"), st.sampled_from([g[0] for g in GATES.values()]), st.booleans()),
    st.tuples(st.just("wait"), st.floats(0.0, 0.2), st.integers(0, 3)),
    st.tuples(st.just("clock"), st.sampled_from([-10.0, -0.04, 0.04, 10.0]), st.integers(0, 3)),
    st.tuples(st.just("grip"), stamps, st.lists(numbers, max_size=9)),
    st.tuples(st.just("scale"), numbers, st.just(0)),
)


@settings(max_examples=examples(25), deadline=None)
@given(st.lists(acts, max_size=25))
def test_force_is_finite_capped_and_continuous_for_any_messages(events):
    d, wall = Device(scene=floor()), 0.0
    d.run(0.15)
    d.run(0.2, to=IN)
    t0, F0, gated_at = d.t, np.array(d.F[-1]), None
    for kind, a, b in events:
        for _ in range(b if kind == "state" else 1):
            d.t += a if kind == "wait" else DT
            if kind == "state":
                d.depth += np.clip(a - d.depth, -0.002, 0.002)
                d.send(stamp=d.wall + wall)
            elif kind == "pose":
                d.send(stamp=d.wall + a, p=d.X0[:3, 3] + np.array(b[:3]), quat=np.array([*b[:3], 1.0 + b[3]]))
            elif kind == "twist":
                d.cycle.leader_twist(d.wall + a, np.array(b), np.array(b), d.t, d.wall)
            elif kind == "gate":
                setattr(d.gates, a, b)
            elif kind == "clock":
                wall += a
            elif kind == "grip":
                d.cycle.gripper(d.wall + a, np.array(b))
                d.cycle.leader_joints(d.wall + a, np.array(b))
            elif kind == "scale":
                d.cycle.set_scale(a)
            tick, F, *_ = d.step()
            F = np.zeros(6) if F is None else np.asarray(F)
            assert np.isfinite(F).all()
            assert np.linalg.norm(F[:3]) <= FORCE_CAP * (1 + 1e-9)
            growth = np.linalg.norm(F[:3]) - np.linalg.norm(F0[:3])
            assert growth <= RATE_CAP * min(d.t - t0, 1.5 * DT) + 1e-9
            free = BIT["force_capped"] | BIT["rate_capped"] | BIT["passivity"] | BIT["ik_failed"]
            if int(tick["status"]) & ~free:
                gated_at = d.t if gated_at is None else gated_at
                assert d.t - gated_at < 0.031 or not F.any()
            else:
                gated_at = None
            t0, F0 = d.t, F
