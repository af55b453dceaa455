"""Finds a driver by its name in a scene: a driver that ships with Palpate, MODULE:CLASS, or a shared object."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from palpate.devices.driver import Driver
from palpate.errors import DeviceError

SHIPPED = {
    "simulated": "palpate.devices.simulated:SimulatedDevice",
    "shared-memory": "palpate.devices.shared_memory:SharedMemoryDevice",
    "mouse": "palpate.devices.evdev:Mouse",
    "gamepad": "palpate.devices.evdev:Gamepad",
    "force-dimension": "palpate.devices.force_dimension:ForceDimension",
}
"""Drivers that ship with Palpate, by their names in a scene."""


@dataclass(frozen=True)
class Listed:
    """A driver that ships with Palpate."""

    name: str
    device: str  # what it drives
    force: bool  # it renders forces
    ready: bool  # it can be opened on this machine
    needs: str  # what is missing, in words; empty if ready


def listed() -> list[Listed]:
    """The drivers that ship with Palpate."""
    found = []
    for name, place in SHIPPED.items():
        module, _, cls = place.partition(":")
        kind = getattr(import_module(module), cls)
        needs = kind.missing()
        device = (kind.__doc__ or "").partition("\n")[0].rstrip(".")
        found.append(Listed(name, device, kind.force_max > 0.0, not needs, needs))
    return found


def open_driver(name: str, folder: Path | None = None) -> Driver:
    """The driver with a name, not yet connected to its device.

    Args:
        name: ``NAME`` or ``NAME:ARGUMENT`` of a driver that ships, or ``MODULE:CLASS``.
        folder: folder in which MODULE is looked for in addition to ``sys.path``: that of the scene file.

    Raises:
        DeviceError: there is no such driver, or it cannot be imported or made.
    """
    head, _, argument = name.partition(":")
    if head == "loop":
        what = "this scene is driven by a loop of your own"
        raise DeviceError(what, mend="call palpate.Haptics(scene) in that program, or name another driver")
    if head in SHIPPED:
        return _make(SHIPPED[head], name, argument)
    if ":" not in name:
        what = f"there is no driver {name!r}"
        raise DeviceError(what, mend=f"write MODULE:CLASS, or one of {', '.join(SHIPPED)}")
    if folder is not None and str(folder.resolve()) not in sys.path:
        sys.path.append(str(folder.resolve()))
    return _make(name, name, "")


def open_python_driver(name: str, folder: Path) -> Driver:
    """As `open_driver`, for commands that talk to the driver themselves and need one in Python.

    Raises:
        DeviceError: as for `open_driver`, and for a shared object.
    """
    if name.partition(":")[0].endswith(".so"):
        what = f"{name}: this command reads and writes drivers in Python only"
        raise DeviceError(what, mend="name a shared object in a scene: arms: {leader: {driver: my_device.so}}")
    return open_driver(name, folder)


def _make(place: str, name: str, argument: str) -> Driver:
    module, _, cls = place.partition(":")
    try:
        made = getattr(import_module(module), cls)
        driver: Driver = made(argument) if argument else made()
    except DeviceError:
        raise
    except ImportError as error:
        mend = "give the module's name without .py; it is looked for in the scene's folder and on PYTHONPATH"
        raise DeviceError(f"driver {name!r} cannot be imported", why=str(error), mend=mend) from None
    except AttributeError as error:
        raise DeviceError(f"driver {name!r}: {error}", mend=f"give the name of a class of {module}") from None
    except Exception as error:
        what = f"driver {name!r} cannot be made: {type(error).__name__}: {error}"
        raise DeviceError(what, mend="its constructor must work without arguments") from error
    return driver
