"""The vendor's Inverse Service as a client sees it before the cycle: version, inventory, settings, connections."""

from __future__ import annotations

import base64
import hashlib
import json
import os
import socket
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING, Any
from urllib.error import HTTPError, URLError
from urllib.parse import urlsplit
from urllib.request import Request, urlopen

from palpate.base.errors import DeviceError

if TYPE_CHECKING:
    from palpate import _haply

Json = dict[str, Any]
PORT, EVENTS_ABOVE = 10001, 19
"""Port of HTTP and of the WebSocket; the events are this much above."""
GRIPS = ("wireless_verse_grip", "custom_verse_grip", "verse_grip")
"""Lists of grips in the messages, the preferred ones first."""
_TIMEOUT = 5.0  # of each answer before the cycle begins; on a busy machine 2 s were too short [s]
_MAGIC = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"  # RFC 6455, 1.3
_START = "install and start Haply Hub or the Inverse Service, then the device; or: palpate device stand-in haply"


@dataclass(frozen=True)
class Address:
    """Where the service listens."""

    host: str = "127.0.0.1"
    port: int = PORT

    @classmethod
    def parse(cls, url: str) -> Address:
        """``ws://HOST:PORT``, ``HOST:PORT`` or ``HOST``.

        Raises:
            DeviceError: it is none of them.
        """
        why = "it is not ws://HOST:PORT"
        try:
            parts = urlsplit(url if "//" in url else f"ws://{url}")
            if parts.scheme == "ws" and parts.hostname and parts.path in ("", "/"):
                return cls(parts.hostname, parts.port or PORT)
            if parts.scheme in ("wss", "https", "http"):
                why = f"the service speaks ws://, not {parts.scheme}://"
        except ValueError as error:
            why = str(error)
        mend = f"write e.g. ws://127.0.0.1:{PORT}"
        raise DeviceError(f"{url!r} is no address of Haply's service", why=why, mend=mend)

    def __str__(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    def start_it(self) -> str:
        """What helps where nobody answers."""
        return _START if self == Address() else f"check the address in url; else {_START}"

    def answers(self, timeout: float = 0.2) -> bool:
        """True if something listens there."""
        try:
            with socket.create_connection((self.host, self.port), timeout):
                return True
        except OSError:
            return False


def version(at: Address) -> tuple[int, int]:
    """Version of the service; its HTTP may be on the port below, as with the services before 3.5.

    Raises:
        DeviceError: there is no such service.
    """
    why = ""
    for port in (at.port, at.port - 1):
        for path in ("version", "3.1/version", "3.0/version"):
            try:
                told = request(Address(at.host, port), "GET", path)
                major, minor = str(told["project_version"]).split(".")[:2]
                return int(major), int(minor)
            except DeviceError as error:
                why = why or error.why or error.what
            except (KeyError, TypeError, ValueError):
                why = "it answers, but not with a version of that service"
    raise DeviceError(f"no Haply Inverse Service answers on {at}", why=why, mend=at.start_it())


def request(at: Address, method: str, path: str, body: Any = None) -> Any:
    """The JSON that an HTTP request brings, without its envelope {ok, data, error}.

    Raises:
        DeviceError: nobody answers, or the answer is an error or no JSON.
    """
    data = None if body is None else json.dumps(body).encode()
    asked = Request(f"http://{at}/{path}", data, {"Content-Type": "application/json"}, method=method)
    try:
        with urlopen(asked, timeout=_TIMEOUT) as answer:
            told = json.loads(answer.read())
    except HTTPError as error:
        raise DeviceError(f"{method} {path}: HTTP {error.code}", why=error.read(200).decode(errors="replace")) from None
    except (URLError, OSError, ValueError) as error:
        why = str(getattr(error, "reason", error))
        raise DeviceError(f"{method} {path} of {at} brought no answer", why=why) from None
    if isinstance(told, dict) and "ok" in told:
        if told["ok"] is not True:
            raise DeviceError(f"{method} {path} was refused", why=str(told.get("error")))
        return told.get("data")
    return told


def compiled() -> ModuleType:
    """The part of the core that speaks to the service.

    Raises:
        DeviceError: it is not compiled, and cannot be.
    """
    try:
        from palpate import _haply
    except ImportError as error:
        what = "the driver of Haply devices cannot be compiled"
        mend = "in a clone: make setup, which brings Boost; elsewhere: pip install 'palpate[haply]'"
        raise DeviceError(what, why=str(error), mend=mend) from None
    return _haply


def websocket(at: Address) -> _haply.Connection:
    """An open WebSocket, after the handshake of RFC 6455, without extensions.

    Raises:
        DeviceError: nobody listens, or the answer is no WebSocket.
    """
    part = compiled()
    try:
        wire = socket.create_connection((at.host, at.port), _TIMEOUT)
    except OSError as error:
        raise DeviceError(f"nobody listens on {at}", why=str(error), mend=at.start_it()) from None
    key = base64.b64encode(os.urandom(16))
    lines = (
        "GET / HTTP/1.1", f"Host: {at}", "Upgrade: websocket", "Connection: Upgrade",
        f"Sec-WebSocket-Key: {key.decode()}", "Sec-WebSocket-Version: 13", "", "",
    )  # fmt: skip
    head = b""
    try:
        wire.sendall("\r\n".join(lines).encode())
        while not head.endswith(b"\r\n\r\n") and len(head) < 8192:
            byte = wire.recv(1)  # one by one: what follows the head belongs to the connection
            if not byte:
                break
            head += byte
    except OSError as error:
        wire.close()
        raise DeviceError(
            f"{at} does not finish the handshake of a WebSocket", why=str(error), mend=at.start_it()
        ) from None
    accepted = base64.b64encode(hashlib.sha1(key + _MAGIC, usedforsecurity=False).digest())
    status, _, rest = head.partition(b"\r\n")
    fields = dict(line.lower().split(b":", 1) for line in rest.split(b"\r\n") if b":" in line)
    if b" 101 " not in status + b" " or fields.get(b"sec-websocket-accept", b"").strip() != accepted.lower():
        wire.close()
        raise DeviceError(f"{at} is no WebSocket", why=status.decode(errors="replace")[:80], mend=at.start_it())
    wire.setblocking(True)
    connection: _haply.Connection = part.Connection(wire.detach())
    return connection


def receive(connection: _haply.Connection, at: Address) -> Json:
    """The next message of a connection, an object.

    Raises:
        DeviceError: there is none, or it is no JSON object.
    """
    try:
        told = json.loads(connection.receive(_TIMEOUT))
    except (RuntimeError, ValueError) as error:
        raise DeviceError(f"the service on {at} gives no valid message", why=str(error), mend=at.start_it()) from None
    if not isinstance(told, dict):
        raise DeviceError(f"the service on {at} gives no valid message", why=f"{type(told).__name__}, not an object")
    return told


def entries(message: Json, kind: str) -> list[Json]:
    """The devices of a list in a message; service 3.0 has an object with their ids as keys instead.

    What has no id, a text or a number from 0 on, is no device.
    """
    given = message.get(kind)
    if isinstance(given, dict):
        given = [{**entry, "device_id": id} for id, entry in given.items() if isinstance(entry, dict)]
    listed = given if isinstance(given, list) else []
    return [entry for entry in listed if isinstance(entry, dict) and _is_id(entry.get("device_id"))]


def _is_id(given: Any) -> bool:
    return isinstance(given, str) or (type(given) is int and 0 <= given < 2**64)


def id_of(entry: Json) -> str:
    """The id of one of the `entries`, as a text."""
    return str(entry["device_id"])


def truth(given: Any) -> Any:
    """True and False for 1 and 0, as some write them; anything else as it is."""
    return bool(given) if isinstance(given, int) and given in (0, 1) else given


def part(entry: Json, name: str) -> Json:
    """An object in an entry; empty if it is left out or null.

    Raises:
        DeviceError: it is something else.
    """
    given = entry.get(name)
    if given is not None and not isinstance(given, dict):
        what = f"the service gives {name} as {given!r:.40}, which is no object"
        raise DeviceError(what, mend="update the service; if it is the newest, report this")
    return given or {}


def grip_of(message: Json, wanted: str | None, at: Address) -> tuple[str, str]:
    """Id of the grip and its list: the wanted one, or the first that is awake; "" without one.

    A grip that is named in two lists is taken from the first one.

    Raises:
        DeviceError: there is no such grip.
    """
    if wanted == "none":
        return "", ""
    grips = [(entry, kind) for kind in GRIPS for entry in entries(message, kind)]
    ids = [id_of(entry) for entry, _ in grips]
    if wanted is not None:
        if wanted not in ids:
            known = f"it knows {', '.join(dict.fromkeys(ids))}" if ids else "it knows none"
            mend = "wake the grip, or write grip: none to feel without orientation"
            raise DeviceError(f"the service on {at} knows no grip {wanted!r}", why=known, mend=mend)
        return wanted, grips[ids.index(wanted)][1]
    awake = [(id, kind) for id, (entry, kind) in zip(ids, grips, strict=True)
             if truth(part(entry, "status").get("awake", True)) is True]  # fmt: skip
    return awake[0] if awake else ("", "")
