"""What PLUS, 3D Slicer and bridges of NDI trackers send: kinds, names, stamps, checksums. Bytes written here by hand
from the protocol's tables, and by pyigtl."""

import math
import socket
import struct
import time

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from palpate.base.errors import PalpateError
from palpate.sensing.trackers import Gate, wire
from palpate.sensing.trackers.openigtlink import OpenIGTLinkTracker, PoseReader
from palpate.sensing.trackers.tracking import Tracking

pyigtl = pytest.importorskip("pyigtl", reason="OpenIGTLink needs the extra tracking")

CRC = pyigtl.messages.CRC64
X = np.eye(4)
X[:3, :3] = Rotation.from_euler("xyz", [20, -40, 70], degrees=True).as_matrix()
X[:3, 3] = [120.0, -80.0, 1400.0]
Q = Rotation.from_matrix(X[:3, :3]).as_quat()  # x y z w
NUMBERS = X[:3, :].T.ravel()


def message(kind, name, body, stamp=100.25, version=1, crc=None, metadata=None):
    if version > 1:
        pairs = [(k.encode(), v.encode()) for k, v in (metadata or {}).items()]
        index = struct.pack(">H", len(pairs)) + b"".join(struct.pack(">HHI", len(k), 3, len(v)) for k, v in pairs)
        data = b"".join(k + v for k, v in pairs)
        body = struct.pack(">HHII", 12, len(index), len(data), 7) + body + index + data
    crc = CRC(body) if crc is None else crc
    head = struct.pack(">H12s20s", version, kind.encode(), name.encode())
    return head + struct.pack(">IIQQ", int(stamp), int((stamp % 1) * 2**32), len(body), crc) + body


def transform(name="Tool", pose=X, **more):
    return message("TRANSFORM", name, struct.pack(">12f", *pose[:3, :].T.ravel()), **more)


def element(name, *numbers):
    return struct.pack(f">20sBB{len(numbers)}f", name.encode(), 2, 0, *numbers)


