"""The cycle of a CRTK leader: forces of a wall, and zero force after each fault of its messages."""

import numpy as np
import pytest
from crtk_rig import BIT, DT, WALL0, Device
from effort import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from loop_rig import HEIGHT, Q_FOLLOWER, Q_LEADER, floor, options
from scipy.spatial.transform import Rotation

from palpate import _core
from palpate.arm import Arm
from palpate.record import withheld
from palpate.record.ticks import as_ticks

IN = 0.034  # handle position below its start [m]; the tool's centre is then 5 mm below the floor
RATE_CAP, FORCE_CAP = 50.0, 3.0


def pressed(**changes):
    device = Device(**changes)
    device.run(0.2)
    device.run(0.5, to=IN)
    device.run(0.3)
    assert device.forces[-1] > 1.0
    return device


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


def silent(d):
    pass


def nan(d):
    d.send(p=np.array([np.nan, 0, 0]))


def infinite(d):
    d.send(p=np.array([np.inf, 0, 0]))


def no_rotation(d):
    d.send(quat=np.zeros(4))


def zero_stamp(d):
    d.send(stamp=0.0)


def frozen_stamp(d):
    d.send(stamp=WALL0 + 1.0)


def delayed(d):
    d.send(stamp=d.wall - 0.1)


def clock_jump(d):
    d.send(stamp=d.wall + 3600.0)


def clock_back(d):
    d.send(stamp=d.wall - 3600.0)


def jumping(d):
    p, _ = d.pose(d.depth)
    d.send(p=p + 0.03 * np.array([1.0, 0, 0]) * (round(d.t / DT) % 2))


def spinning(d):
    _, quat = d.pose(d.depth)
    d.send(quat=(Rotation.from_rotvec([0, 0, 1.5 * (round(d.t / DT) % 2)]) * Rotation.from_quat(quat)).as_quat())


def long_quaternion(d):
    d.send(quat=1.3 * d.quat0)


def millimetres(d):
    d.send(p=1e3 * d.pose(d.depth)[0])


def alternating(d):
    """Two sources 3 mm apart, faster than 20 mm in 20 ms but slower than any single limit."""
    p, _ = d.pose(d.depth)
    d.send(p=p + 0.003 * np.array([1.0, 0, 0]) * (round(d.t / DT) % 2))


