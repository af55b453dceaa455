"""OpenIGTLink, both sides: damaged messages to the tracker's decoder and to the server of poses.

By a socket, whole connections are damaged, and the next sound peer must be served (`palpate fuzz packets`).
"""

from __future__ import annotations

from io import BytesIO
from typing import Any

import numpy as np

from palpate.trackers.gate import Gate
from palpate.trackers.openigtlink import MOST_TOOLS, idle_client, sightings
from palpate.verify.fuzz import FaultError, packets
from palpate.verify.fuzz.damage import damaged

_ONE = np.eye(3)


class _Peer:
    """The socket of a peer that has sent some bytes and then ends the connection."""

    def __init__(self, data: bytes) -> None:
        self._data = BytesIO(data)

    def recv(self, size: int) -> bytes:
        return self._data.read(size)

    def close(self) -> None:
        self._data.seek(0, 2)


def case(rng: np.random.Generator, messages: int, by_socket: bool) -> int:
    """Send messages; returns their number. Raises FaultError."""
    if by_socket:
        for _ in range(3):
            packets.case(int(rng.integers(2**31)))
        return 6  # a damaged and a sound message each, at least
    gate, client = Gate("tool", np.eye(4)), idle_client()
    for _ in range(messages):
        sound = packets._message(rng)
        _receive(client, damaged(rng, sound, 3) if rng.random() < 0.9 else sound)
        if len(client.incoming_messages) > MOST_TOOLS:
            raise FaultError(f"{len(client.incoming_messages)} tools are kept")
        for seen in sightings(client):
            gate.take(seen, 0.0)
        turn = gate.X[:3, :3]
        if not abs(turn @ turn.T - _ONE).max() < 1e-3 or not np.isfinite(gate.X).all():
            raise FaultError(f"a pose is trusted that is not rigid: {gate.X.tolist()}")
    return messages


def _receive(client: Any, data: bytes) -> None:
    peer = _Peer(data)
    while client._receive_message_from_socket(peer):
        pass
