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
from collections.abc import Callable, Iterable
from typing import Any, Self

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import MissingExtraError, PalpateError, PortError
from palpate.sensing.trackers import wire
from palpate.sensing.trackers.tracker import Sighting

PORT = 18944
"""Usual port of OpenIGTLink servers."""
_SILENCE = 2.0  # silence after which the client connects again [s]
_PAUSE = 0.05  # between two attempts to connect [s]
MOST_TOOLS = 256
"""Most tools whose poses are kept; those of further ones are dropped."""
_TOLD = 4  # names that a status tells
_POSES = ("TRANSFORM", "QTDATA", "TDATA", "POSITION")
_IDENTITY = "its pose is the identity, which is sent for a marker that is not seen"


def _pyigtl() -> Any:
    try:
        import pyigtl
    except ImportError:
        raise MissingExtraError("OpenIGTLink", "tracking") from None
    return pyigtl


class OpenIGTLinkTracker:
    """Poses of tools from a server: TRANSFORM and POSITION by their device's name, QTDATA and TDATA by the tool's.

    The client connects in the background, and again when the server was silent for two seconds. A metadata entry whose
    key ends in ``Status`` and whose value is not ``OK`` marks a pose as invalid, as PLUS writes it; ``ErrorMm`` is the
    residual of the marker. The identity, which older servers send for a marker that is not seen, is invalid too. Where
    a sender has no clock (stamps of zero, or equal ones with other poses), the time of arrival takes its place.

    Args:
        address: ``host:port`` of the server.
        tools: names of tools that may be longer than the 20 bytes of the wire; sightings carry the whole name.

    Raises:
        MissingExtraError: pyigtl is not installed. PalpateError: two tools have the same first 20 bytes.
    """

    def __init__(self, address: str, tools: Iterable[str] = ()) -> None:
        pyigtl = _pyigtl()
        host, _, port = address.rpartition(":")
        self._reader = PoseReader(tools, pyigtl.messages.CRC64)
        self._address, self._lock, self._stop = (host, int(port)), threading.Lock(), threading.Event()
        self._state = f"no connection to {address}"
        threading.Thread(target=self._run, name="palpate-openigtlink-client", daemon=True).start()

    def poll(self, now: float) -> list[Sighting]:
        """Sightings that arrived since the last call, the newest of each tool."""
        with self._lock:
            return self._reader.take()

    def heard(self, tool: str) -> str:
        """What is known about a tool that is not seen: the connection, and what arrives instead."""
        with self._lock:
            arrives, state = self._reader.heard(tool), self._state
        if not arrives:
            return state
        return f"{state}; before: {arrives}" if state.startswith("no connection") else arrives

    def close(self) -> None:
        """End the connection; its thread ends by itself."""
        self._stop.set()

    def _run(self) -> None:
        host, port = self._address
        while not self._stop.is_set():
            try:
                with socket.create_connection(self._address, timeout=1.0) as connection:
                    self._state = f"connected to {host}:{port}, no message arrives"
                    self._serve(connection)
            except (OSError, ValueError) as error:  # ValueError: what arrives is no OpenIGTLink
                words = " ".join(str(getattr(error, "strerror", None) or error).split())
                self._state = f"no connection to {host}:{port} ({words})"
            self._stop.wait(_PAUSE)

    def _serve(self, connection: socket.socket) -> None:
        """Read until the server closes the connection, is silent for long, or sends damaged bytes."""
        connection.settimeout(0.05)
        connection.sendall(wire.first_message())
        with self._lock:
            self._reader.begin()
        heard = time.monotonic()
        while not self._stop.is_set() and time.monotonic() - heard < _SILENCE:
            try:
                data = connection.recv(1 << 18)
            except TimeoutError:
                continue
            if not data:
                raise ConnectionError("the server closed it")
            heard = time.monotonic()
            with self._lock:
                self._reader.feed(data, time.time())


