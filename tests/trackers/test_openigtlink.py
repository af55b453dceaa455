"""OpenIGTLink on the loopback interface: poses arrive in metres with stamp, residual and validity."""

import sys
import time

import numpy as np
import pytest

from palpate.errors import MissingExtraError, PortError
from palpate.trackers import Gate, Sighting, SimulatedTracker

pytest.importorskip("pyigtl", reason="OpenIGTLink needs the extra tracking")
from palpate.trackers.openigtlink import OpenIGTLinkServer, OpenIGTLinkTracker


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


def received(tracker: OpenIGTLinkTracker, n: int = 1) -> dict[str, Sighting]:
    found: dict[str, Sighting] = {}

    def complete():
        found.update({seen.tool: seen for seen in tracker.poll(0.0)})
        return len(found) >= n

    wait_for(complete)
    return found


def test_poses_arrive_as_they_were_sent(link):
    server, tracker = link
    simulated = SimulatedTracker({"a": lambda t: pose(0.1), "b": lambda t: pose(0.3)})
    sent = {seen.tool: seen for seen in simulated.frame(60)}
    for seen in sent.values():
        server.send(Sighting(seen.tool, seen.X, 1795341600.25, seen.error))
    for name, seen in received(tracker, 2).items():
        assert pytest.approx(sent[name].X, abs=2e-7) == seen.X  # single precision of 1500 mm
        assert seen.t == pytest.approx(1795341600.25, abs=1e-6)
        assert seen.error == pytest.approx(sent[name].error, rel=1e-5)
        assert seen.valid


def test_a_pose_that_plus_marks_as_invalid_is_refused(link):
    server, tracker = link
    server.send(Sighting("StylusToTracker", pose(0.1), 100.0, valid=False))
    (seen,) = received(tracker).values()
    assert not seen.valid
    assert not Gate("StylusToTracker", pose(0.1)).take(seen, 0.0)


def test_a_server_that_stops_is_silence_and_is_found_again():
    with OpenIGTLinkServer(0) as server:
        tracker = OpenIGTLinkTracker(f"127.0.0.1:{server.port}")
        wait_for(lambda: server.is_connected)
        server.send_pose("a", pose(0.1), 1.0)
        received(tracker)
        port = server.port
    assert tracker.poll(0.0) == []
    with OpenIGTLinkServer(port) as server:
        wait_for(lambda: (tracker.poll(0.0), server.is_connected)[1])
        server.send_pose("a", pose(0.2), 2.0)
        assert received(tracker)["a"].X[0, 3] == pytest.approx(0.2)
    tracker.close()


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
