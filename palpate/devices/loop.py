"""The haptic cycle for a device, with the interface of a session's loop, and the words for its faults."""

from __future__ import annotations

from typing import Any

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.errors import PalpateError, SceneError
from palpate.devices.handle import UNKNOWN, AtHandle
from palpate.record.ticks import STATUS, Rows, Timing
from palpate.scene import held
from palpate.scene.port import Port, apply
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate.scene.soft import wait_for_bodies
from palpate.scene.surface import Bodies

STALE_AFTER = 0.02
"""Largest time between two steps without a fault [s]."""
RELEASE = 0.015
"""Time of the ramp to zero force after a fault [s]."""
DELAY_DOUBT = 0.003
"""Longest delay that the passivity layer expects of a device whose delay nobody states [s]."""
MOST_SCALE = 5.0
"""Largest scale that `mapping: scaled` chooses by itself [-]."""
_Fault = _core.DeviceFault

WORDS: dict[_core.DeviceFault, tuple[str, str]] = {
    _Fault.not_finite: (
        "a number of the state is NaN, infinite, or impossibly large (100 m, 10 rad of the gripper)",
        "check the device's connection, and the units: metres and radians",
    ),
    _Fault.not_rigid: (
        "the pose X is no rigid motion: X[:3, :3] must be a rotation matrix, X[3] must be 0 0 0 1",
        "check for a scaled or transposed matrix, and for positions in the last row instead of the last column",
    ),
    _Fault.left_handed: (
        "the axes of the pose X are left-handed: the determinant of X[:3, :3] is -1",
        "reverse the sign of one axis: graphics engines such as Unity and Unreal use left-handed axes",
    ),
    _Fault.time_not_increasing: (
        "the time t did not increase since the last step, or it jumped by more than an hour",
        "pass the time of a steady clock in seconds, for example time.monotonic()",
    ),
    _Fault.gap: (
        f"more than {1e3 * STALE_AFTER:g} ms passed since the last step",
        "call step() at the rate of the loop, without files, prints or graphics between two steps",
    ),
    _Fault.too_often: (
        "step() is called more than 2.5 times as often as the rate says",
        "pass the rate of your loop: palpate.Haptics(scene, rate=4000), or rates.haptic in the scene",
    ),
    _Fault.driver_failed: (
        "the device could not be read",
        "check its cable and power, and whether another program uses it",
    ),
}
"""Cause and mend of each fault."""


def conditions(status: int) -> list[str]:
    """Names of the bits of a status, the gravest first."""
    return [name for name, (bit, _) in STATUS.items() if status & bit]


def device_scene(
    scene: Scene,
    driver: str,
    rate: float | None = None,
    force_cap: float | None = None,
    moment_max: float | None = None,
) -> Scene:
    """The scene with a driver in place of the simulated leader, another rate [Hz] and a lower force cap [N].

    A port has the axes that its device has: the passivity layer must not count a moment that no motor gives. Without
    ``stability.moment_cap`` in the scene, and without `moment_max`, the device therefore gets forces only.

    Args:
        scene: the scene.
        driver: name of the driver.
        rate: rate of the loop [Hz]; the scene's when left out.
        force_cap: largest force [N]; the scene's when left out.
        moment_max: largest moment that the device can give, 0: no motor turns its handle [N m]; None: unknown.

    Raises:
        PalpateError: the rate is outside 50 to 10000 Hz, the cap is not positive or above the scene's, or `moment_max`
            is below 0.
    """
    stability, rates = scene.stability, scene.rates
    if rate is not None:
        if not 50.0 <= rate <= 10_000.0:
            raise PalpateError(f"rate = {rate:g} Hz: must be 50 to 10000 Hz", mend="give the rate of your loop")
        rates = rates.model_copy(update={"haptic": float(rate)})
    if force_cap is not None:
        if not 0.0 < force_cap <= stability.force_cap:
            what = f"force_cap = {force_cap:g} N: must be above 0 and at most the scene's {stability.force_cap:g} N"
            raise PalpateError(what, mend="raise stability.force_cap in the scene, and run `palpate certify` on it")
        moment = stability.moment_cap * force_cap / stability.force_cap
        stability = stability.model_copy(update={"force_cap": float(force_cap), "moment_cap": moment})
    if moment_max is not None and not moment_max >= 0.0:
        raise PalpateError(f"moment_max = {moment_max:g} N m: must be 0 or more", mend="give 0 without torque motors")
    if moment_max is None:
        moment_max = stability.moment_cap if "moment_cap" in scene.stability.model_fields_set else 0.0
    stability = stability.model_copy(update={"moment_cap": min(stability.moment_cap, moment_max)})
    leader = scene.arms.leader.model_copy(update={"driver": driver})
    arms = scene.arms.model_copy(update={"leader": leader})
    return scene.model_copy(update={"arms": arms, "stability": stability, "rates": rates})


