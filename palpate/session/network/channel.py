"""Encrypted packets and the reliable channel beside them.

Both ends share a key of 32 bytes. A connection begins with one random nonce and one X25519 key of each end in clear;
HKDF-SHA256 over the shared secret and the key gives a key for each direction and channel, and the number of the
session. All else is encrypted and authenticated by ChaCha20-Poly1305 (RFC 8439) of the library `cryptography`. The
nonce of a packet is its number, which is sent in clear; a window refuses numbers that were seen.
"""

from __future__ import annotations

import contextlib
import json
import re
import secrets
import socket
import struct
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from palpate import _network
from palpate.base.errors import PalpateError

MAGIC = b"PLP" + bytes([_network.PACKET_VERSION])
_HEAD = struct.Struct("<4s8sQ")  # magic with version, session, number
TAG = 16
DATAGRAM = _HEAD.size + _network.PACKET_SIZE + TAG
"""Bytes of a packet of one pair on the wire, without the headers of UDP."""
_LARGEST = 2048  # of what is read from a socket of packets [bytes]
_MOST = 64  # packets that are read at once
_HELLO = b"PALPATE-REMOTE-1"
_LONGEST = 1 << 19  # of a message of the reliable channel: a picture of the camera [bytes]
_INFO = b"palpate remote 1"


def size(pairs: int) -> int:
    """Bytes of a packet of so many pairs on the wire, without the headers of UDP."""
    return DATAGRAM + (pairs - 1) * _network.PACKET_SIZE


class RefusedError(PalpateError):
    """The other end refuses the connection, or speaks another protocol."""


class Sealer:
    """Encrypts the packets of one direction."""

    def __init__(self, key: bytes, session: bytes, first: int = 0) -> None:
        from cryptography.hazmat.primitives.ciphers.aead import ChaCha20Poly1305

        self._aead, self._session, self._number = ChaCha20Poly1305(key), session, first

    def seal(self, payload: bytes) -> bytes:
        """The packet on the wire."""
        self._number += 1
        head = _HEAD.pack(MAGIC, self._session, self._number)
        return head + self._aead.encrypt(struct.pack("<4xQ", self._number), payload, head)


class Opener:
    """Decrypts the packets of one direction; all but authentic new ones are refused, and counted."""

    def __init__(self, key: bytes, session: bytes) -> None:
        from cryptography.exceptions import InvalidTag
        from cryptography.hazmat.primitives.ciphers.aead import ChaCha20Poly1305

        self._aead, self._session, self._invalid = ChaCha20Poly1305(key), session, InvalidTag
        self._window = _network.ReplayWindow()
        self.refused = 0  #: packets that were not accepted

    def open(self, data: bytes) -> bytes | None:
        """The payload of a packet; None unless it is authentic and new."""
        payload = self._payload(data)
        self.refused += payload is None
        return payload

    def _payload(self, data: bytes) -> bytes | None:
        if len(data) < _HEAD.size + TAG:
            return None
        magic, session, number = _HEAD.unpack_from(data)
        if magic != MAGIC or session != self._session or number == 0:
            return None
        try:
            payload = self._aead.decrypt(struct.pack("<4xQ", number), data[_HEAD.size :], data[: _HEAD.size])
        except self._invalid:
            return None
        return payload if self._window.accept(number) else None


