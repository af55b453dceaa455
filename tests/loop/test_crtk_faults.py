"""Each fault of the messages of a CRTK leader, and each gate, removes the force and sets its own status."""

import numpy as np
import pytest
from crtk_rig import BIT, DT, GATES, WALL0, assert_zero_soon_without_a_step_back, nan, pressed, silent
from scipy.spatial.transform import Rotation


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
