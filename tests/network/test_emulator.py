"""The emulator of links against the closed forms of its distributions."""

import struct

import numpy as np
import pytest

from palpate import _network
from palpate.base.errors import PalpateError
from palpate.session.network import NAMES, network
from palpate.session.network.conditions import MIXTURES, NETFI
from palpate.session.network.traces import read_trace

N = 40_000
PERIOD = 1e-3


def condition(**values):
    c = _network.Condition()
    for key, value in values.items():
        setattr(c, key, value)
    return c


def delays(c, n=N, seed=3, period=PERIOD):
    t = period * np.arange(n)
    return _network.Link(c, seed).send_all(t) - t


@pytest.mark.parametrize("round_trip", MIXTURES)
def test_delays_have_the_distribution_of_the_mixture(round_trip):
    c = network(f"netfi-delay-{1 + list(MIXTURES).index(round_trip)}").to_site
    x = np.sort(delays(c)) - c.delay
    weights, rates = np.array(c.weights), np.array(c.rates)
    cdf = 1.0 - (weights * np.exp(-rates * x[:, None])).sum(1) / weights.sum()
    assert np.abs(cdf - (np.arange(N) + 0.5) / N).max() < 1.95 / np.sqrt(N)  # Kolmogorov's bound at 0.1 %
    assert c.delay == pytest.approx(5e-4 * round_trip)


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.95])
def test_successive_delays_are_correlated_as_asked_with_the_same_distribution(correlation):
    from scipy.stats import norm

    c = condition(weights=[0.6, 0.4], rates=[20.0, 200.0], correlation=correlation)
    x = delays(c)
    z = norm.isf(np.clip((np.array(c.weights) * np.exp(-np.array(c.rates) * x[:, None])).sum(1), 1e-12, 1 - 1e-12))
    effective = N * (1 - correlation) / (1 + correlation)
    assert np.corrcoef(z[1:], z[:-1])[0, 1] == pytest.approx(correlation, abs=4 / np.sqrt(N))
    assert z.mean() == pytest.approx(0.0, abs=4 / np.sqrt(effective))
    assert x.mean() == pytest.approx(0.6 / 20 + 0.4 / 200, rel=5 * 1.5 / np.sqrt(effective))


def test_loss_of_two_states_has_its_share_and_its_bursts():
    c = condition(gilbert=_network.GilbertElliott(0.02, 0.1, 0.01, 0.9))
    lost = np.isnan(delays(c, 200_000))
    bad = 0.02 / 0.12
    assert lost.mean() == pytest.approx(bad * 0.9 + (1 - bad) * 0.01, abs=0.006)
    c = condition(gilbert=_network.GilbertElliott(0.02, 0.1, 0.0, 1.0))
    lost = np.isnan(delays(c, 200_000))
    bursts = np.diff(np.flatnonzero(np.diff(np.concatenate([[0], lost, [0]]))))[::2]
    assert bursts.mean() == pytest.approx(10.0, abs=5 * 10 / np.sqrt(len(bursts)))


def test_loss_of_four_states_has_the_share_of_its_stationary_chain():
    p13, p31, p32, p23, p14 = 0.01, 0.2, 0.3, 0.4, 0.02
    lost = np.isnan(delays(condition(four=_network.FourStates(p13, p31, p32, p23, p14)), 200_000))
    P = np.array([[1 - p13 - p14, 0, p13, p14], [0, 1 - p23, p23, 0], [p31, p32, 1 - p31 - p32, 0], [1, 0, 0, 0]])
    w, v = np.linalg.eig(P.T)
    stationary = np.real(v[:, np.argmin(abs(w - 1))])
    stationary /= stationary.sum()
    assert lost.mean() == pytest.approx(stationary[2] + stationary[3], abs=0.006)


def test_rate_limit_spaces_packets_and_drops_what_would_wait_too_long():
    c = condition(rate=100_000.0, queue=0.01)
    t = np.zeros(10)
    arrivals = _network.Link(c, 1).send_all(t, 256)
    kept = arrivals[~np.isnan(arrivals)]
    assert np.diff(kept) == pytest.approx(256 / 100_000.0)
    assert len(kept) == 4  # those that begin within 10 ms: 0, 2.56, 5.12, 7.68 ms


