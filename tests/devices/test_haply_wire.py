"""The wire between the driver of Haply devices and a service: addresses, the handshake, frames, and states."""

import json
import socket
import threading
import time

import numpy as np
import pytest

pytest.importorskip("websockets", reason="the stand-in needs the extra haply")

from palpate.base.errors import DeviceError
from palpate.devices.haply.driver import Haply
from palpate.devices.haply.messages import Config
from palpate.devices.haply.service import Address
from palpate.devices.haply.stand_in import StandIn


@pytest.mark.parametrize(("url", "address"), [("ws://a:5", "a:5"), ("b", "b:10001"), ("[::1]:7", "[::1]:7")])
def test_addresses(url, address):
    assert str(Address.parse(url)) == address


@pytest.mark.parametrize("url", ["http://a:5", "ws://a:b", "ws://", "ws://a/b"])
def test_addresses_that_are_none_are_refused(url):
    with pytest.raises(DeviceError, match="no address") as error:
        Address.parse(url)
    assert str(error.value).count("mend:") == 1
    assert error.value.why


def test_an_address_where_no_service_answers_is_told_with_its_cause():
    for url, cause in (("ws://127.0.0.1:9", "refused"), ("ws://haply.invalid", "known|resol")):
        with pytest.raises(DeviceError, match=cause) as error:
            Haply(f"url={url}").native()
        assert "urlopen" not in str(error.value)
        assert error.value.mend.startswith("check the address in url")


class Scripted:
    """A server that shakes hands with one client and then sends bytes as they are."""

    def __init__(self, *data: bytes):
        self._wire = socket.create_server(("127.0.0.1", 0))
        self.port, self.got = self._wire.getsockname()[1], b""
        self._thread = threading.Thread(target=self._serve, args=(data,), daemon=True)
        self._thread.start()

    def _serve(self, data):
        import base64
        import hashlib

        peer, _ = self._wire.accept()
        with peer:
            head = peer.recv(4096)
            key = next(line.split(b": ")[1] for line in head.split(b"\r\n") if line.startswith(b"Sec-WebSocket-Key"))
            accept = base64.b64encode(hashlib.sha1(key + b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11").digest())
            peer.sendall(b"HTTP/1.1 101 Switching Protocols\r\nSec-WebSocket-Accept: " + accept + b"\r\n\r\n")
            for part in data:
                peer.sendall(part)
                time.sleep(0.02)
            peer.settimeout(1.0)
            try:
                while part := peer.recv(4096):
                    self.got += part
            except TimeoutError:
                pass
        self._wire.close()

    def connection(self):
        from palpate.devices.haply import service

        return service.websocket(Address("127.0.0.1", self.port))


def frame(payload=b"", opcode=1, fin=True, mask=False, length=None):
    n = len(payload) if length is None else length
    head = bytes([(0x80 if fin else 0) | opcode])
    size = bytes([n]) if n < 126 else b"\x7e" + n.to_bytes(2, "big") if n < 65536 else b"\x7f" + n.to_bytes(8, "big")
    return head + bytes([size[0] | (0x80 if mask else 0)]) + size[1:] + payload


@pytest.mark.parametrize(
    ("parts", "message"),
    [((frame(b"one"),), "one"), ((frame(b"on", fin=False), frame(b"e", opcode=0)), "one"),
     ((frame(b"on", fin=False) + frame(b"hi", opcode=9) + frame(b"e", opcode=0),), "one"),
     ((frame(b"x" * 200)[:50], frame(b"x" * 200)[50:]), "x" * 200), ((frame(b"y" * 60_000),), "y" * 60_000),
     ((frame(b"z" * 65_536),), "z" * 65_536), ((frame(b"", opcode=10) + frame(b""),), "")],
    ids=["whole", "parts", "ping between", "slowly", "60 kB", "64 kB", "pong, empty"],
)  # fmt: skip
def test_frames_of_rfc_6455_become_messages(parts, message):
    server = Scripted(*parts)
    assert server.connection().receive(2.0) == message


@pytest.mark.parametrize(
    ("data", "words"),
    [(frame(b"a", mask=True), "no WebSocket"), (b"\xc1\x01a", "no WebSocket"), (frame(b"a", opcode=3), "no WebSocket"),
     (frame(b"a", opcode=0), "no WebSocket"), (frame(length=65_537), "no WebSocket"),
     (frame(length=2**63), "no WebSocket"), (frame(b"a", opcode=9, fin=False), "no WebSocket"),
     (frame(b"x" * 126, opcode=9), "no WebSocket"), (frame(b"a", fin=False) * 2, "no WebSocket"),
     (frame(b"\x03\xe8", opcode=8), "closed"), (b"\x81", "no message within")],
)  # fmt: skip
def test_what_is_no_frame_ends_the_connection_by_name(data, words):
    with pytest.raises(RuntimeError, match=words):
        Scripted(data).connection().receive(0.3)


def test_a_ping_is_answered_and_frames_of_the_client_are_masked():
    server = Scripted(frame(b"beat", opcode=9), frame(b"one"))
    connection = server.connection()
    connection.receive(2.0)
    connection.send("hello")
    del connection
    server._thread.join(3.0)
    got, found = server.got, []
    while got:
        opcode, n, mask = got[0] & 15, got[1] & 127, got[2:6]
        assert got[1] & 128, "a client masks"
        found.append((opcode, bytes(b ^ mask[i % 4] for i, b in enumerate(got[6 : 6 + n]))))
        got = got[6 + n :]
    assert found == [(10, b"beat"), (1, b"hello"), (8, b"\x03\xe8")]


def test_a_handshake_that_is_refused_is_told():
    with StandIn(0) as service:
        wire = socket.create_server(("127.0.0.1", 0))

        def refuse():
            peer, _ = wire.accept()
            peer.recv(4096)
            peer.sendall(b"HTTP/1.1 403 Forbidden\r\n\r\n")
            peer.close()

        threading.Thread(target=refuse, daemon=True).start()
        from palpate.devices.haply.service import websocket

        with pytest.raises(DeviceError, match=r"(?s)is no WebSocket.*403"):
            websocket(Address("127.0.0.1", wire.getsockname()[1]))
        assert service.exchanges == 0


def test_state_of_service_is_read_where_keys_come_in_any_order():
    """The id after the state, other devices before, unknown keys, integers for numbers."""
    from palpate import _haply

    state = {"cursor_velocity": {"z": 0, "y": 0, "x": 0}, "cursor_position": {"z": 3, "x": 1, "y": 2}, "news": [{}]}
    other = {"state": {"cursor_position": {"x": 9, "y": 9, "z": 9}}, "device_id": "04BA", "config": Config().gravity}
    ours = {"status": {"ready": True, "calibrated": True}, "state": state, "device_id": "04C3"}
    text = json.dumps({"x": 1, "inverse3": [other, "no entry", ours]})
    server = Scripted(frame(text.encode()))
    device = _haply.Device(
        server.connection(), None, device="04C3", address='"04C3"', grip="", list="", vector=True, rate=500.0,
        force_max=3.0, workspace=0.1,
    )  # fmt: skip
    X = np.eye(4)
    while device.read(X) is None:
        pass
    assert X[:3, 3].tolist() == [1.0, 2.0, 3.0]
