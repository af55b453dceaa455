"""Packets, clocks and ages of packets."""

import numpy as np
import pytest

from palpate import _network


def datagram(rng):
    d = _network.Datagram()
    d.t, d.t_peer, d.t_received = rng.uniform(0, 1e5, 3)
    R, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    X = np.eye(4)
    X[:3, :3] = R * np.sign(np.linalg.det(R))
    X[:3, 3] = rng.normal(size=3)
    d.X, d.v, d.F = X, rng.normal(size=3), rng.normal(size=3)
    d.jaw, d.energy_in, d.energy_out, d.play_delay = rng.uniform(0, 1, 4)
    d.flags = int(rng.integers(0, 64))
    m = d.model
    m.object, m.shift = int(rng.integers(0, 32)), rng.normal(size=3) * 1e-3
    m.K, m.B, m.mu, m.sd_K, m.sd_shift, m.margin = rng.uniform(0, 500, 6)
    d.model = m
    return d


def test_a_packet_is_read_as_it_was_written():
    rng = np.random.default_rng(1)
    for _ in range(50):
        d = datagram(rng)
        bytes_ = _network.encode(d)
        assert len(bytes_) == _network.PACKET_SIZE
        got = _network.decode(bytes_)
        for key in ("t", "t_peer", "t_received", "energy_in", "energy_out", "play_delay", "flags"):
            assert getattr(got, key) == getattr(d, key)
        np.testing.assert_allclose(got.X, d.X, atol=1e-6)
        for key in ("v", "F"):
            np.testing.assert_allclose(getattr(got, key), getattr(d, key), rtol=1e-6)
        for key in ("object", "K", "B", "mu", "sd_K", "sd_shift", "margin"):
            assert getattr(got.model, key) == pytest.approx(getattr(d.model, key), rel=1e-6)


def test_no_bytes_give_a_packet_that_is_not_finite_or_impossible():
    """Random bytes, and packets with damaged bytes: a packet that is read is finite, near, and a rotation."""
    rng = np.random.default_rng(2)
    good = np.frombuffer(_network.encode(datagram(rng)), np.uint8)
    read = 0
    for k in range(20_000):
        damaged = good.copy()
        if k % 2:
            where = rng.integers(0, len(good), rng.integers(1, 6))
            damaged[where] = rng.integers(0, 256, len(where))
        else:
            damaged = rng.integers(0, 256, int(rng.integers(0, 2 * len(good))), dtype=np.uint8)
        got = _network.decode(damaged.tobytes())
        if got is None:
            continue
        read += 1
        X = got.X
        assert np.isfinite([*got.v, *got.F, got.t, got.energy_in, got.jaw, got.model.K, *got.model.shift]).all()
        assert np.abs(X[:3, 3]).max() < 100.0
        np.testing.assert_allclose(X[:3, :3] @ X[:3, :3].T, np.eye(3), atol=1e-6)
        assert got.model.K >= 0.0
    assert read > 100  # damage of a digit gives another valid packet: only encryption tells


def test_other_lengths_and_versions_are_refused():
    good = _network.encode(datagram(np.random.default_rng(3)))
    assert _network.decode(good) is not None
    assert _network.decode(good[:-1]) is None
    assert _network.decode(good + b"\0") is None
    assert _network.decode(bytes([_network.PACKET_VERSION + 1]) + good[1:]) is None


def test_the_replay_window_accepts_each_number_once_and_none_that_is_old():
    rng = np.random.default_rng(4)
    window, seen, newest = _network.ReplayWindow(), set(), 0
    for _ in range(50_000):
        number = max(int(newest + rng.integers(-6000, 200)), 0) if rng.uniform() < 0.999 else newest + 10_000
        wanted = number > 0 and number not in seen and number > newest - 4096
        assert window.accept(number) == wanted
        if wanted:
            seen.add(number)
            newest = max(newest, number)


@pytest.mark.parametrize("drift", [0.0, 5e-5, -2e-4])
def test_offset_and_drift_of_the_other_clock_are_found(drift):
    rng = np.random.default_rng(5)
    clock, offset = _network.ClockSync(), 1234.5
    peer = lambda t: offset + (1.0 + drift) * t  # noqa: E731
    for t in np.arange(0.0, 12.0, 0.002):
        there = t + 0.05 + rng.exponential(0.03)
        back = there + 0.05 + rng.exponential(0.03)
        clock.add(t, peer(there), peer(there), back)
    assert clock.offset(12.0) + 12.0 == pytest.approx(peer(12.0), abs=5e-4)
    assert clock.drift == pytest.approx(drift, abs=4e-5)
    assert clock.bound == pytest.approx(0.05, abs=2e-3)