class PoseReader:
    """Sightings from the bytes of connections, without a socket.

    Args:
        tools: as for `OpenIGTLinkTracker`.
        crc: checksum of a body; None: checksums are not compared.

    Raises:
        PalpateError: two tools have the same first 20 bytes.
    """

    def __init__(self, tools: Iterable[str] = (), crc: Callable[[bytes], int] | None = None) -> None:
        self._crc, self._whole = crc, _by_sent_name(tools)
        self._seen: dict[str, Sighting] = {}
        self._clocks: dict[str, _Clock] = {}
        self._decoder = wire.Decoder(crc)

    def begin(self) -> None:
        """Begin with a new connection."""
        before = self._decoder
        self._decoder = wire.Decoder(self._crc, before.counts, before.damaged, before.fault)

    def feed(self, data: bytes, now: float) -> None:
        """Take in bytes that arrived at the time `now`, in seconds since 1970. ValueError: they are no OpenIGTLink."""
        for pose in self._decoder.feed(data):
            name = self._whole.get(pose.tool, pose.tool)
            if name not in self._clocks and len(self._clocks) >= MOST_TOOLS:
                continue
            t = self._clocks.setdefault(name, _Clock()).time(pose.stamp, pose.X, now)
            self._seen[name] = _sighting(name, pose, t)

    def take(self) -> list[Sighting]:
        """Sightings since the last call, the newest of each tool."""
        found, self._seen = list(self._seen.values()), {}
        return found

    def heard(self, tool: str) -> str:
        """What arrives, in words, if the tool does not; empty if nothing arrives."""
        damaged = self._decoder.damaged
        broken = f"{damaged} messages are damaged: {self._decoder.fault}" if damaged else ""
        if tool in self._clocks:
            return "; ".join(filter(None, (broken, self._clocks[tool].words())))
        known = [f"{name} arrives" for name in list(self._clocks)[:_TOLD]]
        other = [
            f"{kind} of {name or 'no name'} arrives, which is no pose"
            for kind, name in self._decoder.counts
            if kind not in _POSES and kind != "STATUS"
        ]
        words = [*known, *other[:_TOLD]]
        if not words and self._decoder.counts and not broken:
            words = [f"{kind} of {name or 'no name'} arrives" for kind, name in list(self._decoder.counts)[:_TOLD]]
        return "; ".join(filter(None, (*words, broken)))


class _Clock:
    """Times of the poses of one tool: by its stamps, or by arrival where these do not tell one pose from another."""

    def __init__(self) -> None:
        self.without = False  # True: the sender has no clock for this tool
        self._stamp, self._t, self._now = math.nan, math.nan, math.nan
        self._X: Array | None = None
        self._same = 0

    def time(self, stamp: float, X: Array, now: float) -> float:
        """Time of a pose with this stamp that arrived at `now`, both in seconds since 1970."""
        same_pose = self._X is not None and np.array_equal(X, self._X)
        if not self.without and (stamp == 0.0 or (stamp == self._stamp and not same_pose)):
            self.without = True
            self._t = now if math.isnan(self._t) else self._t + max(now - self._now, 1e-6)
        elif self.without:  # goes on from the last time, whatever the clock of the sender was
            self._t += max(now - self._now, 1e-6)
        else:
            self._t = stamp
        self._same = self._same + 1 if same_pose and stamp == self._stamp else 0
        self._stamp, self._X, self._now = stamp, X, now
        return self._t

    def words(self) -> str:
        """What is odd about the stamps, in words."""
        if self._same > 1 and not self.without:
            return "the same pose with the same stamp is sent again and again"
        return "its stamps are zero or equal: times of arrival are used" if self.without else ""


def _by_sent_name(tools: Iterable[str]) -> dict[str, str]:
    """Whole names of tools by what of them fits into a message."""
    found: dict[str, str] = {}
    for tool in tools:
        sent = tool.encode()[: wire.LONGEST_NAME].decode("utf-8", "ignore")
        if found.setdefault(sent, tool) != tool:
            what = f"the tools {found[sent]!r} and {tool!r} have the same first {wire.LONGEST_NAME} characters"
            raise PalpateError(what, why="OpenIGTLink sends no more of a name", mend="give one a shorter name there")
    return found


def _sighting(name: str, pose: wire.Pose, t: float) -> Sighting:
    X = pose.X.copy()
    X[:3, 3] *= 1e-3
    valid = all(value.upper() == "OK" for key, value in pose.metadata.items() if key.endswith("status"))
    try:
        error = 1e-3 * float(pose.metadata.get("errormm", "nan"))
    except ValueError:
        error = math.nan
    why = "" if valid else "the tracker marks the pose as invalid"
    if valid and np.array_equal(pose.X, np.eye(4)):
        why = _IDENTITY
    return Sighting(name, X, t, error, not why, why)


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
        except (OSError, OverflowError) as error:
            raise PortError(f"port {port} cannot be used", why=str(error), mend="give another --port") from None
        finally:
            for s, handler in before.items():  # Ctrl-C ends a session in its own way
                signal.signal(s, handler)
        self.port = int(self._server.server_address[1])
        self._lock = threading.Lock()

    def send(self, seen: Sighting) -> None:
        """Send a pose; nothing is kept for later clients. ``seen.t`` is in seconds since 1970."""
        if len(seen.tool.encode()) > wire.LONGEST_NAME:
            raise PalpateError(
                f"OpenIGTLink allows names of {wire.LONGEST_NAME} characters, {seen.tool!r} is longer",
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

    def send_points(self, name: str, points: Array, t: float) -> None:
        """Send points (n, 3) [m] as a POINT message under a device name, at the time t in seconds since 1970."""
        self._send(self._pyigtl.PointMessage(1e3 * points, timestamp=t, device_name=name))

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
