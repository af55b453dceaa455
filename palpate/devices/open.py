"""Finds a driver by its name in a scene: a driver that ships with Palpate, MODULE:CLASS or FILE.py:CLASS.

`palpate.devices.trust` says whose code is loaded. While trusted code is imported, its folder is at the end of
``sys.path``, for the modules beside it; before and after, the path is that of the process.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from palpate.base.errors import DeviceError
from palpate.devices.driver import Driver
from palpate.devices.python_file import import_file
from palpate.devices.trust import require_trust

SHIPPED = {
    "simulated": "palpate.devices.simulated:SimulatedDevice",
    "shared-memory": "palpate.devices.shared_memory:SharedMemoryDevice",
    "mouse": "palpate.devices.evdev:Mouse",
    "keyboard": "palpate.devices.keyboard:Keyboard",
    "gamepad": "palpate.devices.evdev:Gamepad",
    "haply": "palpate.devices.haply.driver:Haply",
    "webxr": "palpate.devices.webxr:WebXR",
    "force-dimension": "palpate.devices.force_dimension:ForceDimension",
}
"""Drivers that ship with Palpate, by their names in a scene."""
_FUNCTIONS = ("open", "read", "write", "close")


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


def open_driver(name: str, folder: Path | None = None, *, trust: bool = False) -> Driver:
    """The driver with a name, not yet connected to its device.

    Args:
        name: ``NAME`` or ``NAME:ARGUMENT`` of a driver that ships, ``MODULE:CLASS`` or ``FILE.py:CLASS``.
        folder: folder in which trusted code is looked for in addition to ``sys.path``: that of the scene file.
        trust: True if the user trusts the code; otherwise it must be installed.

    Raises:
        DeviceError: there is no such driver, its code is not trusted, or it cannot be imported or made.
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
    require_trust(name, trust)
    if head.endswith(".py"):
        file = (folder or Path()) / Path(head).expanduser()
        with _beside(file.parent):
            return _make(f"{_module_of(file, name)}:{argument}", name, "", trust)
    with _beside(folder if trust else None):
        return _make(name, name, "", trust)


@contextmanager
def _beside(folder: Path | None) -> Iterator[None]:
    """While the context is open, modules are also found in a folder."""
    place = None if folder is None else str(folder.resolve())
    new = place is not None and place not in sys.path
    if new:
        sys.path.append(str(place))
    try:
        yield
    finally:
        if new and place in sys.path:
            sys.path.remove(str(place))


def _module_of(file: Path, name: str) -> str:
    """Name of the module in a file, after reading the file.

    Raises:
        DeviceError: the file is missing, or raises an exception.
    """
    if not file.is_file():
        raise DeviceError(f"driver {name!r}: there is no file {file}", mend="paths start at the scene's folder")
    try:
        return import_file(file, "driver").__name__
    except Exception as error:
        what = f"driver {name!r} cannot be imported"
        raise DeviceError(what, why=f"{type(error).__name__}: {error}", mend=f"correct {file}") from error


def open_python_driver(name: str, folder: Path) -> Driver:
    """As `open_driver` of code that the user named on the command line, which may also be a driver in C.

    Raises:
        DeviceError: as for `open_driver`, and for a shared object that cannot be used.
    """
    file, _, argument = name.partition(":")
    if file.endswith(".so"):
        from palpate.devices.shared_object import SharedObject

        return SharedObject(folder / Path(file).expanduser(), argument)
    return open_driver(name, folder, trust=True)


def _make(place: str, name: str, argument: str, trust: bool = False) -> Driver:
    module, _, cls = place.partition(":")
    try:
        made = getattr(import_module(module), cls)
        if not trust and not (isinstance(made, type) and all(hasattr(made, f) for f in _FUNCTIONS)):
            what = f"driver {name!r} is no class with {', '.join(_FUNCTIONS)}"
            raise DeviceError(what, mend=f"give the name of a driver's class of {module}")
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
