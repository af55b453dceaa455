"""Plants: where the hand of a session is. A simulated arm, a device with a driver, or an arm on ROS 2."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from palpate import _core
from palpate.record.ticks import Ticks
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate.scene.surface import Bodies

if TYPE_CHECKING:
    from palpate.devices.driver import Driver
    from palpate.scene.together import Joined
    from palpate.session.loop import LockstepLoop, Loop
    from palpate.world.bodies.engine import World


class Plant(Protocol):
    """What a session drives: it makes the rig and the loop, and tells what only it knows."""

    scene: Scene
    """The scene at the rate and with the caps of this plant."""
    hardware: tuple[str, ...]
    """Names of its parts, each of which can lead in one pair alone."""
    driver: Any
    """The object that drives the device; None: there is none."""
    simulated: bool
    """True: it has no time of its own, and can run in lockstep."""
    lag: float
    """Time by which its force and motion wait beyond the loop, as on a network [s]."""

    def build(self, bodies: Bodies | None = None, index: int = 0) -> Rig:
        """The rig of the scene; `index`: number of devices of the session before this one."""
        ...

    def begin(self, rig: Rig, seed: int, shared: bool) -> Loop:
        """Make the loop; `shared`: several pairs share the cores and the rigid bodies."""
        ...

    @property
    def joined(self) -> Joined:
        """What meets the rigid bodies, and the instruments of other pairs."""
        ...

    @property
    def world(self) -> World | None:
        """The rigid bodies of the scene, unless several pairs share them; None: it has none."""
        ...

    def phase(self, t: float) -> str:
        """What a simulated hand does at a time [s]; otherwise empty."""
        ...

    @property
    def buttons(self) -> int:
        """Buttons of the handle, as `palpate.devices.Reading.buttons`."""
        ...

    def look(self) -> None:
        """Look after what is beside its loop; called about twenty times a second while it runs in real time."""
        ...

    def see(self, ticks: Ticks) -> None:
        """See every tick of the loop, in order."""
        ...

    def notices(self) -> list[str]:
        """What has happened to it, which no status tells: cause; mend."""
        ...

    def attach(self, remote: _core.RemoteEnd | None) -> None:
        """Let the hand feel what this end of a link renders; None: the objects of the scene."""
        ...


class SimulatedPlant:
    """A simulated hand on a simulated arm."""

    simulated = True
    hardware: tuple[str, ...] = ()
    driver = None
    buttons = 0
    lag = 0.0

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.world: World | None = None
        self._rig: Rig | None = None
        self._loop: _core.Simulation | None = None

    def build(self, bodies: Bodies | None = None, index: int = 0) -> Rig:
        """The rig of the scene."""
        return build(self.scene, bodies)

    def begin(self, rig: Rig, seed: int, shared: bool) -> LockstepLoop:
        """Make the simulation."""
        self._rig = rig
        if not shared:
            self._loop = rig.simulation(seed)
            if rig.scene.bodies:
                from palpate.scene import held

                self.world = held.join({"": rig}, [self._loop])
            return self._loop
        options = rig.options(seed)
        realtime = _core.RealTimeOptions()  # loops that share the cores neither spin nor claim one
        realtime.allow_affinity, realtime.spin_us = False, 0.0
        options.realtime = realtime
        self._loop = rig.simulation(options=options)
        return self._loop

    @property
    def joined(self) -> _core.Simulation:
        """The simulation, once `begin` has made it."""
        assert self._loop is not None
        return self._loop

    def phase(self, t: float) -> str:
        """The phase of the hand's path."""
        return "" if self._rig is None else self._rig.path.phase(t)

    def look(self) -> None:
        """No effect."""

    def see(self, ticks: Ticks) -> None:
        """No effect."""

    def notices(self) -> list[str]:
        """None."""
        return []

    def attach(self, remote: _core.RemoteEnd | None) -> None:
        """Let the hand feel what this end of a link renders; None: the objects of the scene."""
        self.joined.attach(remote)


def plant_of(scene: Scene, driver: Driver | None = None) -> Plant:
    """The plant of a scene: the device of its driver, or a simulation.

    Args:
        scene: the scene of one pair.
        driver: a driver object (`palpate.devices.Driver`); that of the scene when left out.

    Raises:
        DeviceError: the driver is missing, invalid, or code that is not trusted.
    """
    if scene.arms.leader.driver is None and driver is None:
        return SimulatedPlant(scene)
    from palpate.devices import plant

    return plant.plant_of(scene, driver)