def rocking(d):
    """As `alternating`, by 6 deg, each orientation twice."""
    turn = Rotation.from_rotvec([0, 0, 0.1 * (round(d.t / DT) // 2 % 2)])
    d.send(quat=(turn * Rotation.from_quat(d.quat0)).as_quat())


def lying_twist(d):
    d.send()
    d.cycle.leader_twist(d.wall, np.array([0.0, 0.07, 0.0]), np.zeros(3), d.t, d.wall)


def lying_turn(d):
    d.send()
    d.cycle.leader_twist(d.wall, np.zeros(3), np.array([0.0, 0.0, 0.8]), d.t, d.wall)


def huge_twist(d):
    d.send()
    d.cycle.leader_twist(d.wall, np.array([0.0, 9.0, 0.0]), np.zeros(3), d.t, d.wall)


def invalid_twist(d):
    d.send()
    d.cycle.leader_twist(d.wall, np.array([np.nan, 0, 0]), np.zeros(3), d.t, d.wall)


def two_grippers(d):
    d.send()
    d.cycle.gripper(d.wall, np.zeros(2))


FAULTS = {
    silent: "leader_stale",
    nan: "not_finite",
    infinite: "not_finite",
    no_rotation: "not_rotation",
    long_quaternion: "not_rotation",
    millimetres: "too_far",
    zero_stamp: "bad_stamp",
    frozen_stamp: "leader_stale",
    delayed: "clock_offset",
    clock_jump: "clock_offset",
    clock_back: "clock_offset",
    jumping: "jumped",
    spinning: "jumped",
    alternating: "alternating",
    rocking: "alternating",
    invalid_twist: "not_finite",
    lying_twist: "streams_disagree",
    lying_turn: "streams_disagree",
    huge_twist: "streams_disagree",
    two_grippers: "not_finite",
}


QUIET = np.int64(sum(BIT[name] for name in ("force_capped", "rate_capped", "passivity", "settling", "ik_failed")))
DETECTED = {"leader_stale": 0.03, "streams_disagree": 0.05}
"""Time after which a fault can be detected [s]: a velocity needs some displacement to be wrong."""


def assert_zero_soon_without_a_step_back(device, from_row, within=0.05):
    """Check that the force is zero `within` [s] after a row, and that it grows below the rate cap."""
    forces = device.forces
    assert not forces[from_row + round(within / DT) : from_row + round(within / DT) + 50].any()
    vectors = np.array([np.zeros(6) if F is None else F for F in device.F])
    assert (np.diff(forces) <= RATE_CAP * DT * 1.5 + 1e-9).all()
    assert np.isfinite(vectors).all()


@pytest.mark.parametrize("message", FAULTS, ids=lambda f: f.__name__)
def test_faults_of_the_messages_remove_the_force(message):
    device = pressed()
    at = len(device.rows)
    device.run(0.2, message=message)
    status = np.bitwise_or.reduce(device.ticks["status"][at:].astype(np.int64))
    assert status & BIT[FAULTS[message]]
    others = status & ~np.int64(BIT[FAULTS[message]]) & ~QUIET
    assert not others or message in (jumping, spinning), "one cause sets one bit"
    detectable = DETECTED.get(FAULTS[message], 0.0)
    assert_zero_soon_without_a_step_back(device, at, 0.05 + detectable)
    back = len(device.rows)
    device.run(0.6)
    assert_zero_soon_without_a_step_back(device, at, 0.05 + detectable)
    assert not device.forces[back : back + 90].any(), "all conditions must hold for 0.1 s first"
    assert device.ticks["status"][back + 50].astype(np.int64) & BIT["settling"]
    assert device.forces[-1] > 1.0, "the force returns"


GATES = {
    "following": ("following", False, "not_following"),
    "clutch": ("clutch", True, "clutched"),
    "arm_in_fault": ("leader_enabled", False, "not_enabled"),
    "second_writer": ("second_writer", True, "second_writer"),
    "other_teleop": ("other_teleop", True, "other_teleop"),
    "guarded": ("guarded", True, "guarded"),
    "frame_unsure": ("frame_unsure", True, "frame_unsure"),
    "two_sources": ("two_sources", True, "two_sources"),
    "no_listener": ("no_listener", True, "no_listener"),
    "base_moved": ("base_moved", True, "base_moved"),
}


@pytest.mark.parametrize("gate", GATES)
def test_each_gate_removes_the_force_and_sets_its_status(gate):
    field, value, name = GATES[gate]
    device = pressed()
    at = len(device.rows)
    setattr(device.gates, field, value)
    tick, F, *_ = device.run(0.2)
    assert int(tick["status"]) & BIT[name]
    assert_zero_soon_without_a_step_back(device, at)
    assert (F is None) == (gate in ("arm_in_fault", "other_teleop")), "no wrench is sent in these states"
    setattr(device.gates, field, not value)
    device.run(0.6)
    assert_zero_soon_without_a_step_back(device, at)
    assert device.forces[-1] > 0.5


@pytest.mark.parametrize("gate", ["arm_in_fault", "other_teleop"])
def test_zero_wrench_is_sent_before_sending_stops(gate):
    """An arm keeps the last wrench, so zero is sent before the gate stops all wrenches."""
    field, value, _ = GATES[gate]
    device = pressed()
    setattr(device.gates, field, value)
    device.run(0.1)
    sent = [F for F in device.F if F is not None]
    assert not sent[-1].any()
    assert device.F[-1] is None
    assert all(F is None for F in device.F[-round(0.05 / DT) :]), "then nothing is sent"


CAUSES = {
    "norm of a quaternion": (long_quaternion, "not_rotation", 1.3),
    "zero quaternion": (no_rotation, "not_rotation", 0.0),
    "clock ahead": (clock_jump, "clock_offset", 3600.0),
    "clock behind, or a delay": (delayed, "clock_offset", -0.1),
    "distance": (alternating, "alternating", 0.003),
    "velocity": (lying_twist, "streams_disagree", 0.07),
}


@pytest.mark.parametrize("cause", CAUSES)
def test_cause_has_its_value_in_the_tick(cause):
    message, name, value = CAUSES[cause]
    device = pressed()
    at = len(device.rows)
    device.run(0.2, message=message)
    ticks = device.ticks[at:]
    (first,) = np.flatnonzero(ticks["status"].astype(np.int64) & BIT[name])[:1]
    number, found, _ = ticks["cause"][first]
    assert 1 << int(number) == BIT[name]
    assert found == pytest.approx(value, rel=1e-6, abs=1e-9)
    assert not device.ticks["cause"][:at].any()


def test_a_hand_that_trembles_and_turns_fast_is_no_fault():
    """10 Hz with 5 mm and 0.3 rad, encoder steps of 0.05 mm, and a twist that lags behind by 8 ms."""
    device, phase = pressed(), 2 * np.pi * 10.0
    at, random, twists = len(device.rows), np.random.default_rng(1), []

    def tremble(d):
        s = np.sin(phase * (d.t - t0))
        p, quat = d.pose(d.depth + 0.005 * s)
        twists.append((0.005 * phase * np.cos(phase * (d.t - t0)) * d.down, 0.3 * phase * np.cos(phase * (d.t - t0))))
        v, w = twists[max(0, len(twists) - 9)]
        turned = Rotation.from_rotvec([0, 0, 0.3 * s]) * Rotation.from_quat(quat)
        d.cycle.leader_twist(d.wall, v, np.array([0, 0, w]), d.t, d.wall)
        d.send(p=np.round((p + random.normal(0.0, 1e-5, 3)) / 5e-5) * 5e-5, quat=turned.as_quat())

    t0 = device.t
    device.run(1.0, message=tremble)
    assert not np.bitwise_or.reduce(device.ticks["status"][at:].astype(np.int64)) & ~QUIET


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
