"""OpenIGTLink: a client for trackers behind PLUS or 3D Slicer, and a server of poses and forces for 3D Slicer.

Matrices on the wire are in millimetres and single precision (openigtlink.org, TRANSFORM).
"""

from __future__ import annotations

import math
import signal
import socket
import socketserver
import threading
import time
from functools import cache
from typing import Any, Self

import numpy as np

from palpate.arrays import Array
from palpate.errors import MissingExtraError, PalpateError, PortError
from palpate.trackers.tracker import Sighting

PORT = 18944
"""Usual port of OpenIGTLink servers."""
_LONGEST_NAME = 20  # characters of a device name
_SILENCE = 2.0  # silence after which the client connects again [s]
MOST_TOOLS = 256
"""Most device names of which a message is kept until the next poll; those of further ones are dropped."""
_LONGEST_MESSAGE = 2**20  # a longer message is damage: poses and texts are hundreds of bytes [bytes]


def _pyigtl() -> Any:
    try:
        import pyigtl
    except ImportError:
        raise MissingExtraError("OpenIGTLink", "tracking") from None
    return pyigtl


class OpenIGTLinkTracker:
    """Poses of all TRANSFORM messages of a server; a message's device name is the tool's name.

    The client connects in the background, and again when the server was silent for two seconds. A metadata entry whose
    key ends in ``Status`` and whose value is not ``OK`` marks a pose as invalid, as PLUS writes it; ``ErrorMm`` is the
    residual of the marker.

    Args:
        address: ``host:port`` of the server.

    Raises:
        MissingExtraError: pyigtl is not installed.
    """

    def __init__(self, address: str) -> None:
        self._pyigtl = _pyigtl()
        host, _, port = address.rpartition(":")
        self._host, self._port = host, int(port)
        self._client = self._connected()

    def poll(self, now: float) -> list[Sighting]:
        """Sightings that arrived since the last call, the newest of each tool."""
        messages = self._client.get_latest_messages()
        if messages:
            self._heard = time.monotonic()
        elif time.monotonic() - self._heard > _SILENCE:
            self.close()
            self._client = self._connected()
        return _sightings(self._pyigtl, messages)

    def close(self) -> None:
        """End the connection; its thread ends by itself."""
        self._client.communication_thread_stop_requested = True

    def _connected(self) -> Any:
        self._heard = time.monotonic()
        return _client_class(self._pyigtl)(self._host, self._port)


class _Whole:
    """A connection whose end, and the end of its client, are errors: a message cut short is not awaited for ever."""

    def __init__(self, connection: socket.socket, client: Any) -> None:
        self._connection, self._client = connection, client

    def recv(self, size: int) -> bytes:
        """At most `size` bytes, at least one. Raises ConnectionError at the end of the connection."""
        if size > _LONGEST_MESSAGE:
            raise ConnectionError(f"a message of {size} bytes is announced")
        if self._client.communication_thread_stop_requested:
            raise ConnectionError("the client has ended")
        data = self._connection.recv(size)
        if not data:
            raise ConnectionError("the connection has ended")
        return data


@cache
def _client_class(pyigtl: Any) -> Any:
    """pyigtl's client, which connects again when a message is damaged or the connection ends."""

    class Client(pyigtl.OpenIGTLinkClient):  # type: ignore[misc]
        def _receive_message_from_socket(self, ssocket: socket.socket) -> bool:
            try:
                received = bool(super()._receive_message_from_socket(_Whole(ssocket, self)))
                with self.lock_incoming_messages:
                    while len(self.incoming_messages) > MOST_TOOLS:
                        self.incoming_messages.popitem()
                return received
            except Exception:  # what pyigtl raises for damaged bytes is not documented
                self._connected = False
                ssocket.close()
                return False

    return Client


def idle_client() -> Any:
    """The client of `OpenIGTLinkTracker` without its thread and connection, for tests that feed its decoder."""
    return _client_class(_pyigtl())("127.0.0.1", PORT, start_now=False)


def sightings(client: Any) -> list[Sighting]:
    """Sightings that a client has received since the last call."""
    return _sightings(_pyigtl(), client.get_latest_messages())