def test_order_copies_reordering_and_outages():
    jitter = {"weights": [1.0], "rates": [50.0]}
    assert (np.diff(delays(condition(**jitter)) + PERIOD * np.arange(N)) < 0).any()
    assert (np.diff(delays(condition(**jitter, keep_order=True)) + PERIOD * np.arange(N)) >= 0).all()
    held = delays(condition(delay=0.01, reorder=0.1, reorder_delay=0.02))
    assert (held > 0.02).mean() == pytest.approx(0.1, abs=0.01)
    link = _network.Link(condition(duplicate=0.25), 5)
    copies = [len(link.send(PERIOD * k)) for k in range(8000)]
    assert np.mean(copies) == pytest.approx(1.25, abs=0.03)
    lost = np.isnan(delays(condition(outages=[(2.0, 0.5)]), 4000))
    assert np.flatnonzero(lost).tolist() == list(range(2000, 2500))
    lost = np.isnan(delays(condition(outage_every=1.0, outage_min=0.2, outage_max=0.4), 400_000))
    assert lost.mean() == pytest.approx(0.3 / 1.3, abs=0.04)


def test_the_same_seed_gives_the_same_link_and_another_seed_another_one():
    c = network("netfi-loss-3").to_site
    c.weights, c.rates = [1.0], [40.0]
    first, again, other = (delays(c, 2000, seed) for seed in (7, 7, 8))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other, equal_nan=True)


def test_there_are_nine_conditions_of_netfi_and_every_name_is_valid():
    assert len(NETFI) == 9
    for name in NAMES:
        network(name).to_site.check()
        network(name).to_operator.check()
    with pytest.raises(PalpateError, match=r"(?s)no network condition is named 'netfi'.*netfi-delay-1.*FILE\.pcap"):
        network("netfi")


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"delay": -1.0}, r"network\.delay = -1.0+: must lie in 0\.\.60 s"),
        ({"delay": float("nan")}, r"network\.delay = -?nan"),
        ({"weights": [0.5, 0.4], "rates": [1.0, 2.0]}, r"network\.weights = 0\.9.*add up to 1"),
        ({"weights": [1.0], "rates": []}, r"must be as many as the rates"),
        ({"weights": [1.0], "rates": [0.0]}, r"network\.rates = 0"),
        ({"correlation": 1.0}, r"network\.correlation"),
        ({"duplicate": 1.5}, r"network\.duplicate = 1\.5.*probability"),
        ({"rate": -1.0}, r"network\.rate"),
        ({"outage_every": 1e-9, "outage_max": 0.1}, r"network\.outage_every.*1 ms or more"),
        ({"trace": [(1.0, 0.1), (1.0, 0.1)]}, r"network\.trace = 1\.0+: times must increase"),
    ],
)
def test_a_wrong_condition_is_named(values, words):
    with pytest.raises(ValueError, match=words):
        _network.Link(condition(**values), 1)


def test_a_table_is_replayed_and_repeats(tmp_path):
    file = tmp_path / "mine.csv"
    file.write_text("t,delay\n0,0.010\n0.5,0.050\n1.0,\n1.5,0.020\n2.0,0.020\n")
    link = network(str(file))
    got = delays(link.to_site, 4000)
    assert got[100] == pytest.approx(0.010)
    assert got[700] == pytest.approx(0.050)
    assert np.isnan(got[1200])
    assert got[1600] == pytest.approx(0.020)
    assert got[2100] == pytest.approx(0.010)  # the second time


@pytest.mark.parametrize(
    "content",
    ["# ping\ntime,delay\n0,0.02\n1,\n2,0.03\n", "Time;Delay\n0;0.02\n1;\n2;0.03\n",
     "\ufefft\td\r\n0\t0.02\r\n1\r\n2\t0.03",
     "host,delay,time\na,0.02,0\na,,1\na,0.03,2\n"],
)  # fmt: skip
def test_tables_of_other_tools_are_read(tmp_path, content):
    (tmp_path / "a.csv").write_text(content, encoding="utf-8")
    assert read_trace(tmp_path / "a.csv") == [(0.0, 0.02), (1.0, -1.0), (2.0, 0.03)]


