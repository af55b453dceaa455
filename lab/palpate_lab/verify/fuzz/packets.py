"""Damaged OpenIGTLink messages to the server of poses and to the tracker.

The next sound peer must be served, and no pose may be trusted that is not rigid.
"""

from __future__ import annotations

import math
import socket
import threading
import time
from collections.abc import Callable

import numpy as np

from palpate.sensing.trackers.gate import Gate
from palpate.sensing.trackers.openigtlink import OpenIGTLinkServer, OpenIGTLinkTracker
from palpate_lab.verify.fuzz import FaultError
from palpate_lab.verify.fuzz.damage import damaged

LOOPBACK = "127.0.0.1"
PATIENCE = 8.0  # time within which a sound peer is served [s]


def case(seed: int) -> dict[str, int]:
    """Send damaged messages to one of both, end the connection, and connect as a sound peer.

    Raises:
        FaultError: the sound peer is not served, the port is not freed, or a pose that is not rigid was trusted.
    """
    rng = np.random.default_rng(seed)
    data = b"".join(damaged(rng, _message(rng), 2) for _ in range(int(rng.integers(1, 4))))
    if rng.uniform() < 0.4:
        data = data[: int(rng.integers(0, len(data) + 1))]
    if rng.uniform() < 0.5:
        return _to_server(data)
    return _to_tracker(data)


def _to_server(data: bytes) -> dict[str, int]:
    server = OpenIGTLinkServer(0)
    with socket.create_connection((LOOPBACK, server.port)) as peer:
        peer.sendall(data)
    with socket.create_connection((LOOPBACK, server.port)) as peer:
        peer.settimeout(0.02)

        def received() -> bool:
            server.send_pose("tool", np.eye(4), 1.0)
            try:
                return len(peer.recv(64)) > 0
            except TimeoutError:
                return False

        _wait("the server serves no sound client any more", received)
    closing = threading.Thread(target=server.close, daemon=True)
    closing.start()
    closing.join(PATIENCE)
    if closing.is_alive():
        raise FaultError("the server cannot be closed")
    return {"server": 1}


def _to_tracker(data: bytes) -> dict[str, int]:
    gate, trusted = Gate("tool", np.eye(4)), 0
    with socket.create_server((LOOPBACK, 0)) as server:
        server.settimeout(PATIENCE)
        tracker = OpenIGTLinkTracker(f"{LOOPBACK}:{server.getsockname()[1]}")
        try:
            with server.accept()[0] as peer:
                peer.sendall(data)
            end = time.monotonic() + 0.05
            while time.monotonic() < end:
                for seen in tracker.poll(0.0):
                    trusted += gate.take(seen, 0.0)
            turn = gate.X[:3, :3]
            if not np.isfinite(gate.X).all() or not np.allclose(turn @ turn.T, np.eye(3), atol=1e-3):
                raise FaultError(f"a pose is trusted that is not rigid: {gate.X.tolist()}")
            _heard_again(server, tracker)
        finally:
            tracker.close()
    return {"tracker": 1, "trusted": trusted}


def _heard_again(server: socket.socket, tracker: OpenIGTLinkTracker) -> None:
    """The tracker connects again and takes in a sound message."""
    sound, found = _packed("sound", np.eye(4), 1.0), list[socket.socket]()
    server.settimeout(0.02)

    def connected() -> bool:
        tracker.poll(0.0)
        try:
            found.append(server.accept()[0])
        except TimeoutError:
            return False
        return True

    _wait("the tracker does not connect again", connected)
    with found[0] as peer:

        def received() -> bool:
            peer.sendall(sound)
            time.sleep(0.005)
            return any(seen.tool == "sound" for seen in tracker.poll(0.0))

        _wait("the tracker hears no sound server any more", received)


def _wait(fault: str, holds: Callable[[], bool]) -> None:
    end = time.monotonic() + PATIENCE
    while not holds():
        if time.monotonic() > end:
            raise FaultError(fault)


def _message(rng: np.random.Generator) -> bytes:
    """A TRANSFORM or STRING message as sound servers send it; sometimes with a matrix that is no pose."""
    if rng.uniform() < 0.2:
        import pyigtl

        return bytes(pyigtl.StringMessage("start", device_name="tool").pack())
    X = np.eye(4)
    X[:3, 3] = 100.0 * rng.normal(size=3)
    if rng.uniform() < 0.4:
        X[rng.integers(3), rng.integers(4)] = rng.choice([math.nan, math.inf, 1e30, 2.0, -1.0])
    return _packed("tool", X, float(rng.choice([1.0, 1e9])))


def _packed(name: str, X: np.ndarray[tuple[int, ...], np.dtype[np.float64]], stamp: float) -> bytes:
    import pyigtl

    message = pyigtl.TransformMessage(X, timestamp=stamp, device_name=name)
    message.header_version = 2
    message.metadata = {f"{name}Status": "OK", "ErrorMm": "0.2"}
    return bytes(message.pack())
