"""HTTP and WebSocket connections on one port, as Haply's service has them; each in its own thread."""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Callable
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from websockets.datastructures import Headers
from websockets.frames import Frame, Opcode
from websockets.http11 import Request
from websockets.protocol import State
from websockets.server import ServerProtocol

from palpate.base.errors import DeviceError

_LONGEST = 1 << 20  # bytes of an HTTP body or a WebSocket message


class Connection:
    """A WebSocket connection of a client; `send` may be called from any thread."""

    def __init__(self, wire: socket.socket, protocol: ServerProtocol) -> None:
        self._wire, self._protocol, self._lock = wire, protocol, threading.Lock()
        self._parts: list[bytes] = []

    def begin(self, among: set[Connection]) -> None:
        """Send the answer to the handshake; whoever reads it is among the connections already.

        Raises:
            OSError: the connection is broken.
        """
        with self._lock:
            among.add(self)
            self._flush()

    def send(self, text: str | bytes, binary: bool = False) -> None:
        """Send a message; nothing is sent after the close.

        Raises:
            OSError: the connection is broken.
        """
        data = text.encode() if isinstance(text, str) else text
        with self._lock:
            if self._protocol.state is State.OPEN:
                (self._protocol.send_binary if binary else self._protocol.send_text)(data)
                self._flush()

    def messages(self) -> list[bytes]:
        """Wait for data; the messages that it completes. An empty list also at the end: see `open`."""
        data = self._wire.recv(65536)
        with self._lock:
            if data:
                self._protocol.receive_data(data)
            else:
                self._protocol.receive_eof()
            found = [m for e in self._protocol.events_received() if (m := self._whole(e)) is not None]
            self._flush()
        return found

    @property
    def open(self) -> bool:
        """True while messages can be exchanged."""
        return self._protocol.state is State.OPEN

    def drop(self) -> None:
        """Break the connection without a word, as a killed service does."""
        try:
            self._wire.shutdown(socket.SHUT_RDWR)
        except OSError:
            return

    def _whole(self, frame: Any) -> bytes | None:
        """The message that a frame completes; None for control frames and parts of a message."""
        if not isinstance(frame, Frame) or frame.opcode not in (Opcode.TEXT, Opcode.BINARY, Opcode.CONT):
            return None
        self._parts.append(bytes(frame.data))
        if not frame.fin:
            return None
        whole, self._parts = b"".join(self._parts), []
        return whole

    def _flush(self) -> None:
        for data in self._protocol.data_to_send():
            if data:
                self._wire.sendall(data)


@dataclass
class Port:
    """A port that is listened on; `close` also breaks the connections.

    Args:
        host: address.
        number: port; 0: a free one.
        http: answers a request: method, path, body as JSON (None without one); returns status and body.
        websocket: serves a WebSocket connection until it returns.

    Raises:
        DeviceError: the port cannot be listened on.
    """

    host: str
    number: int
    http: Callable[[str, str, Any], tuple[int, Any]]
    websocket: Callable[[Connection], None]

    def __post_init__(self) -> None:
        self.connections: set[Connection] = set()
        try:
            self._server = _Server((self.host, self.number), _Handler)
        except OSError as error:
            mend = "end the program that uses it (the real service?), or give another --port"
            raise DeviceError(f"port {self.number} of {self.host} is taken", why=str(error), mend=mend) from None
        self._server.port = self
        self.number = int(self._server.server_address[1])
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.05,), daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop listening and break all connections."""
        self._server.shutdown()
        self._server.server_close()
        for connection in list(self.connections):
            connection.drop()


class _Server(ThreadingHTTPServer):
    daemon_threads, allow_reuse_address = True, True
    port: Port

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A client that breaks its connection is no event."""


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    server: _Server

    def do_GET(self) -> None:
        if self.headers.get("Upgrade", "").lower() == "websocket":
            self._upgrade()
        else:
            self._answer()

    def do_POST(self) -> None:
        self._answer()

    do_PATCH = do_DELETE = do_POST

    def log_message(self, format: str, *args: Any) -> None:
        """Requests are not logged."""

    def _answer(self) -> None:
        length = int(self.headers.get("Content-Length") or 0)
        if length > _LONGEST:
            self.send_error(413)
            return
        try:
            body = json.loads(self.rfile.read(length)) if length else None
            status, found = self.server.port.http(self.command, self.path, body)
        except ValueError as error:
            status, found = 400, {"ok": False, "error": f"the body is no JSON: {error}"}
        data = json.dumps(found).encode()
        self.send_response(status)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)

    def _upgrade(self) -> None:
        protocol = ServerProtocol(max_size=_LONGEST)  # without extensions: no permessage-deflate
        protocol.receive_data(Request(self.path, Headers(self.headers.items())).serialize())
        (request,) = protocol.events_received()
        assert isinstance(request, Request)
        protocol.send_response(protocol.accept(request))
        self.close_connection = True
        self.connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection, port = Connection(self.connection, protocol), self.server.port
        try:
            connection.begin(port.connections)
            if connection.open:
                port.websocket(connection)
        except OSError:  # the client broke the connection
            return
        finally:
            port.connections.discard(connection)