def _sightings(pyigtl: Any, messages: list[Any]) -> list[Sighting]:
    return [_sighting(message) for message in messages if isinstance(message, pyigtl.TransformMessage)]


def _sighting(message: Any) -> Sighting:
    X = np.array(message.matrix, dtype=np.float64)
    X[:3, 3] *= 1e-3
    told = {str(key).lower(): str(value) for key, value in message.metadata.items()}
    valid = all(value.upper() == "OK" for key, value in told.items() if key.endswith("status"))
    try:
        error = 1e-3 * float(told.get("errormm", "nan"))
    except ValueError:
        error = math.nan
    return Sighting(message.device_name, X, float(message.timestamp), error, valid)


class _Sender(socketserver.BaseRequestHandler):
    """Serves one client: sends what is queued, and ignores what arrives, until the client is gone."""

    server: Any

    def handle(self) -> None:
        """Serve the client until the connection ends or the server stops."""
        self.server._connected = True
        self.request.settimeout(0.01)
        try:
            while not self.server.communication_thread_stop_requested and self._is_there():
                while self.server._send_queued_message_from_socket(self.request):
                    pass
        except OSError:
            pass  # the client is gone
        finally:
            self.server._connected = False

    def _is_there(self) -> bool:
        try:
            return len(self.request.recv(65536)) > 0
        except TimeoutError:
            return True


class OpenIGTLinkServer:
    """A server of poses and texts on the loopback interface; one client at a time, as pyigtl serves.

    Make it in the main thread, because pyigtl handles signals.

    Args:
        port: port; 0 for a free one.

    Raises:
        MissingExtraError: pyigtl is not installed. PortError: the port cannot be used.
    """

    def __init__(self, port: int = PORT) -> None:
        self._pyigtl = _pyigtl()
        before = {s: signal.getsignal(s) for s in (signal.SIGINT, signal.SIGTERM)}
        try:
            self._server = self._pyigtl.OpenIGTLinkServer(port, local_server=True, start_now=False)
            self._server.RequestHandlerClass = _Sender
            self._server.start()
        except OSError as error:
            raise PortError(f"port {port} cannot be used", why=str(error), mend="give another --port") from None
        finally:
            for s, handler in before.items():  # Ctrl-C ends a session in its own way
                signal.signal(s, handler)
        self.port = int(self._server.server_address[1])
        self._lock = threading.Lock()

    def send(self, seen: Sighting) -> None:
        """Send a pose; nothing is kept for later clients. ``seen.t`` is in seconds since 1970."""
        if len(seen.tool.encode()) > _LONGEST_NAME:
            raise PalpateError(
                f"OpenIGTLink allows names of {_LONGEST_NAME} characters, {seen.tool!r} is longer",
                mend="give the frame a shorter name",
            )
        X = seen.X.copy()
        X[:3, 3] *= 1e3
        message = self._pyigtl.TransformMessage(X, timestamp=seen.t, device_name=seen.tool)
        message.header_version = 2
        message.metadata = {f"{seen.tool}Status": "OK" if seen.valid else "INVALID"}
        if math.isfinite(seen.error):
            message.metadata["ErrorMm"] = f"{1e3 * seen.error:.6g}"
        self._send(message)

    def send_pose(self, name: str, X: Array, t: float) -> None:
        """Send a pose (4, 4) [m] under a device name, at the time t in seconds since 1970."""
        self.send(Sighting(name, X, t))

    def send_text(self, name: str, text: str) -> None:
        """Send a STRING message under a device name."""
        self._send(self._pyigtl.StringMessage(text, device_name=name))

    def _send(self, message: Any) -> None:
        with self._lock:
            if self._server.is_connected():
                self._server.send_message(message, wait=False)

    @property
    def is_connected(self) -> bool:
        """True while a client is connected."""
        return bool(self._server.is_connected())

    def close(self) -> None:
        """End the connection and free the port."""
        self._server.stop()

    def __enter__(self) -> Self:
        """The server itself."""
        return self

    def __exit__(self, *error: object) -> None:
        """Close the server."""
        self.close()
