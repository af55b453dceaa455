"""A driver in C or C++ and the haptic cycle, in a real-time thread of the core."""

from __future__ import annotations

from pathlib import Path

from palpate import _core
from palpate.base.errors import DeviceError
from palpate.devices.handle import MASS, AtHandle
from palpate.devices.loop import DeviceLoop, device_scene
from palpate.devices.trust import require_trust
from palpate.record.ticks import Timing
from palpate.scene.rig import Rig
from palpate.scene.scene import Scene


def is_native(name: str) -> bool:
    """True for ``my_device.so`` and ``my_device.so:ARGUMENT``."""
    return name.partition(":")[0].endswith(".so")


def header_folder() -> Path:
    """Folder of ``driver.h``, the interface of drivers in C."""
    root = Path(__file__).resolve().parents[1]
    installed = root / "include" / "palpate" / "loop"
    return installed if installed.is_dir() else root.parent / "core" / "palpate" / "loop"


def load_driver(name: str, folder: Path, *, trust: bool = False) -> _core.Driver:
    """The open driver of a shared object that the user trusts; relative paths start at `folder`.

    Raises:
        DeviceError: the file is not trusted, cannot be loaded, lacks a function or has invalid facts, or its device
        cannot be opened.
    """
    require_trust(name, trust)
    file, _, argument = name.partition(":")
    path = (folder / Path(file).expanduser()).resolve()
    try:
        return _core.SharedObject(str(path), argument)
    except ValueError as error:
        mend = f"compile it with -shared -fPIC -I {header_folder()}; driver.h there says what each function does"
        raise DeviceError(f"driver {name} cannot be used", why=str(error), mend=mend) from None


def size_of(driver: _core.Driver) -> tuple[float, float, float] | None:
    """Lengths of a driver's workspace [m]; None if it states none."""
    return driver.workspace if min(driver.workspace) > 0.0 else None


def native_scene(scene: Scene, name: str, driver: _core.Driver) -> Scene:
    """The scene at the rate of a driver of the core, with its caps."""
    cap = min(driver.force_max or scene.stability.force_cap, scene.stability.force_cap)
    return device_scene(scene, name, driver.rate, cap, driver.moment_max)


def at_handle_of(driver: _core.Driver) -> AtHandle:
    """What a driver of the core states of its handle.

    Raises:
        DeviceError: friction or damping without resolution.
    """
    mass, delay = driver.mass or MASS, driver.delay or None
    return AtHandle(driver.resolution, mass, delay, driver.friction, driver.damping)


class NativeLoop(DeviceLoop):
    """Reads a driver of the core, steps the cycle and writes the wrench, without the interpreter.

    A driver that reports a failure ends the loop with zero force. If a call does not return within 12 ms, a second
    thread commands zero force. A driver that crashes takes this process with it: run it in another process instead
    (driver ``shared-memory``).

    Args:
        scene: scene to render; its rate becomes that of the driver, and its force cap at most that of the driver.
        name: name of the driver for messages.
        driver: the opened device.
        rig: the rig of `native_scene`, if it is built already.
        own: as for `DeviceLoop`.

    Raises:
        DeviceError: the driver states friction without resolution. SceneError, MeshError: the scene cannot run.
    """

    def __init__(self, scene: Scene, name: str, driver: _core.Driver, rig: Rig | None = None, own: bool = True) -> None:
        self.driver, self._name = driver, name
        super().__init__(native_scene(scene, name, driver), at_handle_of(driver), size_of(driver), rig=rig, own=own)
        self._thread = _core.DriverThread(self.driver, self.cycle)

    def start(self) -> None:
        """Start the real-time thread."""
        super().start()
        self._thread.start()

    def stop(self) -> None:
        """Ramp the force to zero and end the thread; a thread that hangs in the driver is left behind."""
        self._thread.stop()
        super().stop()

    @property
    def buttons(self) -> int:
        """Buttons of the newest reading, as `Reading.buttons`."""
        return self._thread.buttons

    def fault(self) -> str | None:
        """Why the loop ended by itself, or that the driver hangs."""
        words = self._thread.fault()
        return f"driver {self._name}: {words}; the force was set to zero" if words else None

    def notices(self) -> list[str]:
        """What has happened to the device: cause; mend."""
        return [f"driver {self._name}: {words}" for words in self.driver.notices]

    def timing(self) -> Timing:
        """Compute time, lateness, missed deadlines, stalls of the driver, scheduling."""
        timing = {**super().timing(), **self._thread.timing(), "stalls": self._thread.stalls}
        late = timing["lateness_us"]
        words = f"lateness p50 {late['p50']:.0f} us, p99 {late['p99']:.0f} us, at most {late['max']:.0f} us"
        return {**timing, "scheduler": f"{timing['scheduler']}; {words}"}
