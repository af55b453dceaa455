"""A stand-in of Haply's Inverse Service: a simulated device behind the vendor's messages, for tests and for trying out.

Written from the vendor's documentation of its service 3.0 to 3.5. On connection it sends its inventory, and after that
exactly one state for each message. A force holds until the next message, and for `idle_after` at most. `Script` lets
the service fail as real ones do.
"""

from __future__ import annotations

import json
import threading
import time
from collections import deque
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from palpate import _core
from palpate.arrays import Array
from palpate.devices.haply.messages import (
    DIALECTS,
    Config,
    Grip,
    Json,
    State,
    by_id,
    device_entry,
    event,
    force_of,
    grip_entry,
)
from palpate.devices.haply.wire import Connection, Port
from palpate.devices.simulated import SimulatedDevice, Truth
from palpate.errors import DeviceError

PORT, EVENTS = 10001, 10020
MIDDLE = np.array([0.0, -0.12, 0.15])
"""Middle of the workspace in the axes of the base: x right, y away from the user, z up [m]."""
STROKE, PERIOD = 0.13, 8.0
"""The simulated hand moves down and up by this length [m] in this time [s]."""
FAULTS = {
    "late": "each answer comes VALUE seconds late (0.02)",
    "hang": "the service reads and answers nothing",
    "disconnect": "all connections break, without a word",
    "malformed": "answers are no valid JSON, or have values of another kind",
    "sleep": "the grip falls asleep: its orientation stands still",
    "battery": "the battery of the grip is nearly empty",
    "ebrake": "the emergency brake locks the device: forces have no effect",
    "stall": "the service reports a stalled motor",
    "unplug": "the device vanishes from the messages",
    "uncalibrated": "the device says that it is not calibrated, and its positions are mirrored",
    "duplicate": "the grip is named twice, as a Ruko grip is",
}
"""What `Script` can do, in words."""
_SAFETY = {
    "ebrake": ("ebrake_triggered", "error", "emergency brake engaged"),
    "stall": ("stall_detected", "warning", "motor stall detected"),
}
_LOG = 200_000  # forces that are kept
_TRIES = 10  # to find two free ports


@dataclass(frozen=True)
class Fault:
    """Something that goes wrong from a time on, for a time."""

    name: str
    value: float = 0.0
    start: float = 0.0
    """Time after the start of the service [s]."""
    length: float = float("inf")
    """How long it lasts [s]."""

    @classmethod
    def parse(cls, text: str) -> Fault:
        """``hang``, ``late=0.02``, ``hang@5`` (from 5 s on), ``sleep@5+2`` (for 2 s).

        Raises:
            DeviceError: there is no such fault, or a number cannot be read.
        """
        head, _, when = text.partition("@")
        name, _, value = head.partition("=")
        start, _, length = when.partition("+")
        if name not in FAULTS:
            raise DeviceError(f"there is no fault {name!r}", mend=f"one of {', '.join(FAULTS)}, e.g. hang@5+2")
        try:
            return cls(name, float(value or 0.02), float(start or 0.0), float(length or "inf"))
        except ValueError:
            raise DeviceError(f"fault {text!r} cannot be read", mend="write NAME[=VALUE][@SECONDS[+SECONDS]]") from None


@dataclass
class Options:
    """What the stand-in is like."""

    dialect: str = "3.5"
    """Version of the service: 3.0, 3.1, 3.4 or 3.5."""
    id: str = "04C3"
    minverse: bool = False
    handedness: str = "right"
    held: bool = True
    """True: a simulated hand moves the device down and up by 130 mm; False: the commanded force alone moves it."""
    mass: float = 0.2
    """Moving mass of the device [kg]."""
    idle_after: float = 0.02
    """Time without a message after which the motors are idle [s]; the vendor does not publish its own."""
    grip: Grip | None = field(default_factory=Grip)
    faults: tuple[Fault, ...] = ()


