"""The messages of Haply's Inverse Service, as its documentation of 3.0 to 3.5 states them, from the service's side."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from palpate.base.arrays import Array

Json = dict[str, Any]
DIALECTS = ("3.0", "3.1", "3.4", "3.5")
"""Versions of the service that differ in their messages."""
_IDENTITY = {
    "position": {"x": 0.0, "y": 0.0, "z": 0.0},
    "rotation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
    "scale": {"x": 1.0, "y": 1.0, "z": 1.0},
}


@dataclass
class Grip:
    """A handle with its own orientation and buttons, beside the device that carries it."""

    kind: str = "wireless_verse_grip"
    """Its list in the messages: verse_grip, wireless_verse_grip or custom_verse_grip."""
    id: str = "1102"
    orientation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    """x, y, z, w."""
    buttons: dict[str, bool] = field(default_factory=lambda: {"a": False, "b": False, "c": False})
    battery: float = 0.9
    """Charge, 0 to 1 [-]."""
    awake: bool = True
    doubled: bool = False
    """True: it is named in the lists of wireless and of custom grips, as a Ruko grip is."""


@dataclass
class Config:
    """Settings of a device, which clients read and write."""

    gravity: Json = field(default_factory=lambda: {"enabled": True, "scaling_factor": 1.0})
    handedness: str = "right"
    basis: str = "XYZ"
    preset: str = "defaults"
    force_gate: float = 0.3
    damping: float = 0.0
    mount: Json = field(default_factory=dict)
    origin: str = "device_base"


@dataclass
class State:
    """What a device measures, and what it may do."""

    position: Array
    velocity: Array
    force: Array
    mode: str = "idle"
    calibrated: bool = True
    ready: bool = True
    in_use: bool = False


def device_entry(id: str, minverse: bool, config: Config | None, state: State, dialect: str) -> Json:
    """The entry of an Inverse3 or Minverse; with its configuration if that is given."""
    entry: Json = {"device_id": id}
    if config is not None:
        entry["config"] = _device_config(id, minverse, config, dialect)
    entry["state"] = _device_state(state, dialect)
    entry["status"] = {
        "calibrated": state.calibrated,
        "in_use": state.in_use,
        "power_supply": True,
        "ready": state.ready,
        "started": True,
    }
    return entry


def _device_config(id: str, minverse: bool, config: Config, dialect: str) -> Json:
    uuid = f"9AB19C4B5E655E32B4F00F8A59FD{id}"
    kind: int | str = 6 if minverse else 4
    info: Json = {"id": id, "uuid": uuid}
    if dialect in ("3.0", "3.1"):
        info |= {"firmware_version": 1, "hardware_version": 7, "model": kind}
    else:
        name = "minverse" if minverse else "inverse3"
        info |= {"major_version": 7, "minor_version": 4, "device_type": name if dialect == "3.4" else kind}
    out: Json = {
        "type": "minverse" if minverse else "inverse3",
        "device_info": info,
        "port": "/dev/ttyACM0",
        "extended_device_id": uuid,
        "extended_firmware_version": "8C20FDC8010AA1E15AA133CDA2534874",
        "gravity_compensation": dict(config.gravity),
        "handedness": config.handedness,
        "streaming_mode": "USB",
        "torque_scaling": {"enabled": True},
        "cursor_offset": {"x": 0.0, "y": 0.0, "z": 0.0},
        "coordinate_origin": config.origin,
        "coordinate_system" if dialect in ("3.0", "3.1") else "basis": {"permutation": config.basis},
    }
    if dialect == "3.5":
        out |= {
            "preset": config.preset,
            "home_return": {"enabled": False},
            "mount": dict(config.mount),  # parts that are the identity are left out
            "filters": {"force_gate": {"gain": config.force_gate}, "damping": {"scalar": config.damping}},
        }
    return out


def _device_state(state: State, dialect: str) -> Json:
    idle = state.mode == "idle"
    out: Json = {
        "cursor_position": vector(state.position),
        "cursor_velocity": vector(state.velocity),
        "angular_position": {"a0": -89.66, "a1": 122.81, "a2": -22.78},  # [deg]
        "angular_velocity": {"a0": 0.0, "a1": 0.0, "a2": 0.0},
        "body_orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
        "mode": state.mode,
        "control_domain": "undefined" if idle else "cartesian",
        "control_mode": "idle" if idle else "force",
    }
    if dialect == "3.5":
        zero = {"a0": 0.0, "a1": 0.0, "a2": 0.0}
        out |= {
            "current_cursor_force": vector(state.force),
            "current_cursor_position": vector(np.zeros(3)),
            "current_angular_torques": zero,
            "current_angular_position": zero,
            "transform": {},
            "transform_velocity": {},
        }
    elif dialect == "3.4":
        out["transform"] = _IDENTITY
    return out


def grip_entry(grip: Grip, kind: str, with_config: bool, dialect: str) -> Json:
    """The entry of a grip in the list `kind`; a wired grip has one button and no battery."""
    x, y, z, w = grip.orientation
    state: Json = {"orientation": {"x": x, "y": y, "z": z, "w": w}, "hall": 16}
    status: Json = {"ready": True}
    config: Json = {"port": "/dev/ttyACM1", "type": kind}
    if kind == "verse_grip":
        state["button"] = any(grip.buttons.values())
        status["error"] = 0
    else:
        state |= {"battery_level": grip.battery, "battery_voltage": 3.2 + grip.battery, "buttons": dict(grip.buttons)}
        status |= {"connected": True, "awake": grip.awake}
        config |= {"major_version": 2, "minor_version": 2, "hardware_version": 1, "streaming_mode": "Radio"}
    if kind == "custom_verse_grip":
        config["sub_type"] = "ruko"
        state["extension_data"] = [0] * 12
    if dialect == "3.5":
        config |= {"preset": "defaults", "basis": {"permutation": "XYZ"}, "mount": {}}
        state["transform"] = {}
    return {"device_id": grip.id, **({"config": config} if with_config else {}), "state": state, "status": status}


def vector(v: Array) -> Json:
    """A vector (3,) as an object with x, y and z."""
    x, y, z = v.tolist()
    return {"x": x, "y": y, "z": z}


def force_of(command: Json, dialect: str) -> tuple[Array | None, bool, str]:
    """The force of a ``set_cursor_force``, whether its form is deprecated, and why its value is invalid.

    Services up to 3.4 know ``values`` alone; 3.5 knows ``vector`` and takes ``values`` as well. Other keys are ignored
    in silence, as the service does.

    Returns:
        The force (3,) [N] or None, True for a deprecated form, the reason ("" without one).
    """
    deprecated = dialect == "3.5" and "vector" not in command and "values" in command
    given = command.get("vector" if dialect == "3.5" and not deprecated else "values")
    if given is None or command.get("execute", True) is not True:
        return None, False, ""
    numbers = [given.get(axis) for axis in "xyz"] if isinstance(given, dict) else [None]
    if not all(isinstance(n, (int, float)) and not isinstance(n, bool) and math.isfinite(n) for n in numbers):
        return None, deprecated, f"set_cursor_force has {given!r}, not three finite numbers x, y, z"
    return np.array(numbers, dtype=np.float64), deprecated, ""


def event(name: str, level: str, message: str, category: str = "device", **data: Any) -> Json:
    """A message of the events channel."""
    return {"name": name, "category": category, "level": level, "data": data, "message": message}


def by_id(entries: list[Json]) -> Json:
    """A list of devices as service 3.0 writes it: an object with the devices' names as keys."""
    return {entry["device_id"]: {key: entry[key] for key in entry if key != "device_id"} for entry in entries}
