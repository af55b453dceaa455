"""The driver of Haply devices: finds the device, checks and sets it, and hands it to a thread of the core."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import DeviceError
from palpate.devices.driver import MOST_RATE, Driver, Reading
from palpate.devices.haply.service import (
    EVENTS_ABOVE,
    Address,
    Json,
    compiled,
    entries,
    grip_of,
    id_of,
    part,
    receive,
    request,
    truth,
    version,
    websocket,
)
from palpate.scene.haply import HaplySection

if TYPE_CHECKING:
    from palpate import _haply

_EDGE = {"inverse3": 0.115, "minverse": 0.046}  # of the largest cube in the safe sphere of 0.10 or 0.04 m [m]
_WAIT = 1.0  # longest time without a measurement, outside a session [s]


@dataclass(frozen=True)
class Found:
    """A device that the service has named, checked and set."""

    id: str
    address: str
    """Its id as JSON, as the service wrote it: a text or a number."""
    minverse: bool
    handedness: str
    grip: str
    """Id of its grip; "" without one."""
    list: str
    """The list of the messages in which the grip is."""
    settings: Json
    """What the service says of gravity compensation and filters, after they were set."""


class Haply(Driver):
    """An Inverse3 or Minverse of Haply, with or without a VerseGrip (``haply``), by the vendor's Inverse Service.

    Its base has x to the right, y away from the user and z up. Button a is the clutch, button b closes the gripper.
    """

    rate, force_max, workspace = MOST_RATE, 3.0, (0.115, 0.115, 0.115)

    def __init__(self, argument: str = "") -> None:
        self.options = HaplySection.from_text(argument)
        self.force_max, self.rate = self.options.force_max, min(self.options.rate, MOST_RATE)
        self.found: Found | None = None
        self._device: _haply.Device | None = None
        self._X = np.eye(4)

    @classmethod
    def missing(cls) -> str:
        """Empty if the service answers at its usual place."""
        at = Address()
        return "" if at.answers() else f"Haply's Inverse Service (nothing listens on {at})"

    @property
    def hardware(self) -> tuple[str, ...]:
        """The device and its grip, by their ids; after `native`."""
        assert self.found is not None
        grip = (f"the grip {self.found.grip} of Haply",) if self.found.grip else ()
        return (f"the Haply device {self.found.id}", *grip)

    def native(self) -> _haply.Device:
        """The opened device, for a thread of the core.

        Raises:
            DeviceError: the service or the device is missing, not calibrated, or cannot be set as wanted.
        """
        core = compiled()
        at = Address.parse(self.options.url)
        dialect = version(at)
        service = websocket(at)
        self.found = found = _prepare(service, at, self.options, dialect)
        device: _haply.Device = core.Device(
            service, _events(at), device=found.id, address=found.address, grip=found.grip, list=found.list,
            vector=dialect >= (3, 5), rate=self.options.rate, force_max=self.options.force_max,
            workspace=_EDGE["minverse" if found.minverse else "inverse3"],
        )  # fmt: skip
        return device

    def open(self) -> None:
        """Connect, for measurements outside a session."""
        self._device = self.native()
        self.workspace = self._device.workspace

    def read(self) -> Reading:
        """Pose, gripper and clutch; waits while there is no measurement."""
        assert self._device is not None
        end = time.monotonic() + _WAIT
        while time.monotonic() < end:
            told = self._device.read(self._X)
            if told is not None:
                return Reading(self._X.copy(), None, told[1], told[0])
            self._device.write(np.zeros(6))
            time.sleep(0.0005)
        notices = "; ".join(self._device.notices)
        raise DeviceError("the device gives no measurement", why=notices, mend="see `palpate device list`")

    def write(self, wrench: Array) -> None:
        """Command the force."""
        if self._device is not None:
            self._device.write(np.ascontiguousarray(wrench, dtype=np.float64))

    def close(self) -> None:
        """Command zero force and close the connection."""
        self._device = None


def _events(at: Address) -> _haply.Connection | None:
    """The channel of events; None where there is none: status and silence are noticed without it."""
    try:
        return websocket(Address(at.host, at.port + EVENTS_ABOVE))
    except DeviceError:
        return None


def _prepare(service: _haply.Connection, at: Address, options: HaplySection, dialect: tuple[int, int]) -> Found:
    """Choose the device, set it, read its settings back, and check that its numbers mean what we think."""
    device = _chosen(receive(service, at), options.id, at)
    id, minverse = id_of(device), _is_minverse(device)
    if options.gravity is not None:
        _set_gravity(at, id, options.gravity)
    first: Json = {"session": {"force_render_full_state": {}}}
    entry: Json = {"device_id": device["device_id"], "commands": {"probe_position": {}}}
    if dialect >= (3, 5):
        first["session"]["configure"] = {"profile": {"name": "palpate"}}
        entry["configure"] = {"basis": {"permutation": "XYZ"}, "damping": {"scalar": options.damping}}
        if options.force_gate is not None:
            entry["configure"]["force_gate"] = {"gain": options.force_gate}
    service.send(json.dumps({**first, "inverse3": [entry]}))
    message = receive(service, at)
    device = _chosen(message, id, at)
    config = part(device, "config")
    _check(id, device, config, options)
    grip, where = grip_of(message, options.grip, at)
    settings: Json = {key: config[key] for key in ("gravity_compensation", "filters") if key in config}
    return Found(
        id, json.dumps(device["device_id"]), minverse, str(config.get("handedness", "")), grip, where, settings
    )


def _chosen(message: Json, wanted: str | None, at: Address) -> Json:
    devices = entries(message, "inverse3")
    ids = [id_of(device) for device in devices]
    if not ids:
        mend = "connect it and switch it on; start the service first, then the device"
        raise DeviceError(f"the service on {at} knows no Inverse3 or Minverse", mend=mend)
    if wanted is None:
        if len(ids) > 1:
            what = f"the service on {at} knows {len(ids)} devices"
            raise DeviceError(what, mend=f"name one: driver: {{haply: {{id: {ids[0]}}}}} ({', '.join(ids)})")
        return devices[0]
    if wanted not in ids:
        raise DeviceError(f"the service on {at} knows no device {wanted!r}", mend=f"one of {', '.join(ids)}")
    return devices[ids.index(wanted)]


def _is_minverse(device: Json) -> bool:
    config = part(device, "config")
    info = part(config, "device_info")
    return "minverse" in (config.get("type"), info.get("device_type")) or 6 in (
        info.get("device_type"),
        info.get("model"),
    )


def _set_gravity(at: Address, id: str, gravity: float) -> None:
    """Set the gravity compensation, and read it back.

    Raises:
        DeviceError: the service does not take it.
    """
    wanted = {"enabled": gravity > 0.0, "scaling_factor": gravity}
    path = f"inverse3/{id}/config/gravity_compensation"
    mend = "set it in Haply Hub, and leave it alone here: haply: {gravity: null}, or haply:gravity=none"
    try:
        request(at, "POST", path, wanted)
        told = request(at, "GET", path)
    except DeviceError as error:
        raise DeviceError(f"gravity compensation cannot be set: {error.what}", why=error.why, mend=mend) from None
    if not _same(told, wanted):
        what = f"gravity compensation is {told} after it was set to {wanted}"
        raise DeviceError(what, mend=mend)


def _same(told: Any, wanted: Any) -> bool:
    """True if all numbers that were set came back, within single precision."""
    if isinstance(wanted, dict):
        return isinstance(told, dict) and all(_same(told.get(key), value) for key, value in wanted.items())
    if isinstance(wanted, bool) or isinstance(told, bool):
        return truth(told) is wanted
    if isinstance(wanted, (int, float)) and isinstance(told, (int, float)):
        return abs(told - wanted) <= 1e-5 * max(1.0, abs(wanted))
    return bool(told == wanted)


def _check(id: str, device: Json, config: Json, options: HaplySection) -> None:
    """Refuse a device whose numbers would mean something else.

    Raises:
        DeviceError: it is not calibrated, its axes or its scale are changed, or a filter is not as set.
    """
    if truth(part(device, "status").get("calibrated")) is not True:
        mend = "calibrate it in Haply Hub, with the grip in its inkwell, and start again"
        raise DeviceError(f"device {id} is not calibrated", why="its positions may be mirrored", mend=mend)
    basis = (part(config, "basis") or part(config, "coordinate_system")).get("permutation", "XYZ")
    if basis != "XYZ":
        what, mend = f"device {id} has the axes {basis!r}", "set its basis to XYZ in Haply Hub"
        raise DeviceError(what, why="forces and positions would be turned", mend=mend)
    for name, given in (("mount", part(config, "mount")), ("transform", part(part(device, "state"), "transform"))):
        if not _is_identity(given):
            what, mend = f"device {id} has a {name} of {given}", "reset it in Haply Hub; place the base by leader.base"
            raise DeviceError(what, why="forces and positions would be turned or scaled", mend=mend)
    filters = part(config, "filters")
    wanted: Json = {"damping": {"scalar": options.damping}} if filters else {}
    if options.force_gate is not None:
        wanted["force_gate"] = {"gain": options.force_gate}
    if not _same(filters, wanted):
        mend = "set them in Haply Hub, or leave them out here; services before 3.5 have no filters"
        raise DeviceError(f"the filters of device {id} are {filters} after they were set to {wanted}", mend=mend)


def _is_identity(transform: Json) -> bool:
    unit = {"position": "", "rotation": "w", "scale": "xyz"}
    return all(
        isinstance(value, (int, float)) and abs(value - (1.0 if axis in unit[name] else 0.0)) < 1e-6
        for name in unit
        for axis, value in part(transform, name).items()
    )
