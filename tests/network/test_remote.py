"""A session and a follower's end over loopback: felt, learnt, refused, held."""

import os
import re
import signal
import socket
import threading
import time
import warnings
from types import SimpleNamespace

import numpy as np
import pytest

from palpate import __version__, _network
from palpate.base.errors import PalpateError, SceneError
from palpate.cli import main
from palpate.record.reader import Record
from palpate.report import remote as remote_report
from palpate.report import write_report
from palpate.report.run import Run
from palpate.scene import Scene
from palpate.scene.rig import build
from palpate.session import Session
from palpate.session.network import network
from palpate.session.network.keys import make_key

pytest.importorskip("cryptography", reason="links need the extra remote")
from palpate.cli.commands._remote import require
from palpate.session.network import channel as channels
from palpate.session.network.relay import Relay, listen
from palpate.session.remote import link as links
from palpate.session.remote import site as sites
from palpate.session.remote.together import network_name
from palpate_lab.verify.bench.network import _END

KEY = bytes(range(32))


def scene(**remote):
    return Scene.model_validate({
        "objects": [{"name": "table", "plane": {}, "stiffness": 300, "damping": 1}],
        "arms": {"leader": {"model": "mtm_right", "base": {"xyz": [0.345, 0.243, 0.219], "rpy_deg": [0, 0, -20]}},
                 "follower": {"model": "psm_lnd", "base": {"xyz": [-0.12, -0.06, 0.155], "rpy_deg": [0, 0, 205]}}},
        "operator": {"palpate": {"object": "table", "at": [0, 0, 0.1], "force": 1.2, "length": 0.01}},
        "remote": {"site_shift": [0, 0, -0.0015], "site_stiffness": 450, **remote},
    })  # fmt: skip


@pytest.fixture(scope="module")
def rig():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return build(scene())


@pytest.fixture
def follower(rig):
    said = []
    server = sites.FollowerServer(rig, KEY, "127.0.0.1", 0, 500.0, said.append)
    server.said = said
    thread = threading.Thread(target=server.run)
    thread.start()
    yield server
    server.stop()
    thread.join()


def session(rig):
    return Session(rig.scene, rig=rig)


def at(server):
    return ("127.0.0.1", server.port)


def test_the_hand_feels_what_the_follower_has_learnt_through_a_relay(rig, follower, tmp_path):
    link = network("none")
    link.to_site.delay = link.to_operator.delay = 0.05
    relay = Relay(0, at(follower), link)
    thread = threading.Thread(target=relay.run)
    thread.start()
    try:
        mine = Session(rig.scene, rig=rig, out=tmp_path)
        with links.RemoteLink(mine, ("127.0.0.1", relay.port), KEY, 500.0) as remote:
            summary = mine.run(6.0, realtime=True)
        found = remote.figures()
    finally:
        relay.stop()
        thread.join()
    (model,) = found["models"]
    assert model["stiffness_N_per_m"] == pytest.approx(450.0, rel=0.1)
    assert model["shift_m"][2] == pytest.approx(-0.0015, abs=3e-4)
    assert 1e-3 * found["round_trip_ms"] > 0.09  # a busy machine adds to it
    assert found["received"] > 1000
    assert found["refused"] == 0
    assert summary.peak_force_N < 3.0
    assert follower.largest < 3.0
    judge_the_record(summary.record, found)
    for _ in range(50):
        time.sleep(0.02 * ("has left" not in " ".join(follower.said)))
    assert "the operator has left" in " ".join(follower.said)


def judge_the_record(path, found):
    """Link, delays and energy of the updates are recorded; the report shows them and the remote force."""
    record = Record.open(path)
    link, age, delay = (record[name] for name in ("remote_link", "remote_age", "remote_delay"))
    assert set(np.unique(link)) <= {1.0, 2.0}
    assert (link == 2.0).mean() > 0.5
    assert np.median(age[link == 2.0]) > 0.045  # of the relay; a busy machine adds to both
    assert np.median(delay[link == 2.0]) > 0.045
    mapping = scene().mapping  # the ledger is at the hand's port
    at_hand = mapping.force_scale / mapping.scale
    assert record["energy_model"][-1] == pytest.approx(1e-3 * found["paid_mJ"] * at_hand, abs=1e-6)
    assert record["energy_tank"][link == 2.0].min() >= 0.0
    run = Run(record)
    assert remote_report.model_error(run) < 0.5
    page = write_report(path).read_text()
    assert "Across the network" in page


