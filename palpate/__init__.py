"""Palpate: feel virtual and scanned anatomy through a surgical robot's master arm."""

from __future__ import annotations

import sys
from importlib import import_module
from importlib.abc import Loader
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from palpate import planning as planning
    from palpate.arm import Arm as Arm
    from palpate.base.errors import PalpateError as PalpateError
    from palpate.devices.certificate import DeviceModel as DeviceModel
    from palpate.devices.certificate import certify as certify
    from palpate.devices.own_loop import OwnLoop as OwnLoop
    from palpate.record import Record as Record
    from palpate.scene import Scene as Scene
    from palpate.scene import contact as contact
    from palpate.scene import guidance as guidance
    from palpate.scene.guidance import Fixture as Fixture
    from palpate.session import Haptics as Haptics
    from palpate.session import PairsSession as PairsSession
    from palpate.session import Session as Session
    from palpate.session.batch import Variation as Variation
    from palpate.session.batch import simulate as simulate
    from palpate.world import registration as registration
    from palpate.world import shapes as shapes
    from palpate.world import surfaces as surfaces
    from palpate.world import tissue as tissue
    from palpate.world.clouds import PointCloud as PointCloud
    from palpate.world.mesh import Mesh as Mesh
    from palpate.world.tissue import Tissue as Tissue

    __version__: str

__all__ = [
    "Arm",
    "DeviceModel",
    "Fixture",
    "Haptics",
    "Mesh",
    "OwnLoop",
    "PairsSession",
    "PalpateError",
    "PointCloud",
    "Record",
    "Scene",
    "Session",
    "Tissue",
    "Variation",
    "certify",
    "cmake_dir",
    "contact",
    "guidance",
    "planning",
    "registration",
    "shapes",
    "simulate",
    "surfaces",
    "tissue",
]

_PLACE = {
    "Arm": "palpate.arm:Arm",
    "DeviceModel": "palpate.devices.certificate:DeviceModel",
    "Fixture": "palpate.scene.guidance:Fixture",
    "Haptics": "palpate.session:Haptics",
    "Mesh": "palpate.world.mesh:Mesh",
    "OwnLoop": "palpate.devices.own_loop:OwnLoop",
    "PairsSession": "palpate.session:PairsSession",
    "PalpateError": "palpate.base.errors:PalpateError",
    "PointCloud": "palpate.world.clouds:PointCloud",
    "Record": "palpate.record:Record",
    "Scene": "palpate.scene:Scene",
    "Session": "palpate.session:Session",
    "Tissue": "palpate.world.tissue:Tissue",
    "Variation": "palpate.session.batch:Variation",
    "certify": "palpate.devices.certificate:certify",
    "contact": "palpate.scene.contact",
    "guidance": "palpate.scene.guidance",
    "planning": "palpate.planning",
    "registration": "palpate.world.registration",
    "shapes": "palpate.world.shapes",
    "simulate": "palpate.session.batch:simulate",
    "surfaces": "palpate.world.surfaces",
    "tissue": "palpate.world.tissue",
}
"""Module of each public name, and after a colon its name there; without a colon the name is the module's own."""


class _PublicModules:
    """Finder of public modules and what is in them: `palpate.contact` is the module `palpate.scene.contact`."""

    @staticmethod
    def find_spec(name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        """The spec of a public module; None for every other name."""
        root, _, inside = name.partition(".")
        public, _, rest = inside.partition(".")
        place = _PLACE.get(public, ":")
        if root != __name__ or ":" in place or place == f"{root}.{public}":
            return None
        return ModuleSpec(name, _Alias(f"{place}.{rest}".rstrip(".")))


class _Alias(Loader):
    """Loader that returns a module which has another name of its own."""

    def __init__(self, place: str) -> None:
        self._place = place

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """The module; importing sets its spec, which `exec_module` sets back."""
        module = import_module(self._place)
        self._spec = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Nothing is executed again."""
        module.__spec__ = self._spec


sys.meta_path.insert(0, _PublicModules)  # first: the path of `palpate.tissue` would load its files a second time


def cmake_dir() -> str:
    """Folder of palpateConfig.cmake, by which a library compiles against the installed core (docs/extending.md)."""
    from pathlib import Path

    from palpate import _core

    return str(Path(_core.__file__).parent / "cmake")


def __getattr__(name: str) -> Any:
    """Import public names on first use, which keeps ``palpate --version`` fast."""
    if name == "__version__":
        from importlib.metadata import version

        return version("palpate")
    if name in (
        "_collision",
        "_core",
        "_dvrk",
        "_guidance",
        "_haply",
        "_network",
        "_reference",
        "_tissue",
        "_verify",
    ):  # compiled where it is first needed
        from palpate.rebuild import extension

        return extension(name)
    if name in _PLACE:
        module, _, inside = _PLACE[name].partition(":")
        found = import_module(module)
        return getattr(found, inside) if inside else found
    raise AttributeError(f"module 'palpate' has no attribute {name!r}. Available: {', '.join(__all__)}")
