"""Public modules and names that were renamed: importing the old name raises an error that states the new name."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import NoReturn

RENAMED = {
    "palpate.algorithm1": "palpate.contact.algorithm1",
    "palpate.arm_shapes": "palpate.arm.shapes",
    "palpate.bag": "palpate.record.bags",
    "palpate.bench": "palpate.verify.bench",
    "palpate.calibrate": "palpate.identify",
    "palpate.check": "palpate.mesh.check",
    "palpate.conformance": "palpate.verify.conformance",
    "palpate.dvrk": "palpate.simulators.dvrk",
    "palpate.fuzz": "palpate.verify.fuzz",
    "palpate.guidance.here": "palpate.guidance.context",
    "palpate.lessons": "palpate.contact.lessons",
    "palpate.mesh_files": "palpate.mesh.files",
    "palpate.mesh_repair": "palpate.mesh.repair",
    "palpate.registration.pcd": "palpate.clouds.pcd",
    "palpate.report.style": "palpate.plotting.style",
    "palpate.run_folder": "palpate.session.run_folder",
    "palpate.scene.descriptions": "palpate.values.descriptions",
    "palpate.scene.recorded": "palpate.session.recorded",
    "palpate.soak": "palpate.verify.soak.contact",
    "palpate.summary": "palpate.session.summary",
    "palpate.touchable": "palpate.contact.touchable",
}

NAMES = {
    "palpate.Device": "palpate.DeviceModel",
    "palpate.certificate.Device": "palpate.certificate.DeviceModel",
    "palpate.guidance.Here": "palpate.guidance.FixtureContext",
    "palpate.identify.hand.to_json": "palpate.identify.hand.figures",
    "palpate.record.bags.Arm": "palpate.record.bags.ArmTracks",
    "palpate.scene.surface.Surface": "palpate.scene.surface.PlacedSurface",
}


def missing_name(module: str, name: str) -> Exception:
    """The error that `__getattr__` of a module raises for an unknown name: ImportError if the name was renamed."""
    old = f"{module}.{name}"
    if old in NAMES:
        return ImportError(f"{old} is now {NAMES[old]}")
    return AttributeError(f"module {module!r} has no attribute {name!r}")


class RenamedMethod:
    """Class attribute in place of a renamed attribute: its use raises an AttributeError that states the new name."""

    def __init__(self, new: str) -> None:
        self._new = new

    def __set_name__(self, owner: type, name: str) -> None:
        self._old = f"{owner.__name__}.{name}"

    def __get__(self, instance: object, owner: type | None = None) -> NoReturn:
        """Raise the error."""
        raise AttributeError(f"{self._old} is now {self._new}")


class _Finder:
    """Finder at the end of ``sys.meta_path``; Python calls it only when no other finder finds the module."""

    @staticmethod
    def find_spec(name: str, path: Sequence[str] | None = None, target: ModuleType | None = None) -> ModuleSpec | None:
        """Raise ModuleNotFoundError with the new name of a renamed module; return None for every other module."""
        if name in RENAMED:
            raise ModuleNotFoundError(f"{name} is now {RENAMED[name]}")
        return None


def install() -> None:
    """Append the finder to ``sys.meta_path``, once."""
    if _Finder not in sys.meta_path:
        sys.meta_path.append(_Finder)