@pytest.mark.parametrize("mode", ["passivity", "direct"])
def test_the_measured_force_is_felt_where_there_is_no_model(mode):
    """The hand feels what the site measures; its record has no contact of its own, and both ports keep their energy."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        mine = build(scene(mode=mode))
    server = sites.FollowerServer(mine, KEY, "127.0.0.1", 0, 1000.0, lambda line: None)
    thread = threading.Thread(target=server.run)
    thread.start()
    try:
        one = session(mine)
        with links.RemoteLink(one, at(server), KEY) as remote:
            summary = one.run(4.0, realtime=True)
    finally:
        server.stop()
        thread.join()
    assert remote.figures()["mode"] == mode
    assert remote.figures()["round_trip_ms"] > 0.0  # no packet arrives before it has left
    for each in listen("127.0.0.1", server.port):  # nothing holds the port
        each.close()
    assert 0.2 < server.largest < 3.0
    assert 0.05 < summary.peak_force_N < 3.0
    assert summary.max_penetration_m == 0.0


def test_a_second_master_another_scene_version_key_or_clock_is_refused(rig, follower, monkeypatch):
    first = links.RemoteLink(session(rig), at(follower), KEY)
    with pytest.raises(PalpateError, match=r"another operator drives this follower: 127.0.0.1:\d+"):
        links.RemoteLink(session(rig), at(follower), KEY)
    first.close()
    time.sleep(0.2)
    later = SimpleNamespace(time=lambda: time.time() + 3 * 3600, monotonic=time.monotonic, sleep=time.sleep)
    for name, value, words in (
        ("digest", lambda scene: "0" * 16, r"(?s)another scene .*same scene file"),
        ("__version__", "0.0.1", r"(?s)the follower has Palpate .*same version"),
        ("time", later, r"(?s)clocks of both machines differ by -?3\.0 h.*NTP"),
    ):
        monkeypatch.setattr(links, name, value)
        with pytest.raises(PalpateError, match=words):
            links.RemoteLink(session(rig), at(follower), KEY)
        monkeypatch.undo()
    with pytest.raises(PalpateError, match=r"(?s)ended the connection.*same key file"):
        links.RemoteLink(session(rig), at(follower), bytes(32))
    links.RemoteLink(session(rig), at(follower), KEY).close()  # the right one still may


def test_packets_of_another_version_are_refused_by_name(rig, follower):
    hello = {"version": __version__, "scene": sites.digest({"": rig.scene}), "time": time.time()}
    assert follower._fault(hello) == "the follower has packets of version 2, this end of version 1"
    assert follower._fault(hello | {"packets": "x"}).endswith("this end of version x")


@pytest.mark.parametrize(
    "stamp", ["noon", None, [1.0], 10**400, float("nan"), float("inf")], ids=lambda one: str(one)[:8]
)
def test_a_time_that_is_no_time_is_refused_with_words(rig, follower, stamp):
    hello = {"version": __version__, "packets": _network.PACKET_VERSION, "scene": sites.digest({"": rig.scene})}
    assert follower._fault(hello | {"time": time.time()}) is None
    assert re.search("states its time as|clocks of both machines differ", follower._fault(hello | {"time": stamp}))


@pytest.mark.parametrize(
    ("more", "given"), [(["--network"], "--network"), (["--force-axes", "tip"], "--force-axes tip")]
)
def test_options_of_an_arm_are_refused_without_one(tmp_path, capsys, more, given):
    make_key(tmp_path / "key")
    assert main(["serve", "follower", "remote", "--port", "0", "--key", str(tmp_path / "key"), *more]) == 2
    assert f"{given}: a simulated instrument does not use ROS 2" in capsys.readouterr().err


def test_ends_with_different_modes_have_different_scenes():
    here = sites.digest({"": scene()})
    assert sites.digest({"": scene(mode="direct")}) != here
    assert sites.digest({"one": scene(), "other": scene()}) != here
    assert sites.digest({"": scene(network="fibre", site_shift=(0.0, 0.0, 0.001))}) == here  # of relay and site


def test_nobody_there_and_a_small_mtu_are_told(rig, follower, monkeypatch):
    free = socket.socket()
    free.bind(("127.0.0.1", 0))
    with pytest.raises(PalpateError, match=r"(?s)no follower answers at 127.0.0.1.*palpate serve follower"):
        links.RemoteLink(session(rig), ("127.0.0.1", free.getsockname()[1]), KEY)
    free.close()
    monkeypatch.setattr(channels, "DATAGRAM", 100_000)
    with pytest.raises(PalpateError, match=r"passes packets of 6553[56] bytes"):
        links.RemoteLink(session(rig), at(follower), KEY)


def test_strangers_move_nothing(rig, follower):
    """A flood of packets and connections of strangers: all refused, and the tool rests."""
    before = follower.followers[0].state().x.copy()
    udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    for k in range(3000):
        udp.sendto(bytes([k % 256]) * (k % 300), at(follower))
    for text in (b"", b"GET / HTTP/1.1\r\n\r\n" + b"x" * 100, b"\0" * 200):
        with socket.create_connection(at(follower), 2.0) as tcp:
            tcp.sendall(text)
    time.sleep(0.3)
    assert follower.strangers > 100  # more did not fit into the buffer of the system
    assert abs(follower.followers[0].state().x - before).max() < 1e-5
    links.RemoteLink(session(rig), at(follower), KEY).close()


@pytest.mark.parametrize(
    ("remote", "fast", "words"),
    [
        ({"network": "wifi"}, False, "no network condition is named 'wifi'"),
        ({}, True, "--fast has no effect across a network"),
    ],
)
def test_what_cannot_run_across_a_network_is_told(remote, fast, words):
    with pytest.raises((PalpateError, SceneError), match=words):
        require(scene(**remote), None, fast)


def test_ctrl_c_ends_the_follower_with_its_figures(tmp_path, capsys, monkeypatch):
    make_key(tmp_path / "key")
    run = sites.FollowerServer.run

    def interrupted(server):
        threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
        run(server)

    monkeypatch.setattr(sites.FollowerServer, "run", interrupted)
    assert main(["serve", "follower", "remote", "--port", "0", "--key", str(tmp_path / "key")]) == 0
    ticks, _, _, _, _, cpu = _END.search(capsys.readouterr().out).groups()
    assert int(ticks) > 20
    assert float(cpu) > 0.0


def test_a_trace_of_a_scene_lies_beside_the_scene(tmp_path):
    (tmp_path / "scene.yaml").write_text(scene(network="mine.csv").to_yaml())
    assert network_name(Scene.load(tmp_path / "scene.yaml")) == str(tmp_path / "mine.csv")
    assert network_name(scene(network="fibre")) == "fibre"
    assert network_name(scene().model_copy(update={"remote": None})) == "none"
