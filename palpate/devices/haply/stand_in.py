"""A stand-in of Haply's Inverse Service: a simulated device behind the vendor's messages, for tests and for trying out.

Written from the vendor's documentation of its service 3.0 to 3.5. On connection it sends its inventory, and after that
exactly one state for each message. A force holds until the next message, and for `idle_after` at most. A script
(`stand_faults`) lets the service fail as real ones do.
"""

from __future__ import annotations

import json
import threading
import time
from collections import deque
from dataclasses import dataclass, field, replace
from typing import Any

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.errors import DeviceError
from palpate.devices.haply.messages import (
    DIALECTS,
    Config,
    Grip,
    Json,
    by_id,
    device_entry,
    event,
    force_of,
    grip_entry,
)
from palpate.devices.haply.stand_device import MIDDLE, StandDevice
from palpate.devices.haply.stand_faults import FAULTS, Fault, LateAnswers
from palpate.devices.haply.stand_settings import request_setting, set_setting, version
from palpate.devices.haply.wire import Connection, Port

__all__ = ["FAULTS", "MIDDLE", "Fault", "Options", "StandIn"]

PORT, EVENTS = 10001, 10020
_SAFETY = {
    "ebrake": ("ebrake_triggered", "error", "emergency brake engaged"),
    "stall": ("stall_detected", "warning", "motor stall detected"),
}
_LAST = 65535  # port
_TRIES = 10  # to find two free ports