class StandIn:
    """The service. ``with StandIn(port=0) as service:`` starts it on a free port.

    Args:
        port: port of HTTP and of the WebSocket; 0: a free one. The events are 19 ports above, as the service has them.
        options: what it is like.

    Raises:
        DeviceError: there is no such dialect.
    """

    def __init__(self, port: int = PORT, options: Options | None = None) -> None:
        self.options = options or Options()
        if self.options.dialect not in DIALECTS:
            what = f"there is no dialect {self.options.dialect!r}"
            raise DeviceError(what, mend=f"one of {', '.join(DIALECTS)}: the versions that differ")
        self.port = port
        self.events_port = 0
        self.config = Config(handedness=self.options.handedness)
        self.grip = self.options.grip
        self.log: deque[tuple[float, Array]] = deque(maxlen=_LOG)
        """Each commanded force (3,) [N] with its time on the monotonic clock."""
        self.received: deque[bytes] = deque(maxlen=1000)  #: newest messages of clients
        self.exchanges = 0  #: number of answers so far
        self.ignored: set[str] = set()  #: keys of commands that this version does not know
        self._device = SimulatedDevice("" if self.options.held else "free", Truth(mass=self.options.mass, delay=0))
        self._device.stroke, self._device.period = STROKE, PERIOD
        self._force, self._commanded, self._moved = np.zeros(3), 0.0, 0.0
        self._idle = True  # the last message commanded no force
        self._sessions, self._lock = 0, threading.RLock()
        self._faults = {fault.name: fault for fault in self.options.faults}
        self._active: set[str] = set()
        self._began, self._running = 0.0, False
        self._ports: list[Port] = []

    def __enter__(self) -> StandIn:
        """Start."""
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop."""
        self.stop()

    def start(self) -> None:
        """Listen on both ports.

        Raises:
            DeviceError: a port is taken.
        """
        self._began = self._moved = time.monotonic()
        self._running = True
        for attempt in range(_TRIES if self.port == 0 else 1):
            try:
                self._ports.append(Port("127.0.0.1", self.port, self._http, self._simulation))
                events = self._ports[0].number + EVENTS - PORT
                self._ports.append(Port("127.0.0.1", events, _no_http, self._listener))
                break
            except (DeviceError, OverflowError):
                self.stop()
                self._running = True
                if attempt == (_TRIES if self.port == 0 else 1) - 1:
                    raise
        self.port, self.events_port = (port.number for port in self._ports)
        threading.Thread(target=self._follow_script, daemon=True).start()

    def stop(self) -> None:
        """Break all connections and free the ports."""
        self._running = False
        for port in self._ports:
            port.close()
        self._ports = []

    # -- what a script or a test does ----------------------------------------------------------------------------------

    def fail(self, name: str, value: float = 0.02, seconds: float = float("inf")) -> None:
        """Let a fault of `FAULTS` begin now."""
        with self._lock:
            self._faults[name] = Fault(name, value, time.monotonic() - self._began, seconds)
        self._script_step()

    def mend(self, name: str) -> None:
        """End a fault."""
        with self._lock:
            self._faults.pop(name, None)
        self._script_step()

    def force(self, t: float | None = None) -> Array:
        """Force (3,) on the motors at a time on the monotonic clock, now when left out [N]."""
        t = time.monotonic() if t is None else t
        with self._lock:
            last = next(((at, F) for at, F in reversed(self.log) if at <= t), None)
            if last is None or t - last[0] > self.options.idle_after or self.fails("ebrake"):
                return np.zeros(3)
            return last[1].copy()

    def fails(self, name: str) -> bool:
        """True while a fault lasts."""
        fault = self._faults.get(name)
        return fault is not None and 0.0 <= time.monotonic() - self._began - fault.start < fault.length

    def say(self, found: Json) -> None:
        """Send an event to all who listen on the port of the events."""
        for connection in list(self._ports[1].connections) if len(self._ports) > 1 else []:
            try:
                connection.send(json.dumps(found))
            except OSError:  # that listener has gone
                continue

    # -- the two WebSocket channels ------------------------------------------------------------------------------------

    def _simulation(self, connection: Connection) -> None:
        _core.schedule(True)  # as a service of the system: other programs delay its answers less
        with self._lock:
            self._sessions += 1
            session = self._sessions
        deprecated = False
        connection.send(json.dumps(self._message(session, full=True)))
        while self._running and connection.open:
            for text in connection.messages():
                if not self._wait_out_faults():
                    return
                with self._lock:
                    self.received.append(text)
                    full, old = self._take(text)
                    answer = json.dumps(self._message(session, full))
                if old and not deprecated:
                    deprecated = True
                    words = "set_cursor_force.values is deprecated: use vector"
                    self.say(event("command-deprecated", "notice", words, "input", command="set_cursor_force"))
                self.exchanges += 1
                connection.send(*self._spoiled(answer) if self.fails("malformed") else (answer,))

    def _listener(self, connection: Connection) -> None:
        while self._running and connection.open:
            for text in connection.messages():
                data = text.decode(errors="replace")[:200]
                words = "this channel takes no messages"
                self.say(event("invalid-io-channel", "warning", words, "input", received_data=data))

    def _wait_out_faults(self) -> bool:
        """Wait while the service hangs or is late; False if it was stopped meanwhile."""
        while self.fails("hang") and self._running:
            time.sleep(0.001)
        if self.fails("late"):
            time.sleep(self._faults["late"].value)
        return self._running

    def _spoiled(self, answer: str) -> tuple[str | bytes, bool] | tuple[str]:
        """An answer with a mistake; each call has the next one."""
        half = answer[: len(answer) // 2]
        found: list[tuple[str | bytes, bool] | tuple[str]] = [
            (half,), ("",), ("[1, 2",), (answer.replace('"x"', '"u"'),), (answer.replace('{"x"', '["x"'),),
            (answer.encode() + b"\xff", True), ('{"inverse3": 3}',), (answer.replace("0.", "NaN, 0."),),
            ("[" * 10_000,), ('{"inverse3": [{"device_id": 7, "state": "idle"}]}',),
        ]  # fmt: skip
        return found[self.exchanges % len(found)]

    # -- commands ------------------------------------------------------------------------------------------------------

    def _take(self, text: bytes) -> tuple[bool, bool]:
        """Carry out a message; returns whether the full state is wanted, and whether its form is deprecated."""
        try:
            message = json.loads(text)
        except ValueError:
            message = None
        if not isinstance(message, dict):
            self._invalid("message", "not a JSON object", text.decode(errors="replace")[:80])
            return False, False
        session = message.get("session")
        full = isinstance(session, dict) and "force_render_full_state" in session
        force: Array | None = None
        old = False
        for entry in _entries(message.get("inverse3")):
            if entry.get("device_id") != self.options.id:
                continue
            self._configure(entry.get("configure"))
            commands = entry.get("commands")
            for name, command in commands.items() if isinstance(commands, dict) else ():
                if name == "set_cursor_force" and isinstance(command, dict):
                    found, old, reason = force_of(command, self.options.dialect)
                    if reason:
                        self._invalid("set_cursor_force", reason, "")
                    force = found
                elif name != "probe_position":
                    self.ignored.add(name)
        self._move(force)
        return full, old

    def _configure(self, given: Any) -> None:
        """One-shot settings in a message, as service 3.5 takes them; unknown ones are ignored in silence."""
        if not isinstance(given, dict) or self.options.dialect != "3.5":
            return
        for name, value in given.items():
            self._set(f"filters/{name}" if name in ("damping", "force_gate") else name, value)

    def _move(self, force: Array | None) -> None:
        """Let the last force act until now, and command a new one; None: the message commands no force."""
        self._catch_up()
        now = time.monotonic()
        self._idle = force is None
        self._force, self._commanded = np.zeros(3) if force is None else force, now
        self.log.append((now, self._force))

    def _catch_up(self) -> None:
        now = time.monotonic()
        ends = min(now, self._commanded + self.options.idle_after)
        idle = self.fails("ebrake")
        if ends > self._moved:
            self._device.advance(np.zeros(3) if idle else self._force, ends - self._moved)
        if now > max(ends, self._moved):
            self._device.advance(np.zeros(3), min(now - max(ends, self._moved), 1.0))
        self._moved = now

    def _invalid(self, name: str, reason: str, context: str) -> None:
        self.say(event("invalid-value", "warning", reason, "input", field=name, reason=reason, context=context))

    # -- answers -------------------------------------------------------------------------------------------------------

    def _message(self, session: int, full: bool) -> Json:
        """The state of all devices; with their configuration in the inventory and when it was asked for."""
        with self._lock:
            self._catch_up()
            lists: Json = {
                "inverse3": [] if self.fails("unplug") else [self._device_entry(full)],
                "verse_grip": [], "wireless_verse_grip": [], "custom_verse_grip": [],
            }  # fmt: skip
            for kind in self._grip_lists():
                assert self.grip is not None
                lists[kind].append(grip_entry(self.grip, kind, full, self.options.dialect))
        if self.options.dialect == "3.0":
            lists = {kind: by_id(entries) for kind, entries in lists.items()}
        out: Json = {"session_id": session, **lists}
        if full and self.options.dialect == "3.5":
            out["session"] = {"session_id": session, "config": {"profile": {"name": "default"}}}
        return out

    def _grip_lists(self) -> list[str]:
        if self.grip is None:
            return []
        doubled = self.grip.doubled or self.fails("duplicate")
        return ["wireless_verse_grip", "custom_verse_grip"] if doubled else [self.grip.kind]

    def _device_entry(self, full: bool) -> Json:
        p, v = MIDDLE + self._device.position, self._device.velocity
        p[2] += 0.5 * STROKE if self.options.held else 0.0  # the hand moves down from the start
        wrong = self.fails("uncalibrated")
        if wrong:
            p, v = p * [-1.0, 1.0, 1.0], v * [-1.0, 1.0, 1.0]
        silent = time.monotonic() - self._commanded > self.options.idle_after
        commanded = not (self._idle or silent or self.fails("ebrake"))
        force = self._force if commanded else np.zeros(3)
        state = State(p, v, force, "position" if commanded else "idle", not wrong, not self.fails("ebrake"), commanded)
        config = self.config if full else None
        return device_entry(self.options.id, self.options.minverse, config, state, self.options.dialect)

    # -- HTTP ----------------------------------------------------------------------------------------------------------

    def _http(self, method: str, path: str, body: Any) -> tuple[int, Any]:
        """Answer a request; the version may stand in front of the path, as clients of 3.0 and 3.1 write it."""
        parts = [part for part in path.partition("?")[0].split("/") if part]
        if parts and parts[0] in DIALECTS:
            parts = parts[1:]
        if method == "GET" and parts == ["version"]:
            return 200, self._version()
        if method == "GET" and parts == ["devices"]:
            return 200, self._message(0, full=True)
        if len(parts) >= 4 and parts[1] == self.options.id and parts[2] == "config":
            return self._setting(method, "/".join(parts[3:]), body)
        return 404, {"ok": False, "error": f"{method} {path} is not known"}

    def _version(self) -> Json:
        number = self.options.dialect
        return {
            "build_time": "2026-01-01T00:00:00Z", "git_branch": "stand-in", "git_describe": f"{number}.0",
            "git_hash": "0000000", "git_tag": f"{number}.0", "project_name": "haply-inverse-service",
            "project_version": f"{number}.0.0",
        }  # fmt: skip

    def _setting(self, method: str, key: str, body: Any) -> tuple[int, Any]:
        with self._lock:
            if self._get(key) is None:
                return 404, {"ok": False, "error": f"there is no setting {key}"}
            if method in ("POST", "PATCH") and not self._set(key, body):
                return 400, {"ok": False, "error": f"{body!r} is no value of {key}"}
            if method == "DELETE":
                self._set(key, _setting_of(Config(), key))
            return 200, {"ok": True, "data": self._get(key)}

    def _get(self, key: str) -> Any:
        if self.options.dialect != "3.5" and key not in ("gravity_compensation", "handedness", "basis"):
            return None
        return _setting_of(self.config, key)

    def _set(self, key: str, value: Any) -> bool:
        """Change a setting; False if the value is of another kind."""
        now = _setting_of(self.config, key)
        if now is None or type(now) is not type(value):
            return False
        if isinstance(now, dict):
            value = {**now, **value}
        if key == "gravity_compensation":
            self.config.gravity = value
        elif key == "handedness" and value in ("left", "right"):
            self.config.handedness = value
        elif key == "basis":
            self.config.basis = str(value["permutation"])
        elif key == "preset":
            self.config.preset = str(value["preset"])
        elif key == "filters/damping":
            self.config.damping = float(value["scalar"])
        elif key == "filters/force_gate":
            self.config.force_gate = float(value["gain"])
        elif key == "mount":
            self.config.mount = value
        else:
            return False
        return True

    # -- the script ----------------------------------------------------------------------------------------------------

    def _follow_script(self) -> None:
        while self._running:
            self._script_step()
            time.sleep(0.005)

    def _script_step(self) -> None:
        """Do what begins or ends with a fault: events, broken connections, the sleep of the grip."""
        with self._lock:
            now = {name for name in list(self._faults) if self.fails(name)}
            began, ended, self._active = now - self._active, self._active - now, now
        for name in sorted(began):
            self._begin(name)
        for name in sorted(ended):
            self._end(name)

    def _begin(self, name: str) -> None:
        family = {"device_family": "inverse", "device_id": self.options.id}
        if name == "disconnect":
            for port in self._ports:
                for connection in list(port.connections):
                    connection.drop()
        elif name == "unplug":
            self.say(event("device-disconnected", "warning", "device lost", **family))
        elif name in _SAFETY:
            kind, level, words = _SAFETY[name]
            self.say(event("device-safety-triggered", level, words, **family, safety_type=kind))
        elif name in ("sleep", "battery") and self.grip is not None:
            family = {"device_family": self.grip.kind, "device_id": self.grip.id}
            if name == "sleep":
                self.grip.awake = False
                self.say(event("device-sleep", "info", "grip asleep", **family))
            else:
                self.grip.battery = 0.05
                self.say(event("device-battery-low", "warning", "battery at 5 %", **family))

    def _end(self, name: str) -> None:
        family = {"device_family": "inverse", "device_id": self.options.id}
        if name == "unplug":
            self.say(event("device-connected", "info", "device found", **family))
        elif name == "ebrake":
            words = "emergency brake released"
            self.say(event("device-safety-triggered", "notice", words, **family, safety_type="ebrake_released"))
        elif name == "sleep" and self.grip is not None:
            self.grip.awake = True


def _no_http(method: str, path: str, body: Any) -> tuple[int, Any]:
    return 404, {"ok": False, "error": "this port has events alone"}


def _entries(given: Any) -> list[Json]:
    return [entry for entry in given if isinstance(entry, dict)] if isinstance(given, list) else []


def _setting_of(config: Config, key: str) -> Any:
    """The value of a setting by its path; None if there is no such setting."""
    return {
        "gravity_compensation": config.gravity,
        "handedness": config.handedness,
        "basis": {"permutation": config.basis},
        "preset": {"preset": config.preset},
        "filters/damping": {"scalar": config.damping},
        "filters/force_gate": {"gain": config.force_gate},
        "mount": config.mount,
    }.get(key)