def device_port(scene: Scene, known: AtHandle = UNKNOWN) -> Port:
    """What the passivity layer assumes of the device: stated friction, and a doubt of a delay that nobody states.

    The scene's ``loop_delay`` counts as stated, and ``friction_share: 0`` counts no friction.
    """
    stated = scene.loop_delay if known.delay is None and "loop_delay" in scene.model_fields_set else known.delay
    friction = known.certain_friction() if scene.stability.friction_share > 0.0 else _core.CertainFriction()
    doubt = DELAY_DOUBT if stated is None else 0.0
    return Port(stated or 0.0, doubt, known.mass, known.resolution, friction)


def device_options(rig: Rig, port: Port) -> _core.CrtkOptions:
    """Options of the cycle.

    Args:
        rig: the rig of a scene from `device_scene`.
        port: from `device_port`.
    """
    options, scene = rig.options(), rig.scene
    mapping = options.mapping
    mapping.align_rate = 0.0  # the axes of handle and tool are unrelated: the tool follows relative rotations
    options.mapping = mapping
    s = options.stability
    apply(scene.stability, port, s)
    options.stability = s
    cycle = _core.CrtkOptions(options, rig.arms.q_follower0)
    watch = cycle.watch
    watch.stale_after = min(watch.stale_after, STALE_AFTER)
    cycle.watch, cycle.release = watch, RELEASE
    return cycle


def mapped_rig(scene: Scene, workspace: tuple[float, float, float] | None, bodies: Bodies | None = None) -> Rig:
    """The rig of a scene whose mapping knows the workspace of the device.

    Args:
        scene: a scene from `device_scene`.
        workspace: lengths along the axes of the device's base [m]; those of the scene take precedence.
        bodies: surfaces that several scenes share.

    Raises:
        SceneError, MeshError: the scene cannot run; its mapping needs a workspace, or a scale above 5 to cover the
        objects.
    """
    mapping = scene.mapping.with_device(workspace)
    if mapping.law != "indexed" and mapping.workspace is None:
        what = f"mapping law {mapping.law} needs the workspace of the device"
        mend = f"write mapping: {{law: {mapping.law}, workspace: [0.16, 0.16, 0.11]}}, in m"
        raise SceneError(what, where=scene.where("mapping"), mend=mend)
    rig = build(scene.model_copy(update={"mapping": mapping}), bodies)
    if mapping.law != "scaled" or "scale" in mapping.model_fields_set:
        return rig
    corners = np.array([surface.bounds for surface in rig.surfaces])
    covering = mapping.covering(corners[:, 0].min(axis=0), corners[:, 1].max(axis=0), rig.arms.X_WL[:3, :3])
    if covering.scale > MOST_SCALE:
        what = f"mapping law scaled: the objects need {covering.scale:.3g} times the workspace, at most {MOST_SCALE:g}"
        raise SceneError(what, where=scene.where("mapping"), mend="use rate or drift, or give mapping.scale")
    return build(scene.model_copy(update={"mapping": covering}), bodies)


_LONGEST = 0.02  # time by which bodies move on after a pause [s]


