"""The device of a scene as the plant of a session: opened or ready to open, before anything is built for it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from palpate import _core
from palpate.base.errors import DeviceError
from palpate.base.values import Pose
from palpate.devices.driven import DrivenLoop, driven_scene
from palpate.devices.driver import Driver, facts
from palpate.devices.haply.driver import Haply
from palpate.devices.loop import DeviceLoop, mapped_rig
from palpate.devices.native import NativeLoop, is_native, load_driver, native_scene, size_of
from palpate.devices.open import open_driver
from palpate.record.ticks import Ticks
from palpate.scene.rig import Rig
from palpate.scene.scene import Scene
from palpate.scene.surface import Bodies
from palpate.world.bodies.engine import World

Workspace = tuple[float, float, float]
"""Lengths along the axes of a device's base [m]."""

_APART = 0.3
"""Distance along x at which devices are drawn whose place nobody states [m]."""


class DevicePlant:
    """A device that leads in a session (`palpate.session.plants.Plant`).

    Args:
        scene: the scene with the rate and the caps of the device.
        workspace: lengths of the device's workspace; None: unknown.
        hardware: names of its parts, each of which can lead in one pair alone.
        make: makes its loop from the rig; its second argument is False if several pairs share the rigid bodies.
        driver: the driver; None for the loop of another program.
    """

    simulated = False
    lag = 0.0

    def __init__(
        self,
        scene: Scene,
        workspace: Workspace | None,
        hardware: tuple[str, ...],
        make: Callable[[Rig, bool], DeviceLoop],
        driver: Driver | _core.Driver | None = None,
    ) -> None:
        self.scene, self.workspace, self.hardware, self.driver = scene, workspace, hardware, driver
        self._make = make
        self._loop: DeviceLoop | None = None

    def build(self, bodies: Bodies | None = None, index: int = 0) -> Rig:
        """The rig of the scene; devices whose place nobody states are drawn beside each other, by their index."""
        rig, section = mapped_rig(self.scene, self.workspace, bodies), self.scene.arms.leader
        if index == 0 or section.base is not None or section.frame != "world":
            return rig
        x, y, z = rig.arms.X_WL[:3, 3].tolist()
        moved = section.model_copy(update={"base": Pose(xyz=(x + index * _APART, y, z))})
        arms = self.scene.arms.model_copy(update={"leader": moved})
        return mapped_rig(self.scene.model_copy(update={"arms": arms}), self.workspace, bodies)

    def begin(self, rig: Rig, seed: int, shared: bool) -> DeviceLoop:
        """Make the loop; a device takes no seed."""
        self._loop = self._make(rig, not shared)
        return self._loop

    @property
    def loop(self) -> DeviceLoop:
        """The loop, once `begin` has made it."""
        assert self._loop is not None
        return self._loop

    @property
    def joined(self) -> _core.DeviceCycle:
        """What meets the rigid bodies, and the instruments of other pairs."""
        return self.loop.cycle

    @property
    def world(self) -> World | None:
        """The rigid bodies of the scene, unless several pairs share them."""
        return self.loop.world

    def phase(self, t: float) -> str:
        """Empty: the hand is not simulated."""
        return ""

    @property
    def buttons(self) -> int:
        """Buttons of the newest reading, as `Reading.buttons`; none after a fault, which releases them."""
        return 0 if self.loop.fault() else self.loop.buttons

    def look(self) -> None:
        """No effect: the thread of the loop looks after the device."""

    def see(self, ticks: Ticks) -> None:
        """No effect."""

    def notices(self) -> list[str]:
        """What has happened to the device: cause; mend."""
        return self.loop.notices()

    def attach(self, remote: _core.RemoteEnd | None) -> None:
        """Let the hand feel what this end of a link renders, from the next start on; None: the objects of the scene."""
        self.loop.cycle.attach(remote)


def plant_of(scene: Scene, driver: Driver | None = None) -> DevicePlant:
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


def _in_core(scene: Scene, driver: _core.Driver, name: str, hardware: tuple[str, ...]) -> DevicePlant:
    made = native_scene(scene, name, driver)
    return DevicePlant(
        made, size_of(driver), hardware, lambda rig, own: NativeLoop(made, name, driver, rig, own), driver
    )


def _in_python(scene: Scene, driver: Driver, name: str) -> DevicePlant:
    known = facts(driver, name)
    made = driven_scene(scene, known)
    return DevicePlant(
        made, known.workspace, (name,), lambda rig, own: DrivenLoop(made, driver, name, rig, own), driver
    )
