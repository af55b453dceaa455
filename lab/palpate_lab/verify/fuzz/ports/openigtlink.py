"""OpenIGTLink, both sides: damaged messages to the tracker's decoder and to the server of poses.

By a socket, whole connections are damaged, and the next sound peer must be served (`palpate fuzz packets`).
"""

from __future__ import annotations

import numpy as np

from palpate.sensing.trackers.gate import Gate
from palpate.sensing.trackers.openigtlink import MOST_TOOLS, PoseReader
from palpate_lab.verify.fuzz import FaultError, packets
from palpate_lab.verify.fuzz.damage import damaged

_ONE = np.eye(3)


def case(rng: np.random.Generator, messages: int, by_socket: bool) -> int:
    """Send messages; returns their number. Raises FaultError."""
    if by_socket:
        for _ in range(3):
            packets.case(int(rng.integers(2**31)))
        return 6  # a damaged and a sound message each, at least
    gate, reader = Gate("tool", np.eye(4)), PoseReader()  # without checksums, which would stop most damaged messages
    for k in range(messages):
        sound = packets._message(rng)
        try:
            reader.feed(damaged(rng, sound, 3) if rng.random() < 0.9 else sound, 1e-2 * k)
        except ValueError:
            reader.begin()
        found = reader.take()
        if len(found) > MOST_TOOLS:
            raise FaultError(f"{len(found)} tools are kept")
        for seen in found:
            gate.take(seen, 0.0)
        reader.heard("tool")
        turn = gate.X[:3, :3]
        if not abs(turn @ turn.T - _ONE).max() < 1e-3 or not np.isfinite(gate.X).all():
            raise FaultError(f"a pose is trusted that is not rigid: {gate.X.tolist()}")
    return messages
