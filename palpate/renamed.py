"""Public modules that moved: an import of the old name says the new one."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from types import ModuleType

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
    "palpate.lessons": "palpate.contact.lessons",
    "palpate.mesh_files": "palpate.mesh.files",
    "palpate.mesh_repair": "palpate.mesh.repair",
    "palpate.report.style": "palpate.plotting.style",
    "palpate.run_folder": "palpate.session.run_folder",
    "palpate.scene.recorded": "palpate.session.recorded",
    "palpate.soak": "palpate.verify.soak",
    "palpate.summary": "palpate.session.summary",
    "palpate.touchable": "palpate.contact.touchable",
}


class _Finder:
    """The last finder of ``sys.meta_path``: it is asked only for modules that no other finder knows."""

    @staticmethod
    def find_spec(name: str, path: Sequence[str] | None = None, target: ModuleType | None = None) -> ModuleSpec | None:
        """Raise ModuleNotFoundError with the new name of a module that moved; None for all others."""
        if name in RENAMED:
            raise ModuleNotFoundError(f"{name} is now {RENAMED[name]}")
        return None


def announce() -> None:
    """Let imports of old names say the new ones; a second call changes nothing."""
    if _Finder not in sys.meta_path:
        sys.meta_path.append(_Finder)
