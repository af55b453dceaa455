"""`palpate check` of a scene with a driver: the facts of the device, without connecting to it, and what it reaches."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console

from palpate.base.errors import DeviceError, PalpateWarning
from palpate.cli.terminal.output import say
from palpate.devices.driver import Driver, Facts, facts
from palpate.devices.loop import device_scene, mapped_rig
from palpate.devices.native import is_native
from palpate.devices.open import open_driver
from palpate.devices.trust import is_installed
from palpate.scene import Scene
from palpate.scene.leader import DRIVERS
from palpate.scene.rig import Rig, build


@dataclass(frozen=True)
class DeviceFindings:
    """The device of a scene; facts are None if only the device or the calling program knows them."""

    driver: str
    rate_Hz: float
    force_cap_N: float
    workspace_m: tuple[float, float, float] | None
    mapping: str
    scale: float


@dataclass(frozen=True)
class Device:
    """The driver of a scene, and the rig that it would run."""

    name: str
    facts: Facts | None
    rig: Rig

    def tell(self, console: Console) -> DeviceFindings:
        """Print and return the findings."""
        scene, known = self.rig.scene, self.facts
        mapping, cap = scene.mapping, scene.stability.force_cap
        size = mapping.workspace or (known.workspace if known else None)
        force = "no force" if known is not None and known.force_max == 0.0 else f"at most {cap:g} N"
        say(console, f"{self.name}: {scene.rates.haptic:g} Hz, {force}; {_reach(size, mapping.scale)}", "device:")
        say(console, f"{mapping.law}, {mapping.scale:.3g} mm of the tool per mm of the hand", "mapping:")
        return DeviceFindings(self.name, scene.rates.haptic, cap, size, mapping.law, mapping.scale)


def inspect_device(scene: Scene) -> Device:
    """The driver of a scene and its rig; the device itself is not opened.

    Raises:
        DeviceError: there is no such driver, or its facts are invalid. SceneError, MeshError: the scene cannot run.
    """
    name = scene.arms.leader.driver or ""
    try:
        if not (scene.trusted or name.partition(":")[0] in DRIVERS or is_installed(name)):
            what = f"driver {name!r} is code that is neither installed nor trusted: it was not imported"
            where, mend = scene.where("arms", "leader", "driver"), "read it, then allow it with --trust"
            warnings.warn(PalpateWarning(what, where=where, mend=mend), stacklevel=2)
            known_size = scene.mapping.law == "indexed" or scene.mapping.workspace is not None
            return Device(name, None, mapped_rig(scene, None) if known_size else build(scene))
        if is_native(name) or name == "loop":
            return Device(name, None, build(scene) if is_native(name) else mapped_rig(scene, None))
        driver = open_driver(name, Path(scene.file).parent, trust=scene.trusted)
        if missing := _missing(name, driver):
            where, mend = scene.where("arms", "leader", "driver"), "connect it before palpate run; palpate device list"
            warnings.warn(PalpateWarning(f"driver {name}: {missing}", where=where, mend=mend), stacklevel=2)
        known = facts(driver, name)
    except DeviceError as error:
        where = scene.where("arms", "leader", "driver")
        raise DeviceError(error.what, where=error.where or where, why=error.why, mend=error.mend) from None
    cap = min(known.force_max or scene.stability.force_cap, scene.stability.force_cap)
    return Device(
        name, known, mapped_rig(device_scene(scene, name, known.rate, cap, known.moment_max), known.workspace)
    )


def _missing(name: str, driver: Driver) -> str:
    """What this machine lacks for a device, in words; empty if nothing is known to be missing."""
    head, _, file = name.partition(":")
    if head in ("mouse", "gamepad", "keyboard") and file:
        return "" if Path(file).exists() else f"there is no {file}"
    return str(getattr(driver, "missing", str)())  # drivers of users need not derive from Driver


def _reach(size: tuple[float, float, float] | None, scale: float) -> str:
    if size is None:
        return "its workspace is known only while it runs"
    hand, tool = (" x ".join(f"{x:.0f}" for x in 1e3 * k * np.array(size)) for k in (1.0, scale))
    return f"a workspace of {hand} mm, in which the tool reaches {tool} mm without the clutch"
