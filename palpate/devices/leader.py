"""The device of a scene, opened or ready to open, before anything is built for it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from palpate import _core
from palpate.base.errors import DeviceError
from palpate.devices.driven import DrivenLoop, driven_scene
from palpate.devices.driver import Driver, facts
from palpate.devices.haply.driver import Haply
from palpate.devices.loop import DeviceLoop
from palpate.devices.native import NativeLoop, is_native, load_driver, native_scene, size_of
from palpate.devices.open import open_driver
from palpate.scene.rig import Rig
from palpate.scene.scene import Scene


class Leader(NamedTuple):
    """A device that leads in a scene."""

    scene: Scene
    """The scene with the rate and the caps of the device."""
    workspace: tuple[float, float, float] | None
    """Lengths of its workspace [m]; None: unknown."""
    hardware: tuple[str, ...]
    """Names of its parts, each of which can lead in one pair alone."""
    loop: Callable[[Rig | None], DeviceLoop]
    """Makes its loop, from the rig of `scene` if that is built already."""


def leader_of(scene: Scene, driver: Driver | None = None) -> Leader:
    """The device of a scene. A driver of the core opens it now, one in Python when its loop starts.

    Args:
        scene: a scene whose ``arms.leader.driver`` names a driver.
        driver: a driver object; that of the scene when left out.

    Raises:
        DeviceError: the driver is missing, invalid, or code that is not trusted; a driver of the core finds no device.
    """
    if driver is not None:
        cls = type(driver)
        return _in_python(scene, driver, scene.arms.leader.driver or f"{cls.__module__}:{cls.__name__}")
    name, folder = scene.arms.leader.driver, Path(scene.file).parent
    if name is None:
        what = "the scene names no driver"
        raise DeviceError(what, where=scene.where("arms", "leader"), mend="add driver: MODULE:CLASS")
    if is_native(name):
        return _in_core(scene, load_driver(name, folder, trust=scene.trusted), name, (name,))
    found = open_driver(name, folder, trust=scene.trusted)
    if isinstance(found, Haply):
        device = found.native()
        return _in_core(_around_first_pose(scene, device), device, name, found.hardware)
    return _in_python(scene, found, name)


def _around_first_pose(scene: Scene, driver: _core.Driver) -> Scene:
    """The scene with the workspace of a device whose centre is not the origin of its base: its first pose counts."""
    if scene.mapping.workspace is not None:
        return scene
    mapping = scene.mapping.model_copy(update={"workspace": size_of(driver)})
    return scene.model_copy(update={"mapping": mapping})


def _in_core(scene: Scene, driver: _core.Driver, name: str, hardware: tuple[str, ...]) -> Leader:
    made = native_scene(scene, name, driver)
    return Leader(made, size_of(driver), hardware, lambda rig: NativeLoop(made, name, driver, rig))


def _in_python(scene: Scene, driver: Driver, name: str) -> Leader:
    known = facts(driver, name)
    made = driven_scene(scene, known)
    return Leader(made, known.workspace, (name,), lambda rig: DrivenLoop(made, driver, name, rig))
