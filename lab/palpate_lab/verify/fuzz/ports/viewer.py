"""The viewer: forged requests to its gate, and damaged messages to the server behind it.

A request from another page or by another name is refused, a sound one is served. Whatever a page sends, the controls
keep values in their range, and nothing is kept for the sender.
"""

from __future__ import annotations

import asyncio
import socket
from functools import cache
from http import HTTPStatus
from typing import Any

import msgspec
import numpy as np
import viser
from viser import _messages
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from palpate.viewer.gate import Gate
from palpate.viewer.server import open_server
from palpate_lab.verify.fuzz import FaultError
from palpate_lab.verify.fuzz.damage import damaged
from palpate_lab.verify.fuzz.ports import values

_OWN = ("127.0.0.1:8080", "localhost:8080", "[::1]:8080", "localhost", "127.0.0.1:9")
_OTHER = (
    *("evil.example", "127.0.0.1.evil.example:8080", "0.0.0.0:8080", "192.168.0.4:8080", "localhost.evil.example", ""),
    *("evil@127.0.0.1", "127.0.0.1:8080/", "127.1", "[::2]:8080", "2130706433:8080", "localhost:8080#", "127.0.0.1:x"),
)
_MOST_KEPT = 400  # messages that the server keeps for browsers to come: those of its own page
_KINDS = tuple(
    name
    for name, kind in vars(_messages).items()
    if isinstance(kind, type) and issubclass(kind, _messages.Message) and kind is not _messages.Message
)


class _Connection:
    @staticmethod
    def respond(status: HTTPStatus, text: str) -> Response:
        return Response(int(status), status.phrase, Headers(), text.encode())


@cache
def _server() -> tuple[viser.ViserServer, list[Any], asyncio.AbstractEventLoop]:
    server = open_server("127.0.0.1", 0, "fuzz")
    controls = [
        server.gui.add_slider("stiffness", 0.0, 900.0, 10.0, 300.0),
        server.gui.add_dropdown("quality", ("automatic", "full", "light"), initial_value="full"),
        server.gui.add_checkbox("clutch", False),
    ]
    return server, controls, asyncio.new_event_loop()


def case(rng: np.random.Generator, messages: int, by_socket: bool) -> int:
    """Send requests and messages; returns their number. Raises FaultError."""
    server, controls, loop = _server()
    if by_socket:
        return _by_socket(rng, server)
    gate = Gate("127.0.0.1" if rng.random() < 0.7 else "10.0.0.5")
    for _ in range(messages // 2):
        _request(rng, gate)
    for _ in range(messages - messages // 2):
        _message(rng, server, controls, loop)
    _judge(server, controls)
    return messages


def _request(rng: np.random.Generator, gate: Gate) -> None:
    headers, own, host = Headers(), rng.random() < 0.4, str(values.pick(rng, _OWN))
    token = bool(gate.token)
    sound = own
    if own:
        headers["Host"] = host
        if rng.random() < 0.7:
            headers["Origin"] = f"http{'s' * int(rng.integers(2))}://{host}"
    else:
        sound = _forge(rng, headers, host, token)
    if token and rng.random() < 0.5:
        guess = (
            gate.token if rng.random() < 0.5 else str(values.pick(rng, ("", "x", gate.token[:-1], gate.token + "x")))
        )
        headers["Cookie"] = f"{gate._cookie}={guess}"
        sound = sound and guess == gate.token
    elif token:
        sound = False
    if rng.random() < 0.3:
        headers["Upgrade"] = "websocket"
    answer = gate.answer(_Connection, Request("/", headers))  # type: ignore[arg-type]
    if (answer is None) != sound:
        raise FaultError(f"{'refused' if sound else 'served'}: {list(headers.raw_items())}, token {token}")


def _forge(rng: np.random.Generator, headers: Headers, host: str, token: bool) -> bool:
    """Headers of another page or by another name; True where a token makes the name free."""
    kind, other = int(rng.integers(4)), str(values.pick(rng, _OTHER))
    if kind == 0:
        headers["Host"] = host
        headers["Origin"] = str(
            rng.choice(["null", "", "file://", f"http://{other}", f"http://{host}.x", f"ws://{host}"])
        )
        return headers["Origin"] == f"http://{host}"
    if kind == 1:
        headers["Host"] = other
        headers["Origin"] = f"http://{other}"
        return token
    if kind == 2:
        headers["Host"], headers["host"] = host, other
        return False
    headers["Origin"] = f"http://{host}"
    return False


def _bytes(rng: np.random.Generator, controls: list[Any]) -> bytes:
    """A message: often that of a control with any value, sometimes of any type, then damaged."""
    control, junk = controls[rng.integers(len(controls))], [values.number(rng), values.text(rng), None, True, [], {}]
    value = junk[rng.integers(len(junk))] if rng.random() < 0.7 else float(rng.uniform(-100.0, 1000.0))
    key = str(values.pick(rng, ("value", "value", "value", "update_cb", "is_button", "uuid", "sync_cb")))
    fields: dict[str, Any] = {"type": "GuiUpdateMessage", "uuid": control._impl.uuid, "updates": {key: value}}
    if rng.random() < 0.3:
        fields["type"] = str(values.pick(rng, _KINDS))
        fields |= {"source_component_uuid": control._impl.uuid, "transfer_uuid": "t", "filename": "f", "mime_type": "m"}
        fields |= {"part_count": 10**9, "size_bytes": 10**12, "name": "/hand", "content": bytes(50), "part_index": 0}
    data = msgspec.msgpack.encode(fields)
    return damaged(rng, data, 2) if rng.random() < 0.5 else data


def _message(rng: np.random.Generator, server: viser.ViserServer, controls: list[Any], loop: Any) -> None:
    web = server._websock_server
    try:
        message = _messages.Message.deserialize(_bytes(rng, controls))
    except Exception:  # the connection of the sender ends
        return
    try:
        loop.run_until_complete(web._handle_incoming_message(0, message))  # type: ignore[arg-type]
    except Exception:  # noted by the server's loop, which goes on
        return


def _judge(server: viser.ViserServer, controls: list[Any]) -> None:
    slider, choice, box = controls
    if not (0.0 <= slider.value <= 900.0 and choice.value in choice.options and isinstance(box.value, bool)):
        raise FaultError(f"controls have {slider.value!r}, {choice.value!r}, {box.value!r}")
    kept = len(server._websock_server._broadcast_buffer.message_from_id)
    if server.gui._current_file_upload_states or kept > _MOST_KEPT:
        raise FaultError(f"{kept} messages and {len(server.gui._current_file_upload_states)} uploads are kept")
    for control in controls:
        if not callable(control._impl.sync_cb) or not isinstance(control._impl.update_cb, list):
            raise FaultError("an attribute of the server's own control was exchanged")


def _by_socket(rng: np.random.Generator, server: viser.ViserServer) -> int:
    """A damaged handshake, then one with damaged frames; the next sound request is served."""
    port = server.get_port()
    hello = (
        f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        f"Sec-WebSocket-Protocol: viser-v{viser.__version__}\r\n\r\n"
    ).encode()
    for data in (damaged(rng, hello, 3), hello + damaged(rng, b"\x82\x85\1\2\3\4" + rng.bytes(40), 3)):
        with socket.create_connection(("127.0.0.1", port), timeout=8.0) as peer:
            peer.sendall(data)
    with socket.create_connection(("127.0.0.1", port), timeout=8.0) as peer:
        peer.sendall(f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n".encode())
        if not peer.recv(64).startswith(b"HTTP/1.1 200"):
            raise FaultError("the next sound request is not served")
    return 3
