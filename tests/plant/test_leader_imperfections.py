"""Each imperfection of the simulated leader against its closed form: delay, jitter, lag, limits, counts, filters."""

import numpy as np
import pytest
from driven_leader import driven_leader
from plant_constants import DT, Q0

from palpate import _core

ZERO = np.zeros(7)


@pytest.fixture
def bare(mtm, frictionless, no_hand):
    """Factory of leaders in which a torque on joint 1 meets only inertia."""

    def make(**changes):
        for key, value in changes.items():
            setattr(frictionless, key, value)
        leader = _core.Leader(mtm, frictionless, no_hand)
        leader.reset(Q0)
        return leader

    return make


def torques(leader, mtm, commands, periods):
    """Drive torque on joint 1 in each servo period [N m], from the acceleration during a small motion.

    commands: one torque of joint 1 for every `periods` periods.
    """
    M = mtm.mass_matrix(Q0) + np.diag(np.array(mtm.leader_options().rotor_inertia))
    J = mtm.jacobian(Q0)
    hand = _core.HandOptions()
    M += J.T @ np.diag([hand.mass] * 3 + [hand.inertia] * 3) @ J
    out, tau, X, G = [], np.zeros(7), mtm.fk(Q0), mtm.holding(Q0)
    for command in commands:
        tau[0] = command
        leader.command(tau, G, ZERO)
        for _ in range(periods):
            before = leader.v
            leader.step(DT, X)
            out.append(float((M @ (leader.v - before))[0] / DT))
    return np.array(out)


@pytest.mark.parametrize("rate", [100, 500, 1000, 10_000])
@pytest.mark.parametrize("delay", [0.0, 0.0037, 0.02])
def test_delay_measured_by_cross_correlation(bare, mtm, rate, delay):
    periods = round(1.0 / rate / DT)
    signs = np.where(np.random.default_rng(1).random(round(0.6 * rate)) < 0.5, -1.0, 1.0)
    sent = np.repeat(0.01 * signs, periods)
    got = torques(bare(loop_delay=delay), mtm, 0.01 * signs, periods)
    lags = np.arange(400)
    correlation = [np.dot(sent[: len(sent) - k], got[k:]) for k in lags]
    assert lags[int(np.argmax(correlation))] * DT == pytest.approx(delay, abs=0.5 * DT)


def arrivals(leader, mtm, count, periods):
    """Times [s] at which each of `count` commands, one every `periods` periods, begins to act."""
    got = torques(leader, mtm, 0.004 * (np.arange(count) % 3 - 1), periods)
    steps = np.flatnonzero(np.abs(np.diff(got)) > 1e-3) + 1
    return steps * DT


def test_jitter_is_uniform_and_seeded(bare, mtm):
    delay, jitter, every, count = 0.005, 0.004, 0.01, 300
    at = arrivals(bare(loop_delay=delay, loop_jitter=jitter, seed=7), mtm, count, round(every / DT))
    late = at - every * np.arange(len(at)) - delay
    assert len(at) == count
    assert late.min() >= -0.5 * DT
    assert late.max() <= jitter + 0.5 * DT
    # Mean and standard deviation of a uniform distribution, within three standard errors of 300 samples.
    assert late.mean() == pytest.approx(jitter / 2, abs=3 * jitter / np.sqrt(12 * count))
    assert late.std() == pytest.approx(jitter / np.sqrt(12), rel=0.1)
    again = arrivals(bare(loop_delay=delay, loop_jitter=jitter, seed=7), mtm, 50, round(every / DT))
    other = arrivals(bare(loop_delay=delay, loop_jitter=jitter, seed=8), mtm, 50, round(every / DT))
    assert np.array_equal(again, at[:50])
    assert not np.array_equal(other, at[:50])


def test_no_command_overtakes_another(bare, mtm):
    """With a jitter of ten cycles, a command never acts after a newer one."""
    commands = 1e-5 * np.arange(1, 400)
    got = torques(bare(loop_delay=0.002, loop_jitter=0.01), mtm, commands, 10)
    assert np.diff(got).min() > -1e-8
    assert got[-1] < commands[-1]


@pytest.mark.parametrize("jitter", [0.0, 0.02])
def test_gravity_compensation_is_neither_delayed_nor_jittered(mtm, options, no_hand, jitter):
    options.loop_delay, options.loop_jitter = 0.02, jitter
    leader = _core.Leader(mtm, options, no_hand)
    leader.reset(Q0)
    for _ in range(100):
        leader.command(ZERO, mtm.holding(Q0), ZERO)
        leader.step(DT, mtm.fk(Q0), n=10)
    assert np.array_equal(leader.q, Q0)


