"""OpenIGTLink on the loopback interface: poses arrive in metres with stamp, residual and validity."""

import sys
import time

import numpy as np
import pytest

from palpate import Session
from palpate.base.errors import MissingExtraError, PalpateError, PortError
from palpate.scene import Scene
from palpate.sensing.trackers import Gate, Sighting, SimulatedTracker

pytest.importorskip("pyigtl", reason="OpenIGTLink needs the extra tracking")
from palpate.sensing.trackers.openigtlink import OpenIGTLinkServer, OpenIGTLinkTracker
from palpate.sensing.trackers.sending import FrameSender
from palpate.session import PairsSession


def wait_for(condition, seconds=10.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "nothing has arrived"
        time.sleep(0.005)


@pytest.fixture
def link():
    with OpenIGTLinkServer(0) as server:
        tracker = OpenIGTLinkTracker(f"127.0.0.1:{server.port}")
        wait_for(lambda: server.is_connected)
        yield server, tracker
        tracker.close()


def received(link, *sent: Sighting) -> dict[str, Sighting]:
    """What the tracker receives of a stream: pyigtl may lose the first messages of a connection on a busy machine."""
    (server, tracker), found = link, {}

    def complete():
        for seen in sent:
            server.send(seen)
        found.update({seen.tool: seen for seen in tracker.poll(0.0)})
        return set(found) == {seen.tool for seen in sent}

    wait_for(complete)
    return found


def test_poses_arrive_as_they_were_sent(link):
    simulated = SimulatedTracker({"a": lambda t: pose(0.1), "b": lambda t: pose(0.3)})
    sent = {seen.tool: seen for seen in simulated.frame(60)}
    stamped = [Sighting(seen.tool, seen.X, 1795341600.25, seen.error) for seen in sent.values()]
    for name, seen in received(link, *stamped).items():
        assert pytest.approx(sent[name].X, abs=2e-7) == seen.X  # single precision of 1500 mm
        assert seen.t == pytest.approx(1795341600.25, abs=1e-6)
        assert seen.error == pytest.approx(sent[name].error, rel=1e-5)
        assert seen.valid


def test_a_pose_that_plus_marks_as_invalid_is_refused(link):
    (seen,) = received(link, Sighting("StylusToTracker", pose(0.1), 100.0, valid=False)).values()
    assert not seen.valid
    assert not Gate("StylusToTracker", pose(0.1)).take(seen, 0.0)


def test_a_server_that_stops_is_silence_and_is_found_again():
    with OpenIGTLinkServer(0) as server:
        tracker = OpenIGTLinkTracker(f"127.0.0.1:{server.port}")
        received((server, tracker), Sighting("a", pose(0.1), 1.0))
        port = server.port
    tracker.poll(0.0)
    assert tracker.poll(0.0) == []
    with OpenIGTLinkServer(port) as server:
        link, new = (server, tracker), Sighting("a", pose(0.2), 2.0)  # copies of the old pose may still be under way
        wait_for(lambda: received(link, new)["a"].X[0, 3] == pytest.approx(0.2))
    tracker.close()


def test_a_session_sends_its_frames_and_its_force():
    pyigtl = pytest.importorskip("pyigtl")
    scene = Scene.parse(
        "frames: [{child: table, pose: {xyz: [0.1, 0.2, 0.3]}}]\n"
        "objects: [{name: ball, sphere: {radius: 0.03}, frame: table}]\n"
    )
    session, found = Session(scene), {}
    session.step(1)
    with FrameSender(session, 0) as sender:
        client = pyigtl.OpenIGTLinkClient("127.0.0.1", sender.port)
        names = {"table", "ball", "leader", "follower", "tool", "force"}

        def complete():
            found.update({message.device_name: message for message in client.get_latest_messages()})
            return set(found) >= names

        wait_for(complete)
        client.communication_thread_stop_requested = True
    assert found["ball"].matrix[:3, 3] == pytest.approx([100.0, 200.0, 300.0])
    assert found["tool"].matrix[:3, 3] == pytest.approx(1e3 * session.latest()["p_WT"], abs=1e-3)
    assert [float(x) for x in found["force"].string.split()] == [0.0, 0.0, 0.0]


def test_several_pairs_send_their_tools_under_their_names():
    pyigtl = pytest.importorskip("pyigtl")
    session, found = PairsSession(Scene.load("two_hands")), {}
    session.step(1)
    each = ("leader", "follower", "tool", "force")
    names = {"liver", *(f"{pair} {name}" for pair in ("right", "left") for name in each)}
    with FrameSender(session.pairs, 0) as sender:
        client = pyigtl.OpenIGTLinkClient("127.0.0.1", sender.port)

        def complete():
            found.update({message.device_name: message for message in client.get_latest_messages()})
            return set(found) >= names

        wait_for(complete)
        client.communication_thread_stop_requested = True
    assert set(found) == names
    for pair, one in session.pairs.items():
        assert found[f"{pair} tool"].matrix[:3, 3] == pytest.approx(1e3 * one.latest()["p_WT"], abs=1e-3)
        assert found[f"{pair} leader"].matrix[:3, 3] == pytest.approx(1e3 * one.rig.arms.X_WL[:3, 3], abs=1e-3)


def test_felt_points_lie_on_the_organ_in_ras_and_reach_a_client_that_comes_late():
    pyigtl = pytest.importorskip("pyigtl")
    scene = Scene.parse(
        "objects: [{name: ball, sphere: {radius: 0.03}, pose: {xyz: [0.01, 0.02, 0.03], rpy_deg: [0, 0, 90]}}]\n"
        "operator: {palpate: {approach: 0.2, press: 0.2, slide: 0.5, leave: 0.2}}\n"
    )
    session, found = Session(scene), {}
    with FrameSender(session, 0) as sender:
        touched = []
        for _ in range(12):
            session.step(100)
            time.sleep(0.05)  # the sender looks thirty times a second
            tick = session.latest()
            touched += [np.array(tick["p_WC"][:3])] if tick["contacts"] else []
        client = pyigtl.OpenIGTLinkClient("127.0.0.1", sender.port)

        def complete():
            found.update({message.device_name: message for message in client.get_latest_messages()})
            return "felt ball" in found

        wait_for(complete)
        client.communication_thread_stop_requested = True
    points = np.reshape(found["felt ball"].positions, (-1, 3)) * 1e-3
    assert len(points) > 3
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 0.03, atol=2e-5)
    apart = np.linalg.norm(points[:, None] - points, axis=2) + np.eye(len(points))
    assert apart.min() > 0.99e-3
    p_WC = [0.01, 0.02, 0.03] + points @ np.diag([-1.0, -1.0, 1.0]) @ [
        [0, 1, 0],
        [-1, 0, 0],
        [0, 0, 1],
    ]  # RAS to O to W
    away = np.linalg.norm(np.array(touched)[:, None] - p_WC, axis=2).min(axis=1)
    assert away.max() < 1.1e-3  # each place that was touched has a point


def test_a_name_that_openigtlink_would_cut_is_refused(link):
    with pytest.raises(PalpateError, match="shorter name"):
        link[0].send_pose("a" * 21, pose(0.1), 1.0)


def test_a_port_in_use_is_refused():
    with OpenIGTLinkServer(0) as server, pytest.raises(PortError, match="cannot be used"):
        OpenIGTLinkServer(server.port)


def test_a_missing_package_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyigtl", None)
    with pytest.raises(MissingExtraError, match="OpenIGTLink is not installed") as error:
        OpenIGTLinkTracker("127.0.0.1:18944")
    assert error.value.extra == "tracking"


def pose(x: float) -> np.ndarray:
    X = np.eye(4)
    X[:3, 3] = [x, -0.2, 1.5]
    return X
