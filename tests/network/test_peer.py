"""What an end knows of the other one: a packet that is repeated, or of an operator before, is no sign of life."""

import time

import numpy as np
import pytest

from palpate import _core, _network

DT = 5e-3


def test_an_end_that_repeats_its_last_packet_stays_lost():
    """Its loop stands still and its sockets go on: its clock must not seem to run slowly."""
    mine, other, last = _network.Peer(), _network.Peer(), _network.Datagram()
    for t in np.arange(1.0, 4.0, DT):
        out, last = _network.Datagram(), _network.Datagram()
        mine.stamp(out, t)
        other.receive(out, t)
        other.stamp(last, t)
        mine.receive(last, t)
        mine.step(t)
    assert not mine.lost
    for t in np.arange(4.0, 64.0, DT):
        assert not mine.receive(last, t)
        mine.step(t)
        assert mine.lost or t < 5.5
        assert abs(mine.peer_time(t) - t) < 1e-6


def test_the_answer_to_a_packet_from_before_the_first_tick_tells_nothing_about_clocks():
    """Its time is 0: half of the machine's uptime passed for the offset of the clocks, and for the delay of a video."""
    mine, other, out, answer = _network.Peer(), _network.Peer(), _network.Datagram(), _network.Datagram()
    now = 6e4
    mine.stamp(out, 0.0)
    other.receive(out, now)
    other.stamp(answer, now + 1e-3)
    mine.receive(answer, now + 2e-3)
    assert not mine.clock.known
    mine.stamp(out, now + 0.010)
    other.receive(out, now + 0.011)
    other.stamp(answer, now + 0.012)
    mine.receive(answer, now + 0.013)
    assert abs(mine.peer_time(now) - now) < 1e-6


def test_packets_that_wait_while_the_operator_changes_are_dropped():
    options, nothing, old = _network.FollowerOptions(), _core.Snapshot([]), _network.Datagram()
    follower = _network.Follower(options, nothing, nothing, np.eye(4))
    old.t = 1e6
    assert follower.receive(_network.encode(old), time.monotonic())
    follower.forget_operator()
    follower.start()
    while _network.decode(follower.packet()).t == 0.0:
        time.sleep(1e-3)
    follower.stop()
    assert _network.decode(follower.packet()).t_peer == 0.0


def test_a_port_gives_what_it_takes_less_the_exact_work():
    """A backlash in both sums missed the largest force of each stroke, so that more came back than was counted."""
    port, rng, exact, x = _network.Port(), np.random.default_rng(0), 0.0, np.zeros(3)
    port.step(np.zeros(3), x)
    for k in range(20000):
        z = 1e-3 * np.sin(2e-3 * np.pi * k) + 1e-5 * rng.integers(-1, 2)
        out = np.array([0.0, 0.0, 2.0 if k % 1000 < 250 else 0.5])
        exact -= out[2] * (z - x[2])
        x = np.array([0.0, 0.0, z])
        port.step(out, x)
    assert port.taken - port.given == pytest.approx(exact, abs=1e-12)
    assert port.taken == pytest.approx(0.0196, rel=0.02)  # as without the flicker, which would make it 0.074 J