class DeviceLoop:
    """The cycle for a device, stepped by its owner, with the interface of a session's `Loop`.

    Args:
        scene: a scene from `device_scene`.
        known: what is known of the device at its handle.
        workspace: lengths of the device's workspace along the axes of its base [m]; None: those of the scene.
        replays: whether its owner may step it faster than real time: it then waits for the threads of soft bodies.
        rig: the rig of the scene, from `mapped_rig`, if it is built already.
        own: False: the rigid bodies of the scene are those of several pairs, whose session joins them.

    Raises:
        SceneError, MeshError: the scene cannot run, or its mapping needs a workspace.
    """

    def __init__(
        self,
        scene: Scene,
        known: AtHandle = UNKNOWN,
        workspace: tuple[float, float, float] | None = None,
        replays: bool = False,
        rig: Rig | None = None,
        own: bool = True,
    ) -> None:
        self.rig = rig = mapped_rig(scene, workspace) if rig is None else rig
        if replays:
            wait_for_bodies(rig.snapshot)
        options = device_options(rig, device_port(scene, known))
        self.cycle = _core.DeviceCycle(options, rig.arms.follower, rig.snapshot)
        self.cycle.set_fixtures(rig.fixtures)
        self.world = held.join({"": rig}, [self.cycle]) if own else None  #: the rigid bodies of the scene
        if self.world is not None and replays:
            self.world.threaded = False
        self._t: float | None = None  # of the last step, for bodies without a thread [s]
        self.wrench: Array = np.zeros(6)  #: newest wrench on the hand [N, N m]; overwritten by every step
        self._buttons = 0
        self.started = False  #: whether a session runs the loop

    def step(self, t: float, X: Array, V: Array | None, gripper: float, buttons: int) -> _core.DeviceFault:
        """One step; the arrays are C-contiguous float64 (4, 4) and (6,). Writes `wrench`."""
        self._buttons = buttons
        fault = self.cycle.step(t, X, V, gripper, bool(buttons & 1), self.wrench)
        if self.world is not None and not self.world.threaded and np.isfinite(t):
            self.world.core_bodies.advance(min(max(t - (t if self._t is None else self._t), 0.0), _LONGEST))
            self._t = t
        return fault

    def start(self) -> None:
        """Allocate the queue of ticks."""
        self.cycle.start()
        self.started = True

    def stop(self) -> None:
        """End the thread of the collision queries, if the contact method has one."""
        self.cycle.stop()
        self.started = False

    @property
    def buttons(self) -> int:
        """Buttons of the newest reading, as `Reading.buttons`."""
        return self._buttons

    def drain(self) -> Rows:
        """The rows since the last call."""
        return self.cycle.drain()

    def latest(self) -> Rows:
        """The newest row."""
        return self.cycle.latest()

    def soft_vertices(self, object: int, /) -> Rows:
        """Deformed vertices (n, 3) of a soft object, in the object's frame O [m]."""
        return self.cycle.soft_vertices(object)

    @property
    def dropped(self) -> int:
        """Number of rows lost because they were not drained in time."""
        return int(self.cycle.dropped)

    def timing(self) -> Timing:
        """Compute time of the steps; the owner of the loop keeps its deadlines."""
        period = self.cycle.period
        return {"cycle_us": self.cycle.timing(), "missed_ticks": 0, "rate_Hz": 1.0 / period if period > 0.0 else 0.0}

    @property
    def controls(self) -> _core.Controls:
        """The controls, as in `_core.Simulation`."""
        return self.cycle.controls

    @controls.setter
    def controls(self, value: _core.Controls) -> None:
        self.cycle.controls = value

    def set_snapshot(self, snapshot: _core.Snapshot, /) -> None:
        """Replace all objects at the next step."""
        self.cycle.set_snapshot(snapshot)

    def set_live(self, targets: _core.LiveTargets, /) -> None:
        """Set the poses that the live objects shall reach."""
        self.cycle.set_live(targets)

    def set_fixtures(self, fixtures: _core.FixtureList, /) -> None:
        """Replace all guidance fixtures at the next step."""
        self.cycle.set_fixtures(fixtures)

    def fault(self) -> str | None:
        """Reason for which the loop ended by itself; the loop of another program never does."""
        return None

    def notices(self) -> list[str]:
        """What has happened to the device, which no status tells: cause; mend."""
        return []


def explain(fault: _core.DeviceFault, status: int) -> str:
    """Cause and mend of a fault, or the conditions of a status, in words."""
    if fault in WORDS:
        cause, mend = WORDS[fault]
        return f"no force: {cause}; mend: {mend}"
    words: list[Any] = [STATUS[name][1] for name in conditions(status)]
    return "; ".join(words) if words else "ok"
