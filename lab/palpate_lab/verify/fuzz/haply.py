"""Damaged messages of Haply's service: states, events and WebSocket frames, 100 a run.

Python's own JSON reader judges the states and events: what the driver accepts has the same finite numbers there, and
what is undamaged is accepted. The package `websockets`, where it is installed, judges the frames.
"""

from __future__ import annotations

import json
import math
import socket
from functools import cache
from typing import Any

import numpy as np

from palpate import _haply
from palpate.devices.haply.messages import DIALECTS, Config, Grip, State, by_id, device_entry, event, grip_entry
from palpate.devices.haply.service import entries
from palpate_lab.verify.fuzz import FaultError
from palpate_lab.verify.fuzz.damage import damaged

_STATES, _EVENTS, _FRAMES = 60, 20, 20  # messages of a run
_LARGEST = 65536  # bytes of a message


def case(seed: int) -> dict[str, int]:
    """Read 100 damaged messages.

    Raises:
        FaultError: numbers were accepted that are not in the message, or a sound message was refused.
    """
    rng = np.random.default_rng(seed)
    reader, counts = _reader(), {"messages": _STATES + _EVENTS + _FRAMES}
    for _ in range(_STATES):
        sound = _state(rng)
        text = damaged(rng, sound, 3)
        _add(counts, "states accepted" if _judge_state(reader, text, text == sound) else "states refused")
    for _ in range(_EVENTS):
        _add(counts, "events of ours" if reader.read_event(damaged(rng, _event(rng), 3)) else "other events")
    for _ in range(_FRAMES):
        _judge_frames(damaged(rng, _frames(rng), 2))
    return counts


@cache
def _reader() -> Any:
    return _haply.Reader("04C3", "1102", "wireless_verse_grip")


def _add(counts: dict[str, int], name: str) -> None:
    counts[name] = counts.get(name, 0) + 1


def _state(rng: np.random.Generator) -> bytes:
    """A sound answer of a service of any version."""
    dialect = DIALECTS[rng.integers(len(DIALECTS))]
    state = State(rng.normal(size=3), rng.normal(size=3), rng.normal(size=3), ready=bool(rng.integers(2)))
    grip = Grip(buttons={"a": bool(rng.integers(2)), "b": bool(rng.integers(2)), "c": False})
    config = Config() if rng.integers(2) else None
    message: dict[str, Any] = {
        "inverse3": [device_entry(id, False, config, state, dialect) for id in ("04BA", "04C3")],
        "wireless_verse_grip": [grip_entry(grip, "wireless_verse_grip", config is not None, dialect)],
    }
    if dialect == "3.0":
        message = {kind: by_id(found) for kind, found in message.items()}
    return json.dumps({"session_id": 7, **message}).encode()


def _event(rng: np.random.Generator) -> bytes:
    names = ("device-sleep", "device-battery-low", "device-safety-triggered", "device-disconnected", "invalid-value")
    data = {"device_id": ("04C3", "1102", "FFFF")[rng.integers(3)], "safety_type": "ebrake_triggered"}
    return json.dumps(event(names[rng.integers(len(names))], "warning", "words", **data)).encode()


def _judge_state(reader: Any, text: bytes, sound: bool) -> bool:
    """True if the message was accepted."""
    found = reader.read(text)
    if found is None:
        if sound:
            raise FaultError("a sound message was refused", details={"text": text.decode(errors="replace")[:2000]})
        return False
    try:
        message = json.loads(text)
        device = next(entry for entry in entries(message, "inverse3") if entry.get("device_id") == "04C3")
        still = dict.fromkeys("xyz", 0.0)  # a velocity that is left out
        named = [device["state"]["cursor_position"], device["state"].get("cursor_velocity") or still]
        expected = [[float(vector[axis]) for axis in "xyz"] for vector in named]
    except (ValueError, KeyError, TypeError, StopIteration, OverflowError) as error:
        what = f"numbers were accepted that Python does not find: {type(error).__name__}: {error}"
        raise FaultError(what, details={"text": text.decode(errors="replace")[:2000]}) from None
    same = all(math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-300)
               for row, other in zip(found[:2], expected, strict=True)
               for a, b in zip(row, other, strict=True))  # fmt: skip
    if not same:
        what = f"{found[:2]} was read, not {expected}"
        raise FaultError(what, details={"text": text.decode(errors="replace")[:2000]})
    return True


def _frames(rng: np.random.Generator) -> bytes:
    """Some sound frames, as a service sends them."""
    out = b""
    for _ in range(int(rng.integers(1, 5))):
        payload = rng.bytes(int(rng.integers(0, 300)))
        kind = int(rng.integers(0, 6))
        if kind == 0:
            out += _frame(0x89, payload[:100])
        elif kind == 1 and payload:
            out += _frame(0x01, payload[: len(payload) // 2]) + _frame(0x80, payload[len(payload) // 2 :])
        else:
            out += _frame(0x81, payload)
    return out


def _frame(head: int, payload: bytes) -> bytes:
    n = len(payload)
    return bytes([head]) + (bytes([n]) if n < 126 else b"\x7e" + n.to_bytes(2, "big")) + payload


def _judge_frames(data: bytes) -> None:
    """Compare the messages in a stream of frames with those that `websockets` finds, up to the first mistake."""
    ours, theirs = socket.socketpair()
    with theirs:
        connection = _haply.Connection(ours.detach())
        theirs.sendall(data)
        theirs.shutdown(socket.SHUT_WR)
        found = []
        while True:
            try:
                found.append(connection.receive_bytes(0.0))
            except RuntimeError:
                break
    expected = _expected(data)
    if expected is not None and found != expected:
        what = f"{len(found)} messages were found, {len(expected)} by websockets"
        raise FaultError(what, details={"data": data.hex()})


def _expected(data: bytes) -> list[bytes] | None:
    """The messages in a stream of frames; None without the package `websockets`."""
    try:
        from websockets.frames import Frame, Opcode
        from websockets.protocol import CLIENT, Protocol, State
    except ImportError:
        return None
    protocol = Protocol(CLIENT, state=State.OPEN, max_size=_LARGEST)
    protocol.receive_data(data)
    whole, parts = [], b""
    for frame in protocol.events_received():
        assert isinstance(frame, Frame)
        if frame.opcode is Opcode.CLOSE:
            break
        if frame.opcode in (Opcode.TEXT, Opcode.BINARY, Opcode.CONT):
            parts += bytes(frame.data)
            if frame.fin:
                whole.append(parts)
                parts = b""
    return whole