def write_pcap(path, times, order="<", magic=0xA1B2C3D4):
    data = struct.pack(order + "IHHiIII", magic, 2, 4, 0, 0, 65535, 1)
    unit = 1e-6 if magic == 0xA1B2C3D4 else 1e-9
    for t in times:
        fraction = round((t % 1) / unit) % round(1 / unit)
        data += struct.pack(order + "IIII", int(t), fraction, 4, 4) + b"abcd"
    path.write_bytes(data)


@pytest.mark.parametrize(("order", "magic"), [("<", 0xA1B2C3D4), (">", 0xA1B2C3D4), ("<", 0xA1B23C4D)])
def test_delays_and_losses_are_read_from_captured_packets(tmp_path, order, magic):
    rng = np.random.default_rng(2)
    late = np.where(rng.uniform(size=500) < 0.3, rng.uniform(0.0, 0.003, 500), 0.0)
    late[0] = 0.0
    kept = rng.uniform(size=500) > 0.05
    kept[0] = True
    write_pcap(tmp_path / "a.pcap", (1000.0 + 0.01 * np.arange(500) + late)[kept], order, magic)
    trace = read_trace(tmp_path / "a.pcap")
    got = np.array([d for _, d in trace])[:500]
    got = np.pad(got, (0, 500 - len(got)), constant_values=-1.0)
    assert ((got < 0) == ~kept).mean() > 0.99
    assert np.abs(got - late)[kept & (got >= 0)].max() < 2e-4


@pytest.mark.parametrize(("jitter", "loss"), [(0.002, 0.0), (0.002, 0.2), (0.001, 0.1)])
def test_jitter_and_losses_of_a_long_capture_are_told_apart(tmp_path, jitter, loss):
    """An error of the period of .3 % made half a period of delay out of 1 ms, and jitter passed for 15 % of losses."""
    rng = np.random.default_rng(3)
    kept = rng.uniform(size=3000) >= loss
    times = 1000.0 + 0.01 * np.arange(3000) + rng.exponential(jitter, 3000)
    write_pcap(tmp_path / "a.pcap", np.sort(times[kept]))
    trace = np.array(read_trace(tmp_path / "a.pcap"))
    assert (trace[:, 1] < 0.0).mean() == pytest.approx(1.0 - kept.mean(), abs=0.005)
    late = trace[trace[:, 1] >= 0.0, 1]
    for share in (0.5, 0.9):
        assert np.quantile(late, share) == pytest.approx(-jitter * np.log(1.0 - share), rel=0.1)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.csv", b"0,1\nx,y\n", "line 2: 'x,y' is no time and delay"),
        ("a.csv", b"1,0.1\n0,0.1\n", "times must increase"),
        ("a.csv", b"0,nan\n1,0.1\n", "times and delays must be finite"),
        ("a.csv", b"0,\n1,\n2,-1\n", ": 0 usable packets"),
        ("a.csv", b"", "0 usable packets"),
        ("a.csv", b'0,"0.1\n1,0.1\n', "a quote is not closed"),
        ("a.csv", b"time,delay\n0,41.2\n1,40.3\n", "the median delay is 40.75 s"),  # milliseconds
        (
            "a.csv",
            b'"No.","Time","Source"\n"1","0.00","10.0.0.1"\n"2","0.01","10.0.0.1"\n',
            "no columns time and delay",
        ),
        ("a.pcap", b"hello", "this is no pcap file"),
        ("a.pcap", struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1), "0 packets"),
    ],
)
def test_a_file_that_is_no_trace_is_told(tmp_path, name, content, words):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(PalpateError, match=words):
        read_trace(tmp_path / name)


def test_packets_that_were_captured_out_of_order_are_read_in_order(tmp_path):
    times = 1000.0 + 0.01 * np.arange(50)
    write_pcap(tmp_path / "a.pcap", np.roll(times, 1))  # the last one stands first
    trace = np.array(read_trace(tmp_path / "a.pcap"))
    np.testing.assert_allclose(trace, np.column_stack([0.01 * np.arange(50), np.zeros(50)]), atol=1e-6)


def test_a_trace_that_the_emulator_cannot_play_is_told(tmp_path):
    (tmp_path / "a.csv").write_text("0,70\n1,0.1\n2,0.1\n")
    with pytest.raises(PalpateError, match=r"(?s)cannot be played.*delay above 60 s"):
        network(str(tmp_path / "a.csv"))
