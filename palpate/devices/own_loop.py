"""A loop of your own as the plant of a session: you step it, with the state of your device."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.errors import DeviceError
from palpate.devices.handle import AtHandle
from palpate.devices.loop import DeviceLoop, conditions, device_scene, explain
from palpate.devices.plant import DevicePlant
from palpate.scene.scene import Scene


class OwnLoop(DevicePlant):
    """One hand of several whose device you read and command in a loop of your own, at 50 to 10000 Hz.

        left = palpate.OwnLoop(scene.pair("left"), rate=1000)
        with palpate.PairsSession(scene, plants={"left": left}) as session:  # the other pairs: as the scene says
            session.start()
            while running:
                device.command(left.step(time.monotonic(), device.pose()))

    `palpate.Haptics` is the same for a scene with one hand. Each object belongs to one thread; those of two hands may
    be stepped in one thread or in two.

    Args:
        scene: the scene of one pair.
        rate, force_cap, moment_max, delay, resolution, friction, damping: as for `palpate.Haptics`.

    Raises:
        PalpateError: `rate` or `force_cap` is out of range. DeviceError: `friction` or `damping` is given without
        `resolution`. The session that takes the loop refuses what cannot run, such as a scene with several pairs.
    """

    def __init__(
        self,
        scene: Scene,
        rate: float | None = None,
        force_cap: float | None = None,
        moment_max: float | None = None,
        delay: float | None = None,
        resolution: float = 0.0,
        friction: float = 0.0,
        damping: float = 0.0,
    ) -> None:
        given = device_scene(scene, "loop", rate, force_cap, moment_max)
        known = AtHandle(resolution, delay=delay, friction=friction, damping=damping)
        super().__init__(given, None, (), lambda rig, own: DeviceLoop(given, known, replays=True, rig=rig, own=own))
        self._fault = _core.DeviceFault.none

    def step(
        self, t: float, X: npt.ArrayLike, V: npt.ArrayLike | None = None, gripper: float = 0.0, buttons: int = 0
    ) -> Array:
        """One step of the loop: a measured state in, the wrench to command out (`palpate.Haptics.step`).

        Raises:
            DeviceError: an argument has the wrong shape or type, or no session runs the loop; the wrench is then zero.
        """
        if self._loop is None or not self._loop.started:
            mend = 'palpate.PairsSession(scene, plants={"left": loop}).start()'
            raise DeviceError("step: no session runs this loop", mend=mend)
        pose, twist = self._numbers("X", X, (4, 4)), None if V is None else self._numbers("V", V, (6,))
        try:
            self._fault = self._loop.step(float(t), pose, twist, float(gripper), int(buttons))
        except (TypeError, ValueError) as error:
            raise self._refuse("t, gripper and buttons must be numbers", str(error)) from None
        return self._loop.wrench.copy()

    @property
    def gripper_torque(self) -> float:
        """Torque of the gripper on the fingers after the last step, positive when it opens them [N m].

        It is within ``arms.leader.gripper.torque`` of the scene, and zero after a fault.
        """
        return self.loop.cycle.gripper_torque

    @property
    def status(self) -> str:
        """``ok``, or the names of all present conditions, the gravest first, e.g. ``left_handed not_finite``.

        The names are those of the fault of the last step (`_core.DeviceFault`) and of `palpate.record.ticks.STATUS`.
        """
        fault = [] if self._fault is _core.DeviceFault.none else [self._fault.name]
        return " ".join(dict.fromkeys([*fault, *conditions(self.loop.cycle.status)])) or "ok"

    def why(self) -> str:
        """Why there is no force, or a reduced one, in a sentence with the mend; ``ok`` without a reason."""
        return explain(self._fault, self.loop.cycle.status)

    def _numbers(self, name: str, value: npt.ArrayLike, shape: tuple[int, ...]) -> Array:
        try:
            array = np.ascontiguousarray(value, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise self._refuse(f"{name} must be an array of numbers of shape {shape}", str(error)) from None
        if array.shape != shape:
            raise self._refuse(f"{name} must have shape {shape}. Got: {array.shape}")
        return array

    def _refuse(self, what: str, why: str = "") -> DeviceError:
        """The error for a wrong argument, after setting the wrench to zero."""
        self.loop.cycle.report_failure(self.loop.wrench)
        self._fault = _core.DeviceFault.driver_failed
        return DeviceError(f"step: {what}", why=why, mend="see help(palpate.Haptics.step)")