def test_an_asymmetry_shifts_the_offset_by_half_of_it_and_stays_within_the_bound():
    clock = _network.ClockSync()
    for t in np.arange(0.0, 5.0, 0.01):
        clock.add(t, t + 0.08, t + 0.08, t + 0.10)  # 80 ms there, 20 ms back, equal clocks
    assert clock.offset(5.0) == pytest.approx(0.03, abs=1e-6)
    assert abs(clock.offset(5.0)) <= clock.bound


def ages(rng, seconds, delay, jitter, loss, burst):
    """Age of the newest packet at each millisecond, by sorting all arrivals."""
    t = 1e-3 * np.arange(round(1e3 * seconds))
    lost, bad = np.zeros(len(t), bool), False
    for k in range(len(t)):
        bad = rng.uniform() > 1 / burst if bad else rng.uniform() < loss / (1 - loss) / burst
        lost[k] = bad
    arrival = np.where(lost, np.inf, t + delay + rng.exponential(jitter, len(t)))
    order = np.argsort(arrival)
    newest = np.maximum.accumulate(t[order])
    at = np.searchsorted(arrival[order], t, side="right") - 1
    return np.where(at >= 0, t - newest[np.maximum(at, 0)], np.nan)


def test_percentiles_of_the_age_and_outages():
    rng = np.random.default_rng(6)
    arrivals = _network.Arrivals()
    age = ages(rng, 16.0, 0.05, 0.01, 0.05, 5.0)[200:]
    for a in age:
        arrivals.step(a, 1e-3)
    counted = age[: len(age) - 128]
    for q, got in ((50, arrivals.p50), (99, arrivals.p99), (99.9, arrivals.p999)):
        assert got == pytest.approx(np.percentile(counted, q), abs=2.5e-3)
    assert arrivals.outages == 0
    p999, limit, told = arrivals.p999, arrivals.limit, None
    for k in range(300):
        arrivals.step(age[-1] + 1e-3 * k, 1e-3)
        if arrivals.outage:
            told = age[-1] + 1e-3 * k
            break
    assert told is not None
    assert told == pytest.approx(limit, abs=2e-3)
    assert told - p999 <= 0.050
    assert arrivals.p999 == p999  # the outage itself does not count


def test_the_measured_tail_of_bursts_moves_the_alarm():
    """Gaps that fall exponentially by 10 ms, 20 a second: one an hour is longer than 10 ms ln(72,000) = 112 ms."""
    rng = np.random.default_rng(8)
    arrivals = _network.Arrivals()
    for _ in range(3000):
        for age in [0.005] * 40 + list(0.005 + 1e-3 * np.arange(1, 1 + rng.geometric(0.1))):
            arrivals.step(age, 1e-3)
    assert arrivals.outages == 0
    assert 0.100 < arrivals.limit < 0.145


def test_ages_that_are_no_number_or_out_of_range_count_in_the_outer_bins():
    arrivals = _network.Arrivals()
    for age in (np.nan, -1e300) * 200:
        arrivals.step(age, 1e-3)
    assert arrivals.p50 == arrivals.p999 == pytest.approx(1e-3)
    arrivals.step(np.inf, 1e-3)
    assert arrivals.outage


@pytest.mark.parametrize(("seconds", "settle"), [(np.nan, 1.0), (0.0, 1.0), (1.0, np.nan), (1.0, -1.0), (1.0, 1e300)])
def test_times_without_sense_are_refused_before_alarms_are_counted(seconds, settle):
    with pytest.raises(ValueError, match=r"alarms\.se"):
        _network.count_alarms(_network.Condition(), seconds, settle)


def test_a_route_that_becomes_slower_is_learnt_and_is_no_outage_for_ever():
    arrivals = _network.Arrivals()
    for _ in range(2000):
        arrivals.step(0.02, 1e-3)
    for _ in range(2000):
        arrivals.step(0.2, 1e-3)
    assert not arrivals.outage
    assert arrivals.p99 == pytest.approx(0.2, abs=2e-3)