@dataclass
class Channel:
    """The reliable channel, and the keys of the packets beside it."""

    connection: socket.socket
    sealer: Sealer  #: of packets to the other end
    opener: Opener  #: of packets from it
    _to: Sealer
    _from: Opener
    _sending: threading.Lock = field(default_factory=threading.Lock)

    def send(self, message: dict[str, Any]) -> None:
        """Send a message; any thread may call."""
        text = json.dumps(message).encode()
        with self._sending:
            data = self._to.seal(text)
            self.connection.sendall(struct.pack("<I", len(data)) + data)

    def receive(self) -> dict[str, Any] | None:
        """The next message; None at the end of the connection.

        Raises:
            RefusedError: what arrived is not encrypted with the shared key.
        """
        head = _exactly(self.connection, 4)
        if head is None:
            return None
        (length,) = struct.unpack("<I", head)
        data = _exactly(self.connection, length) if length <= _LONGEST else None
        payload = None if data is None else self._from.open(data)
        if payload is None:
            raise RefusedError(
                "the other end has another key", mend="copy the same key file to both machines (palpate keys)"
            )
        message = json.loads(payload)
        if not isinstance(message, dict):
            raise RefusedError("the other end sent no message")
        return message

    def close(self) -> None:
        """End the connection; a thread that waits for a message gets None."""
        with contextlib.suppress(OSError):
            self.connection.shutdown(socket.SHUT_RDWR)
        self.connection.close()


def arrived(udp: socket.socket) -> Iterator[tuple[bytes, tuple[str, int]]]:
    """Packets that wait at a socket that does not block, with their senders.

    At most 64, so that a flood does not hold the caller's loop; the rest waits for the next call.
    """
    for _ in range(_MOST):
        try:
            yield udp.recvfrom(_LARGEST)
        except OSError:  # nothing more, or the other end is not there at this moment
            return


def _exactly(connection: socket.socket, n: int) -> bytes | None:
    data = bytearray()
    while len(data) < n:
        part = connection.recv(n - len(data))
        if not part:
            return None
        data += part
    return bytes(data)


def shake_hands(connection: socket.socket, key: bytes, operator: bool) -> Channel:
    """The channel of a fresh connection.

    Raises:
        RefusedError: the other end does not speak this protocol, or has ended the connection.
        OSError, TimeoutError: the connection broke.
    """
    from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PrivateKey, X25519PublicKey
    from cryptography.hazmat.primitives.hashes import SHA256
    from cryptography.hazmat.primitives.kdf.hkdf import HKDF

    own, nonce = X25519PrivateKey.generate(), secrets.token_bytes(16)
    try:
        connection.sendall(_HELLO + nonce + own.public_key().public_bytes_raw())
        hello = _exactly(connection, len(_HELLO) + 48)
    except ConnectionError:  # it was closed with our words unread
        hello = None
    if hello is None:
        raise RefusedError("the other end has ended the connection", mend="is a follower of Palpate running there?")
    if not hello.startswith(_HELLO):
        raise RefusedError("the other end speaks another protocol, or another version of it",
                           mend="install the same version of Palpate on both machines")  # fmt: skip
    theirs, public = hello[len(_HELLO) : -32], hello[-32:]
    shared = own.exchange(X25519PublicKey.from_public_bytes(public))
    nonces = nonce + theirs if operator else theirs + nonce
    made = HKDF(SHA256(), 4 * 32 + 8, nonces, _INFO).derive(shared + key)
    keys, session = [made[32 * i : 32 * i + 32] for i in range(4)], made[-8:]
    mine, other = (keys[:2], keys[2:]) if operator else (keys[2:], keys[:2])
    return Channel(connection, Sealer(mine[0], session), Opener(other[0], session), Sealer(mine[1], session),
                   Opener(other[1], session))  # fmt: skip


def address(text: str) -> tuple[str, int]:
    """Host and port of ``HOST:PORT``.

    Raises:
        PalpateError: it is no such text, or the name does not resolve.
    """
    host, colon, port = text.rpartition(":")
    if not colon or not host or not re.fullmatch("[0-9]{1,5}", port) or not 0 < int(port) < 65536:
        raise PalpateError(f"{text[:80]!r} is no address", mend="give HOST:PORT, e.g. 192.168.1.7:7410")
    try:
        found = socket.getaddrinfo(host.strip("[]"), int(port), socket.AF_INET, socket.SOCK_STREAM)
    except (socket.gaierror, UnicodeError) as error:
        raise PalpateError(f"the name {host[:80]!r} does not resolve", why=str(error),
                           mend="give the address, e.g. 192.168.1.7:7410") from None  # fmt: skip
    return str(found[0][4][0]), int(port)
