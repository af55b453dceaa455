"""For any arm states the force is finite, capped and rate-limited, and gravity stays compensated."""

import math

import numpy as np
from effort import examples
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from loop_rig import Q_FOLLOWER, Q_LEADER, floor, options

from palpate import _core
from palpate.arm import Arm
from palpate.record.ticks import as_ticks

DT = 1e-3
LEADER_STALE, FOLLOWER_STALE, NOT_FINITE = 4, 8, 16


def inside():
    """Options with the follower 1.5 mm inside the floor (sphere of 2 mm)."""
    X_WB = options().X_WB
    X_WB[2, 3] -= 0.0115
    return options(X_WB=X_WB)


class Driver:
    """A cycle with its arm states as arguments."""

    def __init__(self, o=None):
        self.cycle = _core.Cycle(o or inside(), Arm.mtm("right"), Arm.psm("lnd"))
        self.scene = floor()
        self.k = 0

    def step(self, q=Q_LEADER, v=None, gripper=0.0, q_follower=Q_FOLLOWER, t=None, **kwargs):
        t = self.k * DT if t is None else t
        self.k += 1
        v = np.zeros(7) if v is None else v
        row, q_command, _ = self.cycle.step(t, q, v, gripper, q_follower, 0.0, self.scene, **kwargs)
        return as_ticks(row)[0], q_command


def warm(n=60):
    d = Driver()
    for _ in range(n):
        row, _ = d.step()
    assert np.linalg.norm(row["F_H_L"]) > 0.2
    return d, row


def test_silent_leader_ramps_the_force_down_and_keeps_gravity_compensation():
    d, row = warm()
    gravity, last, t_seen = row["tau_gravity"], row["F_H_L"], (d.k - 1) * DT
    for k in range(150):
        row, _ = d.step(t_leader=t_seen)
        F = row["F_H_L"]
        assert np.linalg.norm(F - last) <= 50 * DT
        last = F
        assert bool(int(row["status"]) & LEADER_STALE) == (k >= 30)
        np.testing.assert_array_equal(row["tau_gravity"], gravity)
    assert not last.any()
    assert not row["tau_force"].any()
    assert row["tau_gravity"].any()


def test_silent_follower_ramps_the_force_down():
    d, _ = warm()
    t_seen = (d.k - 1) * DT
    for _ in range(150):
        row, _ = d.step(t_follower=t_seen)
    assert int(row["status"]) & FOLLOWER_STALE
    assert not row["F_H_L"].any()
    assert row["tau_gravity"].any()


def test_nan_of_an_encoder_stops_the_force_until_it_recovers():
    d, before = warm()
    invalid = Q_LEADER.copy()
    invalid[2] = math.nan
    for _ in range(100):
        row, q_command = d.step(q=invalid)
        assert np.isfinite(row["tau"]).all()
        assert np.isfinite(q_command).all()
    assert int(row["status"]) & NOT_FINITE
    assert not row["F_H_L"].any()
    np.testing.assert_array_equal(row["tau_gravity"], before["tau_gravity"])
    for _ in range(100):
        row, _ = d.step()
    np.testing.assert_allclose(row["F_H_L"], before["F_H_L"], atol=1e-9)


def test_hand_motion_during_a_leader_fault_does_not_move_the_tool():
    d, _ = warm()
    _, held = d.step(leader_valid=False)
    for _ in range(50):
        d.step(leader_valid=False)
    moved = Q_LEADER.copy()
    moved[:3] += 0.1
    for _ in range(3):
        _, q_command = d.step(q=moved)
    psm = Arm.psm("lnd")
    np.testing.assert_allclose(psm.fk(q_command)[:3, 3], psm.fk(held)[:3, 3], atol=1e-7)


def test_tool_motion_during_a_follower_fault_is_neither_reversed_nor_caught_up():
    d, _ = warm()
    for _ in range(50):
        d.step(follower_valid=False)
    hand, tool = Q_LEADER.copy(), Q_FOLLOWER.copy()
    hand[:3] += 0.1  # the hand moved on,
    tool[:3] += 0.05, -0.03, 0.01  # and the instrument was moved by hand
    for _ in range(20):
        d.step(q=hand, follower_valid=False)
    for k in range(20):
        row, q_command = d.step(q=hand, q_follower=tool)
        np.testing.assert_allclose(q_command, tool, atol=0.5 * DT * (k + 1) + 1e-6)  # orientation: align_rate
        assert np.linalg.norm(row["F_H_L"]) <= 50 * DT * (k + 1)
    forth = hand.copy()
    forth[:3] += 0.01
    for _ in range(20):
        _, q_command = d.step(q=forth, q_follower=tool)
    assert np.linalg.norm(q_command - tool) > 1e-3  # the tool follows again