@dataclass
class Options:
    """What the stand-in is like."""

    dialect: str = "3.5"
    """Version of the service: 3.0, 3.1, 3.4 or 3.5."""
    id: str = "04C3"
    more: tuple[str, ...] = ()
    """Ids of further devices, for the other hand in turns, each with a grip of its own."""
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
        if not 0 <= port <= _LAST - (EVENTS - PORT):
            what = f"port {port} leaves none for the events, {EVENTS - PORT} above"
            raise DeviceError(what, mend=f"give one up to {_LAST - (EVENTS - PORT)}")
        for fault in self.options.faults:
            if fault.device not in ("", self.options.id, *self.options.more):
                what = f"fault {fault.name}: there is no device {fault.device!r}"
                raise DeviceError(what, mend=f"one of {', '.join((self.options.id, *self.options.more))}")
        self.port = port
        self.events_port = 0
        self.devices = self._made()  #: the devices by their ids
        self.received: deque[bytes] = deque(maxlen=1000)  #: newest messages of clients
        self.exchanges = 0  #: number of answers so far
        self.ignored: set[str] = set()  #: keys of commands that this version does not know
        self._sessions, self._lock = 0, threading.RLock()
        self._led_by: dict[str, int] = {}  # session that commands each device
        self._faults = {fault.name: fault for fault in self.options.faults}
        self._active: set[str] = set()
        self._only: dict[str, str] = {}  # id of the only device that a past fault concerned
        self._began, self._running = 0.0, False
        self._ports: list[Port] = []

    def _made(self) -> dict[str, StandDevice]:
        o, found = self.options, {}
        for i, id in enumerate((o.id, *o.more)):
            grip = o.grip if o.grip is None or i == 0 else replace(o.grip, id=str(int(o.grip.id) + i))
            other = {"left": "right", "right": "left"}[o.handedness]
            hand = o.handedness if i % 2 == 0 else other
            found[id] = StandDevice(id, grip, hand, o.held, o.mass, o.idle_after)
        return found

    @property
    def first(self) -> StandDevice:
        """The first device."""
        return self.devices[self.options.id]

    @property
    def config(self) -> Config:
        """Settings of the first device."""
        return self.first.config

    @property
    def log(self) -> deque[tuple[float, Array]]:
        """Each force (3,) [N] commanded to the first device, with its time on the monotonic clock."""
        return self.first.log

    @property
    def grip(self) -> Grip | None:
        """The grip on the first device."""
        return self.first.grip

    @grip.setter
    def grip(self, value: Grip | None) -> None:
        self.first.grip = value

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
        self._began = time.monotonic()
        for device in self.devices.values():
            device.start()
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

    def fail(self, name: str, value: float = 0.02, seconds: float = float("inf"), device: str = "") -> float:
        """Let a fault of `FAULTS` begin now, of one device or, with an empty id, of all.

        Returns:
            When it began, on the monotonic clock [s].
        """
        with self._lock:
            begin = time.monotonic()
            self._faults[name] = Fault(name, value, begin - self._began, seconds, device)
            self._script_step()  # under the lock: the thread of the script, which may be late, does not take it over
        return begin

    def mend(self, name: str) -> None:
        """End a fault."""
        with self._lock:
            self._faults.pop(name, None)
        self._script_step()

    def force(self, t: float | None = None, id: str = "") -> Array:
        """Force (3,) on the motors of a device, the first when left out, at a time on the monotonic clock [N]."""
        with self._lock:
            device = self.devices[id or self.options.id]
            return device.force(time.monotonic() if t is None else t, self.fails("ebrake", device.id))

    def fails(self, name: str, device: str = "") -> bool:
        """True while a fault lasts, of the service or of a device."""
        fault = self._faults.get(name)
        if fault is None or (device and fault.device not in ("", device)):
            return False
        return 0.0 <= time.monotonic() - self._began - fault.start < fault.length

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
        try:
            self._exchange(connection, session)
        finally:
            with self._lock:
                self._led_by = {id: leader for id, leader in self._led_by.items() if leader != session}

    def _exchange(self, connection: Connection, session: int) -> None:
        """Send the inventory, then one answer for each message."""
        deprecated, late = False, LateAnswers(connection.send)
        connection.send(json.dumps(self._message(session, full=True)))
        while self._running and connection.open:
            for text in connection.messages():
                if not self._wait_out_faults():
                    return
                with self._lock:
                    self.received.append(text)
                    full, old = self._take(text, session)
                    answer = json.dumps(self._message(session, full))
                if old and not deprecated:
                    deprecated = True
                    words = "set_cursor_force.values is deprecated: use vector"
                    self.say(event("command-deprecated", "notice", words, "input", command="set_cursor_force"))
                self.exchanges += 1
                after = self._faults["late"].value if self.fails("late") else 0.0
                late.send(after, *self._spoiled(answer) if self.fails("malformed") else (answer,))

    def _listener(self, connection: Connection) -> None:
        while self._running and connection.open:
            for text in connection.messages():
                data = text.decode(errors="replace")[:200]
                words = "this channel takes no messages"
                self.say(event("invalid-io-channel", "warning", words, "input", received_data=data))

    def _wait_out_faults(self) -> bool:
        """Wait while the service hangs or is slow; False if it was stopped meanwhile."""
        while self.fails("hang") and self._running:
            time.sleep(0.001)
        if self.fails("slow"):
            time.sleep(self._faults["slow"].value)
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

    def _take(self, text: bytes, session_id: int) -> tuple[bool, bool]:
        """Carry out a message of a session; whether the full state is wanted, and whether its form is deprecated."""
        try:
            message = json.loads(text)
        except ValueError:
            message = None
        if not isinstance(message, dict):
            self._invalid("message", "not a JSON object", text.decode(errors="replace")[:80])
            return False, False
        session = message.get("session")
        full = isinstance(session, dict) and "force_render_full_state" in session
        forces: dict[str, Array | None] = dict.fromkeys(self.devices)
        old = False
        for entry in _entries(message.get("inverse3")):
            device = self.devices.get(str(entry.get("device_id")))
            if device is None:
                continue
            self._configure(device, entry.get("configure"))
            commands = entry.get("commands")
            for name, command in commands.items() if isinstance(commands, dict) else ():
                if name == "set_cursor_force" and isinstance(command, dict):
                    found, old, reason = force_of(command, self.options.dialect)
                    if reason:
                        self._invalid("set_cursor_force", reason, "")
                    forces[device.id] = found
                elif name != "probe_position":
                    self.ignored.add(name)
        for id, force in forces.items():  # a device that a session does not command belongs to the one that does
            if force is not None or self._led_by.get(id, session_id) == session_id:
                self._led_by[id] = session_id
                self.devices[id].command(force, self.fails("ebrake", id))
        return full, old

    def _configure(self, device: StandDevice, given: Any) -> None:
        """One-shot settings in a message, as service 3.5 takes them; unknown ones are ignored in silence."""
        if not isinstance(given, dict) or self.options.dialect != "3.5":
            return
        for name, value in given.items():
            set_setting(device.config, f"filters/{name}" if name in ("damping", "force_gate") else name, value)

    def _invalid(self, name: str, reason: str, context: str) -> None:
        self.say(event("invalid-value", "warning", reason, "input", field=name, reason=reason, context=context))

    # -- answers -------------------------------------------------------------------------------------------------------

    def _message(self, session: int, full: bool) -> Json:
        """The state of all devices; with their configuration in the inventory and when it was asked for."""
        with self._lock:
            present = [device for device in self.devices.values() if not self.fails("unplug", device.id)]
            lists: Json = {
                "inverse3": [self._device_entry(device, full) for device in present],
                "verse_grip": [], "wireless_verse_grip": [], "custom_verse_grip": [],
            }  # fmt: skip
            for grip in [device.grip for device in self.devices.values() if device.grip is not None]:
                for kind in self._lists_of(grip):
                    lists[kind].append(grip_entry(grip, kind, full, self.options.dialect))
        if self.options.dialect == "3.0":
            lists = {kind: by_id(entries) for kind, entries in lists.items()}
        out: Json = {"session_id": session, **lists}
        if full and self.options.dialect == "3.5":
            out["session"] = {"session_id": session, "config": {"profile": {"name": "default"}}}
        return out

    def _lists_of(self, grip: Grip) -> list[str]:
        doubled = grip.doubled or self.fails("duplicate")
        return ["wireless_verse_grip", "custom_verse_grip"] if doubled else [grip.kind]

    def _device_entry(self, device: StandDevice, full: bool) -> Json:
        braked = self.fails("ebrake", device.id)
        device.catch_up(braked)
        state = device.state(braked, self.fails("uncalibrated", device.id))
        config = device.config if full else None
        return device_entry(device.id, self.options.minverse, config, state, self.options.dialect)

    # -- HTTP ----------------------------------------------------------------------------------------------------------

    def _http(self, method: str, path: str, body: Any) -> tuple[int, Any]:
        """Answer a request; the version may stand in front of the path, as clients of 3.0 and 3.1 write it."""
        parts = [part for part in path.partition("?")[0].split("/") if part]
        if parts and parts[0] in DIALECTS:
            parts = parts[1:]
        if method == "GET" and parts == ["version"]:
            return 200, version(self.options.dialect)
        if method == "GET" and parts == ["devices"]:
            return 200, self._message(0, full=True)
        if len(parts) >= 4 and parts[1] in self.devices and parts[2] == "config":
            config = self.devices[parts[1]].config
            with self._lock:
                return request_setting(config, self.options.dialect, method, "/".join(parts[3:]), body)
        return 404, {"ok": False, "error": f"{method} {path} is not known"}

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
            concerned = {name: self._concerned(name) for name in began | ended}
        if "disconnect" in began:
            for port in self._ports:
                for connection in list(port.connections):
                    connection.drop()
        for names, act in ((began, self._begin), (ended, self._end)):
            for name in sorted(names):
                for device in concerned[name]:
                    act(name, device)

    def _concerned(self, name: str) -> list[StandDevice]:
        """The devices that a fault concerns, or has concerned."""
        only = self._faults[name].device if name in self._faults else self._only.get(name, "")
        self._only[name] = only
        return [device for id, device in self.devices.items() if only in ("", id)]

    def _begin(self, name: str, device: StandDevice) -> None:
        family, grip = {"device_family": "inverse", "device_id": device.id}, device.grip
        if name == "unplug":
            self.say(event("device-disconnected", "warning", "device lost", **family))
        elif name in _SAFETY:
            kind, level, words = _SAFETY[name]
            self.say(event("device-safety-triggered", level, words, **family, safety_type=kind))
        elif name in ("sleep", "battery") and grip is not None:
            family = {"device_family": grip.kind, "device_id": grip.id}
            if name == "sleep":
                grip.awake = False
                self.say(event("device-sleep", "info", "grip asleep", **family))
            else:
                grip.battery = 0.05
                self.say(event("device-battery-low", "warning", "battery at 5 %", **family))

    def _end(self, name: str, device: StandDevice) -> None:
        family = {"device_family": "inverse", "device_id": device.id}
        if name == "unplug":
            self.say(event("device-connected", "info", "device found", **family))
        elif name == "ebrake":
            words = "emergency brake released"
            self.say(event("device-safety-triggered", "notice", words, **family, safety_type="ebrake_released"))
        elif name == "sleep" and device.grip is not None:
            device.grip.awake = True


def _no_http(method: str, path: str, body: Any) -> tuple[int, Any]:
    return 404, {"ok": False, "error": "this port has events alone"}


def _entries(given: Any) -> list[Json]:
    return [entry for entry in given if isinstance(entry, dict)] if isinstance(given, list) else []
