"""Finds a driver by its name in a scene: a driver that ships with Palpate, MODULE:CLASS, or a shared object."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

from palpate.devices.driver import Driver
from palpate.errors import DeviceError
from palpate.scene.leader import DRIVERS

SHIPPED = {
    "simulated": "palpate.devices.simulated:SimulatedDevice",
}
"""Drivers that ship with Palpate, by their names in a scene."""


def open_driver(name: str, folder: Path | None = None) -> Driver:
    """The driver with a name, not yet connected to its device.

    Args:
        name: ``NAME`` or ``NAME:ARGUMENT`` of a driver that ships, ``MODULE:CLASS``.
        folder: folder in which MODULE is looked for in addition to ``sys.path``: that of the scene file.

    Raises:
        DeviceError: there is no such driver, or it cannot be imported or made.
    """
    head, _, argument = name.partition(":")
    if head == "loop":
        what = "this scene is driven by a loop of your own"
        raise DeviceError(what, mend="call palpate.Haptics(scene) in that program, or name another driver")
    if head in SHIPPED:
        return _made(SHIPPED[head], name, argument)
    if head in DRIVERS:
        raise DeviceError(f"driver {head!r} is not part of this build", mend=f"use one of {', '.join(SHIPPED)}")
    if folder is not None and str(folder.resolve()) not in sys.path:
        sys.path.append(str(folder.resolve()))
    return _made(name, name, "")


def _made(place: str, name: str, argument: str) -> Driver:
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