@pytest.mark.parametrize("lag", [0.001, 0.005])
def test_step_response_of_a_drive_is_of_first_order(bare, mtm, lag):
    got = torques(bare(drive_lag=lag), mtm, [0.01], 200)
    t = DT * (1 + np.arange(200))
    assert got == pytest.approx(0.01 * (1 - np.exp(-t / lag)), abs=2e-5)


def test_lagging_drive_holds_the_arm_from_the_start(bare, mtm):
    leader = bare(drive_lag=0.05)
    for _ in range(100):
        leader.command(ZERO, mtm.holding(leader.q), ZERO)
        leader.step(DT, mtm.fk(Q0), n=10)
    assert np.abs(leader.q - Q0).max() < 1e-9


def test_the_drive_saturates_each_joint_at_its_limit(bare, mtm):
    G = mtm.holding(Q0)
    limit = np.abs(G) + np.array([0.03, 1, 1, 1, 1, 1, 1])
    got = torques(bare(tau_max=limit), mtm, [0.01, 0.02, 0.05, -0.5], 1)
    room = limit[0] - G[0], -limit[0] - G[0]
    assert got == pytest.approx(np.clip([0.01, 0.02, 0.05, -0.5], room[1], room[0]), abs=1e-5)


# ---------------------------------------------------------------- encoders and velocities
def spun(mtm, options, speed, seconds=0.3):
    """The hand moves the handle at a steady speed [m/s] along y; the leader every millisecond."""
    V = np.array([0, speed, 0, 0, 0, 0.0])
    return driven_leader(mtm, options, V, seconds, stiffness=5000.0, damping=60.0, settled=150)


@pytest.mark.parametrize("scale", [0.5, 20.0])
def test_encoder_counts_have_the_given_size(mtm, options, scale):
    A = np.array(options.coupling)
    options.encoder_step = scale * options.encoder_step
    for leader in spun(mtm, options, 0.05):
        counts = np.linalg.solve(A, leader.q_measured) / options.encoder_step
        assert np.abs(counts - np.round(counts)).max() < 1e-6
        assert (np.abs(leader.q_measured - leader.q) <= 0.5 * np.abs(A) @ options.encoder_step + 1e-12).all()


def test_ideal_encoders_give_the_exact_position(mtm, options):
    options.encoder_step = ZERO
    for leader in spun(mtm, options, 0.05):
        assert leader.q_measured == pytest.approx(leader.q, abs=1e-12)


def test_velocity_is_a_whole_number_of_counts_over_the_window(mtm, options):
    window = 0.001
    options.velocity_window = window
    A, seen = np.array(options.coupling), []
    for leader in spun(mtm, options, 0.02):
        counts = np.linalg.solve(A, leader.v_measured) * window / options.encoder_step
        assert np.abs(counts - np.round(counts)).max() < 1e-6
        seen.append(leader.v_measured - leader.v)
    # Rounding at both ends of the window gives at most one count of each motor, apart from the acceleration.
    assert (np.abs(seen).max(axis=0) <= np.abs(A) @ options.encoder_step / window + 0.02).all()
    assert np.std(seen, axis=0)[0] > 0.2 * options.encoder_step[0] / window  # the velocity is noisy


def swung(mtm, options, w, ticks=1500):
    """(t, true v, estimated v) of joint 1 every millisecond, for a hand motion at w [rad/s]."""
    hand = _core.HandOptions()
    hand.stiffness, hand.damping = 20_000.0, 200.0
    leader = _core.Leader(mtm, options, hand)
    leader.reset(Q0)
    X0, rows = mtm.fk(Q0), []
    for k in range(ticks):
        leader.command(ZERO, mtm.holding(leader.q), ZERO)
        for _ in range(10):
            t = leader.t + DT
            X, V = X0.copy(), np.zeros(6)
            X[1, 3] += 0.01 * (1 - np.cos(w * t))
            V[1] = 0.01 * w * np.sin(w * t)
            leader.step(DT, X, V)
        if k >= 500:
            rows.append((leader.t, leader.v[0], leader.v_measured[0]))
    return np.array(rows).T


def response(t, v, estimated, w):
    phase = np.exp(-1j * w * t)
    return (estimated @ phase) / (v @ phase)


def test_window_delays_the_velocity_by_half_its_length(mtm, options):
    options.encoder_step, options.velocity_window = ZERO, 0.008
    w = 2 * np.pi * 5.0
    found = response(*swung(mtm, options, w), w)
    # The mean over a window has a sinc magnitude and a delay of half the window.
    assert found == pytest.approx(np.sinc(w * 0.004 / np.pi) * np.exp(-1j * w * 0.004), abs=3e-3)


def test_low_pass_is_of_first_order(mtm, options):
    options.encoder_step, options.velocity_cutoff = ZERO, 20.0
    w = 2 * np.pi * 10.0
    found = response(*swung(mtm, options, w), w)
    assert found == pytest.approx(1 / (1 + 1j * w / (2 * np.pi * 20.0)), abs=5e-3)