KINDS = {
    "TRANSFORM": transform("Tool"),
    "TDATA": message("TDATA", "Polaris", element("Other", *NUMBERS) + element("Tool", *NUMBERS)),
    "QTDATA": message("QTDATA", "Polaris", element("Other", 0, 0, 9, *Q) + element("Tool", *X[:3, 3], *Q)),
    "POSITION": message("POSITION", "Tool", struct.pack(">7f", *X[:3, 3], *Q)),
    "POSITION, compressed": message("POSITION", "Tool", struct.pack(">6f", *X[:3, 3], *(Q[:3] * np.sign(Q[3])))),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("step", [1, 7, 100_000])
def test_every_message_of_a_pose_is_read(kind, step):
    """In pieces of any size."""
    reader, data = PoseReader(crc=CRC), KINDS[kind]
    for at in range(0, len(data), step):
        reader.feed(data[at : at + step], 5.0)
    seen = {one.tool: one for one in reader.take()}["Tool"]
    assert pytest.approx(np.r_[X[:3, :3].ravel(), 1e-3 * X[:3, 3]], abs=1e-6) == [
        *seen.X[:3, :3].ravel(),
        *seen.X[:3, 3],
    ]
    assert seen.t == pytest.approx(100.25)
    assert seen.valid
    assert Gate("Tool", seen.X).take(seen, 0.0)


def test_a_position_without_orientation_or_in_another_layout_is_named():
    """pyigtl packs POSITION as a list of points, which the protocol's table does not know."""
    other = pyigtl.PositionMessage(np.array([X[:3, 3]]), np.array([Q]), device_name="Tool", timestamp=3.0).pack()
    reader = PoseReader(crc=CRC)
    reader.feed(message("POSITION", "Tool", struct.pack(">3f", 1, 2, 3)), 5.0)
    assert reader.heard("Tool") == "1 messages are damaged: a POSITION of Tool with 12 bytes: it has no orientation"
    reader.feed(other, 5.0)
    assert reader.heard("Tool").endswith("a POSITION of Tool with 152 bytes: a POSITION of 24 or 28 bytes is read")
    assert reader.take() == []


@pytest.mark.parametrize("size", [(640, 480), (1920, 1080), (3840, 2160)])
def test_pictures_before_poses_are_skipped_without_being_kept(size):
    image = pyigtl.ImageMessage(np.zeros((1, *size[::-1]), np.uint8), device_name="Image", timestamp=1.0).pack()
    reader, seen = PoseReader(crc=CRC), 0
    for k in range(5):
        data = image + transform(stamp=10.0 + k)
        for at in range(0, len(data), 65536):
            reader.feed(data[at : at + 65536], float(k))
            assert len(reader._decoder._buffer) < 70_000
        seen += len(reader.take())
    assert seen == 5
    assert reader.heard("Missing") == "Tool arrives; IMAGE of Image arrives, which is no pose"


def test_metadata_of_version_2_and_3_are_read():
    reader = PoseReader(crc=CRC)
    for version, status, valid in ((2, "OK", True), (3, "INVALID", False), (2, "OUT_OF_VIEW", False)):
        more = {"ToolStatus": status, "ErrorMm": "0.5"}
        reader.feed(transform(version=version, metadata=more, stamp=float(version)), 1.0)
        (seen,) = reader.take()
        assert seen.valid is valid
        assert seen.error == pytest.approx(5e-4)


@pytest.mark.parametrize("stamps", ["zero", "equal", "whole seconds"])
def test_a_sender_without_a_clock_is_followed_by_the_time_of_arrival(stamps):
    """Thirty poses a second of a moving tool: every one is taken, none is 'lost'."""
    reader, gate = PoseReader(crc=CRC), Gate("Tool", np.eye(4))
    taken = 0
    for k in range(90):
        now, pose = 1000.0 + k / 30.0, X.copy()
        pose[0, 3] += 3.0 * math.sin(k / 30.0)
        stamp = {"zero": 0.0, "equal": 77.0, "whole seconds": float(int(now))}[stamps]
        reader.feed(transform(pose=pose, stamp=stamp), now)
        taken += sum(gate.take(seen, k / 30.0) for seen in reader.take())
    assert taken >= 89
    assert gate.status(89 / 30.0) == "tracked"
    assert "times of arrival are used" in reader.heard("Tool")


def test_a_server_that_repeats_one_pose_is_no_tracked_tool():
    """The same pose with the same stamp, as of a program that hangs, ages."""
    reader, gate = PoseReader(crc=CRC), Gate("Tool", np.eye(4))
    for k in range(60):
        reader.feed(transform(stamp=50.0), 1000.0 + k / 30.0)
        for seen in reader.take():
            gate.take(seen, k / 30.0)
    assert gate.is_lost(2.0)
    assert reader.heard("Tool") == "the same pose with the same stamp is sent again and again"


def test_a_clock_that_is_found_missing_late_makes_no_jump_of_time():
    """Stamps of a clock since start-up, and then equal ones: the times go on."""
    reader, gate, times = PoseReader(crc=CRC), Gate("Tool", np.eye(4)), []
    for k in range(20):
        pose = X.copy()
        pose[1, 3] += 0.1 * k
        reader.feed(transform(pose=pose, stamp=min(4.0 + 0.02 * k, 4.2)), 1000.0 + 0.02 * k)
        for seen in reader.take():
            assert gate.take(seen, 0.02 * k)
            times.append(seen.t)
    assert np.diff(times) == pytest.approx(0.02, abs=1e-6)


def test_the_identity_is_a_marker_that_is_not_seen():
    reader, gate = PoseReader(crc=CRC), Gate("Tool", np.eye(4))
    for k in range(10):
        reader.feed(transform(pose=np.eye(4), stamp=1.0 + k), 1.0)
        assert not any(gate.take(seen, 0.1 * k) for seen in reader.take())
    assert gate.status(1.0) == "not seen yet: its pose is the identity, which is sent for a marker that is not seen"


def test_a_wrong_checksum_is_dropped_and_told_but_none_at_all_is_accepted():
    reader = PoseReader(crc=CRC)
    reader.feed(transform(crc=12345) + transform(crc=0, stamp=2.0), 1.0)
    assert [seen.t for seen in reader.take()] == [2.0]
    reader = PoseReader(crc=CRC)
    reader.feed(transform(crc=12345) * 3, 1.0)
    assert reader.take() == []
    assert reader.heard("Tool") == "3 messages are damaged: the checksum of a TRANSFORM of Tool is wrong"


def test_names_of_tools_longer_than_the_wire_allows():
    reader = PoseReader(["PatientReferenceToTracker", "Stylus"], CRC)
    reader.feed(transform("PatientReferenceToTracker"[:20]) + transform("Stylus"), 1.0)
    assert {seen.tool for seen in reader.take()} == {"PatientReferenceToTracker", "Stylus"}
    with pytest.raises(PalpateError, match="have the same first 20 characters"):
        PoseReader(["PatientReferenceToTracker", "PatientReferenceToTrunk"], CRC)


def test_what_arrives_instead_is_named():
    reader = PoseReader(["Tool"], CRC)
    assert reader.heard("Tool") == ""
    reader.feed(
        transform("MarkerToTracker") + message("STRING", "Note", b"\0\3\0\1a") + message("STATUS", "s", bytes(30)), 1.0
    )
    assert reader.heard("Tool") == "MarkerToTracker arrives; STRING of Note arrives, which is no pose"


@pytest.mark.parametrize(
    "data", [bytes(58), b"GET / HTTP/1.1\r\n" * 8, struct.pack(">H12s20sIIQQ", 1, b"IMAGE", b"", 0, 0, 2**60, 0)]
)
def test_bytes_that_are_no_openigtlink_are_refused(data):
    with pytest.raises(ValueError, match=r"header of version|is announced"):
        PoseReader().feed(data, 0.0)


def test_the_first_message_asks_for_version_2():
    """pyigtl's own parser reads it: a server of PLUS answers each client in the version of its first message."""
    data = wire.first_message()
    fields = pyigtl.messages.MessageBase.parse_header(data[:58])
    assert fields["header_version"] == 2
    assert fields["message_type"] == "GET_STATUS"
    assert fields["body_size"] == len(data) - 58
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(10.0)
        tracker = OpenIGTLinkTracker(f"127.0.0.1:{server.getsockname()[1]}")
        with server.accept()[0] as peer:
            peer.settimeout(10.0)
            assert peer.recv(4096) == data
        tracker.close()


def test_the_state_of_the_connection_is_told():
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    tracker = OpenIGTLinkTracker(f"127.0.0.1:{port}")

    def told(words):
        end = time.monotonic() + 10.0
        while words not in tracker.heard("Tool"):
            assert time.monotonic() < end, tracker.heard("Tool")
            time.sleep(0.01)

    told(f"no connection to 127.0.0.1:{port} (Connection refused)")
    with socket.create_server(("127.0.0.1", port)) as server:
        server.settimeout(10.0)
        with server.accept()[0] as peer:
            told("no message arrives")
            peer.sendall(transform("Stylus"))
            told("Stylus arrives")
    tracker.close()


def test_a_session_tells_what_arrives(tmp_path):
    from palpate import Scene, Session

    scene = Scene.parse(
        "frames: [{child: t, tracker: plus, tool: ReferenceOfThePatientToTracker, pose: {xyz: [0.1, 0, 1]}}]\n"
        "trackers: {plus: {openigtlink: 127.0.0.1:1}}\nobjects: [{name: ball, sphere: {radius: 0.03}, frame: t}]\n"
    )
    session = Session(scene)

    class Silent:
        def poll(self, now):
            return []

        def heard(self, tool):
            assert tool == "ReferenceOfThePatientToTracker"
            return "MarkerToTracker arrives"

        def close(self):
            pass

    tracking = Tracking(
        session.rig, session._loop if hasattr(session, "_loop") else session.simulation, {"plus": Silent()}
    )
    assert tracking.status(1.0) == {"t": "not seen yet: MarkerToTracker arrives"}