def test_goal_that_returns_into_reach_is_approached_within_the_joint_speeds():
    d = Driver(options(mapping__scale=5.0))
    v_max = Arm.psm("lnd").v_max
    for _ in range(10):
        _, last = d.step()
    lost, steps = False, []
    for q in ((0.6, 0.9, 0.5), (0.05, 0.0, 0.0)):
        hand = Q_LEADER.copy()
        hand[:3] = q
        for _ in range(5):
            row, q_command = d.step(q=hand)
            lost |= bool(int(row["status"]) & 64)
            steps.append(np.abs(q_command - last))
            last = q_command
    assert lost
    assert (np.array(steps) <= v_max * DT * (1 + 1e-9)).all()
    assert np.max(steps) > 0


def test_nothing_is_commanded_before_states_of_both_arms():
    d = Driver()
    row, _ = d.step(leader_valid=False)
    assert not row["tau"].any()
    assert int(row["status"]) & LEADER_STALE


def test_follower_without_state_gets_no_command():
    d = Driver()
    assert len(d.step(follower_valid=False)[1]) == 0
    assert len(d.step()[1]) == 6


def test_leader_gets_gravity_compensation_before_the_first_follower_state():
    row, _ = Driver().step(follower_valid=False)
    gravity = Arm.mtm("right").holding(Q_LEADER)
    np.testing.assert_allclose(row["tau_gravity"], gravity, atol=1e-12)
    assert not row["tau_force"].any()
    assert int(row["status"]) & FOLLOWER_STALE


def test_unreachable_goal_moves_the_follower_within_its_limits_and_sets_the_status():
    """It goes to the nearest pose, with no joint faster or farther than its limits, and rests there."""
    arm = Arm.psm("lnd")
    d = Driver(options(mapping__scale=5.0))
    for _ in range(10):
        _, before = d.step()
    far, last, rests = Q_LEADER.copy(), before, Q_FOLLOWER
    far[:3] = 0.6, 0.9, 0.5
    for _ in range(4000):
        row, q_command = d.step(q=far, q_follower=rests)
        assert int(row["status"]) & 64
        assert (np.abs(q_command - last) <= arm.v_max * 1e-3 + 1e-12).all()
        assert (q_command >= arm.q_min).all()
        assert (q_command <= arm.q_max).all()
        moved, last, rests = np.abs(q_command - last).max(), q_command, q_command
    assert moved < 1e-9
    assert np.abs(last - before).max() > 0.1


wild = st.one_of(st.floats(allow_nan=True, allow_infinity=True), st.floats(-2, 2), st.sampled_from([1e308, math.nan]))
tick = st.fixed_dictionaries(
    {
        "q": st.one_of(st.just(Q_LEADER), st.lists(wild, min_size=7, max_size=7).map(np.array)),
        "v": st.one_of(st.none(), st.lists(wild, min_size=7, max_size=7).map(np.array)),
        "q_follower": st.one_of(st.just(Q_FOLLOWER), st.lists(wild, min_size=6, max_size=6).map(np.array)),
        "gripper": wild,
        "t": st.one_of(st.none(), wild),
        "leader_valid": st.sampled_from([True, True, True, False]),
        "follower_valid": st.sampled_from([True, True, True, False]),
    }
)


@settings(max_examples=examples(40), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@example([{"q": np.full(7, 1e308)}, {"v": np.full(7, 1e308)}, {"q_follower": np.full(6, -1e308)}])
@given(st.lists(tick, min_size=1, max_size=25))
def test_force_is_safe_for_any_arm_states(ticks):
    d = Driver()
    for _ in range(30):
        row, _ = d.step()
    last = row["F_H_L"]
    for t in ticks:
        row, q_command = d.step(**t)
        F = row["F_H_L"]
        assert np.isfinite(F).all()
        assert np.linalg.norm(F) <= 3.0
        assert np.linalg.norm(F - last) <= 50 * DT
        assert np.isfinite(q_command).all()
        assert np.isfinite(row["tau_gravity"]).all()
        last = F
