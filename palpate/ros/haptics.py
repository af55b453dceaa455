"""A session that renders a scene on a real or simulated CRTK master over ROS 2."""

from __future__ import annotations

import os
import secrets
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from palpate import _core, ros
from palpate.base import stop_signals
from palpate.base.errors import PalpateError
from palpate.record.ticks import STATUS, Ticks
from palpate.ros import jitter
from palpate.ros.ended_node import EndedNode
from palpate.ros.guardian import Guardian
from palpate.ros.reports import ForceReports
from palpate.scene import held, port
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate.session import LiveSession, State
from palpate.session.faults import SeenFaults
from palpate.session.run_folder import require_writable
from palpate.session.summary import Summary
from palpate.world.bodies.engine import World

FORCE_CAP = 1.0
"""Default force cap on real arms [N]; only --force-cap can raise it."""
NO_TIMEOUT = (
    "an arm of the dVRK has no timeout for wrenches: if the network between this node and the arm fails, the arm keeps "
    "the last force until its operator leaves the console, presses a pedal or stops it. Run the node on the arm's "
    "computer wherever that is possible (docs/ros2-real-arm.md)"
)
"""Advice at the start of a session that commands an arm over a network."""
_CHECK_PERIOD = 0.1  # interval of the checks of guardian and events [s]


@dataclass(frozen=True)
class Devices:
    """Which devices a session works with, by their CRTK names."""

    leader: str = "MTMR"
    follower: str = "PSM1"
    """`virtual`: no arm; the tool follows the mapped hand exactly."""
    teleop: str = "MTMR_PSM1"
    """The running teleoperation component; `none`: Palpate moves the follower."""
    console: str = "console"
    pair: str = ""
    """Name of the pair: namespace of its nodes."""


@dataclass(frozen=True)
class Limits:
    """Limits and conditions of the force on the hand."""

    force_cap: float | None = None
    """Force cap [N]; the scene's cap, but at most `FORCE_CAP`, when left out."""
    rate: float | None = None
    """Cycle rate [Hz], which the leader's publisher must reach; the scene's when left out."""
    tip_frame: bool = False
    """Send wrenches in the leader's tip frame, and set this on the leader; otherwise in the frame of measured_cp."""
    needs_state: bool = True
    """Require reported operating states, as CRTK does; devices of other makers may report none."""


class HapticLoop:
    """The haptic node and its guardian, with the interface of a session's `Loop`."""

    def __init__(self, rig: Rig, devices: Devices, limits: Limits, context: Mapping[str, Any]) -> None:
        self.native = ros.load(lambda text: print(text, file=sys.stderr))
        self.names, cycle = self._names(devices), self._cycle(rig, devices, limits)
        self.rate = cycle.rate  #: of the cycle [Hz]
        self.force_cap = cycle.stability.force_cap  #: [N]
        mark = f"{os.getpid()}_{secrets.token_hex(3)}"
        writer = f"palpate_writer_{mark}"
        self.guardian = Guardian(f"palpate_guardian_{mark}", self.names.wrench, context)
        try:
            self.context = self.native.Context(**context)
            watch = cycle.watch
            topic = f"/{self.names.leader}/measured_cp"
            measured = jitter.measure(self.native, self.context, topic, watch.stale_after)
            watch.stale_after, advice = jitter.tolerance(measured, watch.stale_after)
            cycle.watch = watch
            self.stale_after = watch.stale_after  #: largest age of a state that is trusted [s]
            offset = jitter.offset_words(measured.offset, watch.stale_after) if measured else ""
            self.told_offset = (
                measured.offset if measured and offset else 0.0
            )  #: offset of the leader's clock that was told [s]
            self.advice = [words for words in (advice, offset) if words]
            options = self.native.HapticNodeOptions(
                self.names, cycle, writer, self.guardian.name, self.guardian.beat_fd
            )
            self.node: Any = self.native.HapticNode(self.context, options, rig.arms.follower, rig.snapshot)
            self.node.set_fixtures(rig.fixtures)
            self.guardian.await_watching()
        except BaseException:
            self.guardian.kill()
            raise
        self._soft = [k for k, obj in enumerate(rig.scene.objects) if obj.tissue is not None]

    def _names(self, devices: Devices) -> Any:
        names = self.native.HapticNames()
        names.leader, names.console = devices.leader.strip("/"), devices.console.strip("/")
        names.follower = "" if devices.follower == "virtual" else devices.follower.strip("/")
        names.teleop = "" if devices.teleop == "none" else devices.teleop.strip("/")
        names.space = f"/{devices.pair}" if devices.pair else ""
        return names

    def _cycle(self, rig: Rig, devices: Devices, limits: Limits) -> _core.CrtkOptions:
        options = rig.options()
        options.rate = limits.rate or options.rate
        stability = options.stability
        cap = stability.force_cap if limits.force_cap is None else limits.force_cap
        if cap > stability.force_cap:
            what = f"--force-cap {cap:g}: the scene was checked for {stability.force_cap:g} N at most"
            raise PalpateError(what, mend="raise stability.force_cap in the scene, and run `palpate certify` on it")
        cap = min(cap, FORCE_CAP) if limits.force_cap is None else cap
        stability.moment_cap *= cap / stability.force_cap
        stability.force_cap = cap
        # A state and a wrench each wait for up to a cycle.
        arm = port.of_arm(rig.arms.leader, rig.arms.q_leader0, options, rig.scene.stability.friction_share)
        port.apply(rig.scene.stability, replace(arm, delay=max(arm.delay, 2.0 / options.rate)), stability)
        options.stability = stability
        if devices.teleop == "none":  # unaligned master: the tool follows relative rotations
            mapping = options.mapping
            mapping.align_rate = 0.0
            options.mapping = mapping
        cycle = _core.CrtkOptions(options, rig.arms.q_follower0)
        cycle.virtual_follower = devices.follower == "virtual"
        cycle.own_teleop = devices.teleop == "none"
        cycle.tip_frame, cycle.needs_state = limits.tip_frame, limits.needs_state
        return cycle

    def start(self) -> None:
        """Start the node; from now on it sends forces."""
        self.node.start()

    def stop(self) -> None:
        """Set the force to zero, end the node and remove it from the network: its guardian works only once."""
        if not isinstance(self.node, EndedNode):
            self.node.stop()
            self.guardian.end()
            self.node = EndedNode(self.node, self._soft)

    def drain(self) -> Any:
        """Ticks since the last call."""
        return self.node.drain()

    def latest(self) -> Any:
        """The newest tick."""
        return self.node.latest()

    def soft_vertices(self, object: int, /) -> Any:
        """Deformed vertices (n, 3) of a soft object, in the object's frame O [m]."""
        return self.node.soft_vertices(object)

    def timing(self) -> dict[str, Any]:
        """`HapticNode.timing`; missed ticks are undefined for a loop that follows its leader, and reported as 0."""
        return {**self.node.timing(), "missed_ticks": 0}

    @property
    def dropped(self) -> int:
        """Number of ticks lost because they were not drained in time."""
        return int(self.node.dropped)

    @property
    def controls(self) -> _core.Controls:
        """The controls, as in `_core.Simulation`."""
        controls: _core.Controls = self.node.controls
        return controls

    @controls.setter
    def controls(self, value: _core.Controls) -> None:
        self.node.controls = value

    def set_snapshot(self, snapshot: _core.Snapshot) -> None:
        """Replace all objects at the next step."""
        self.node.set_snapshot(snapshot)

    def set_live(self, targets: _core.LiveTargets) -> None:
        """Set the poses that the live objects shall reach, at the next step."""
        self.node.set_live(targets)

    def set_fixtures(self, fixtures: _core.FixtureList) -> None:
        """Replace all guidance fixtures at the next step."""
        self.node.set_fixtures(fixtures)

    def fault(self) -> str | None:
        """Always None: the session finds faults in the ticks."""
        return None


def join_bodies(rigs: Mapping[str, Rig], loops: Sequence[HapticLoop]) -> World | None:
    """Put the tools of all loops among the rigid bodies of their scene; None for a scene without bodies.

    A state of the leader and a wrench wait for up to a cycle each, which the coupling counts as delay.

    Raises:
        MissingExtraError, SceneError, MeshError: as `World`.
    """
    rate = min(loop.rate for loop in loops)
    made = held.world(rigs, 2.0 / rate, rate)
    if made is not None:
        joined = made.core(next(iter(rigs.values())).snapshot)
        for tool, loop in enumerate(loops):
            loop.node.join_bodies(joined, tool)
    return made


def as_teleoperated(rig: Rig, devices: Devices) -> tuple[Rig, str]:
    """The scene as a running teleoperation maps it, and a sentence for the user; empty if nothing changes.

    An external teleoperation copies motions from one measured_cp to the other without a rotation:
    p_B += scale (p_L - p_L0). What it maps the leader's axes to are thus the axes of the follower's base, wherever the
    scene has the leader stand, and the force on the hand must be turned in the same way.
    """
    if devices.follower == "virtual" or devices.teleop == "none":
        return rig, ""
    R_BL = rig.arms.X_WB[:3, :3].T @ rig.arms.X_WL[:3, :3]
    turn = np.degrees(np.arccos(np.clip((np.trace(R_BL) - 1.0) / 2.0, -1.0, 1.0)))
    if turn < 0.1:
        return rig, ""
    X_WL = rig.arms.X_WL.copy()
    X_WL[:3, :3] = rig.arms.X_WB[:3, :3]
    words = (
        f"{devices.teleop} copies motions from one measured_cp to the other: the base of {devices.leader} counts as "
        f"turned like that of {devices.follower}, by {turn:.1f} deg from the scene's"
    )
    return replace(rig, arms=replace(rig.arms, X_WL=X_WL)), words


class HapticSession(LiveSession):
    """A real-time session on a CRTK master, whose loop is a ROS 2 node; it runs once.

        with HapticSession(scene, Devices("MTMR", "virtual", "none")) as session:
            session.run(60.0)

    Args:
        scene: scene to render.
        devices: CRTK names of the arms.
        limits: caps and rates.
        out: folder for records; None: no record.
        context: arguments of the ROS context (`network`, `domain`, `arguments`).

    Raises:
        SceneError, MeshError: the scene cannot run. RosMissingError: no ROS 2. OutputError: `out` cannot be written.
    """

    def __init__(
        self,
        scene: Scene,
        devices: Devices | None = None,
        limits: Limits | None = None,
        out: str | os.PathLike[str] | None = None,
        context: Mapping[str, Any] | None = None,
    ) -> None:
        if out is not None:
            require_writable(Path(out))
        self.devices, self.limits = devices or Devices(), limits or Limits()
        rig, turned = as_teleoperated(build(scene), self.devices)
        self._seen = SeenFaults()
        self.seen = self._seen.seen  #: faults by the name of their bit
        self.reports = ForceReports()  #: what holds the force back, told once and counted
        self.loop = HapticLoop(rig, self.devices, self.limits, dict(context or {}))
        advice = [*self.loop.advice, turned, NO_TIMEOUT if (context or {}).get("network") else ""]
        self.events = [words for words in advice if words]  #: events of the node, newest last
        super().__init__(rig, self.loop, self.limits.rate or scene.rates.haptic, scene.seed, out)
        if not self.paired:
            self.world = join_bodies({"": rig}, [self.loop])

    @property
    def state(self) -> State:
        """The newest tick; the phase is empty, as the hand is not simulated."""
        return State(self.latest(), "")

    def run(
        self,
        duration: float | None = None,
        on_progress: Callable[[State], None] | None = None,
    ) -> Summary:
        """Render the scene for a time, or until Ctrl-C or SIGTERM; then close the record.

        Args:
            duration: time [s]; no limit when left out.
            on_progress: called with the state about ten times a second.
        """
        self._require_idle()
        with stop_signals.deferred(self._interrupted):
            try:
                self.start()
                end = time.monotonic() + (np.inf if duration is None else duration)
                while time.monotonic() < end and not self._interrupted.wait(_CHECK_PERIOD):
                    self.check_node()
                    if on_progress is not None:
                        on_progress(self.state)
            except BaseException:
                self.close(interrupted=True)
                raise
            return self.close(interrupted=self._interrupted.is_set())

    @property
    def stopped(self) -> threading.Event:
        """Set: the session ends."""
        return self._interrupted

    def check_node(self) -> None:
        """Take the events of the node, and what its ticks say about the force.

        Raises:
            PalpateError: the guardian process has died; the force is zero.
        """
        self.events += self.loop.node.take_events()
        self._look_at_clock()
        t = float(self.latest()["t"])
        self.events += [f"t = {t:.1f} s: {words}" for words in self.reports.sentences()]
        self.events += [note for note in self.notes if note not in self.events]
        if not self.loop.guardian.alive:
            raise PalpateError("the guardian process has died: the session ends, the force is zero")

    def take_back(self) -> str:
        """Take the shift of the tool against the hand back, which pauses after faults have left; returns a sentence.

        The tool moves at 20 mm/s while it follows the hand and touches nothing.
        """
        shift = np.nan_to_num(self.latest()["p_shift_W"])
        controls = self.loop.controls
        controls.take_back_requests += 1
        self.loop.controls = controls
        words = f"the tool returns by {1e3 * float(np.linalg.norm(shift)):.1f} mm while it touches nothing"
        self.events.append(words)
        return words

    def _look_at_clock(self) -> None:
        """Tell a new offset of the leader's clock."""
        if not self.timing["leader_messages"]:
            return
        offset = float(self.timing["leader_clock_s"])
        if abs(offset - self.loop.told_offset) < jitter.NAMED:
            return
        self.loop.told_offset = offset
        words = jitter.offset_words(offset, self.loop.stale_after)
        self.events.append(words or "the leader's clock agrees with this machine's again")

    def words(self, status: int) -> list[str]:
        """Conditions of a status that forbid a force, the gravest first; empty if a force is allowed."""
        caps = {"force_capped", "rate_capped", "passivity"}
        return [words for name, (bit, words) in STATUS.items() if status & bit and name not in caps]

    def _take(self, ticks: Ticks, realtime: bool = False) -> None:
        self._seen.take(ticks)
        self.reports.take(ticks)
        super()._take(ticks, realtime)

    def _faults(self) -> list[str]:
        self.events += self.loop.node.take_events()
        faults = self._seen.words()
        taken = int(self.timing["guardian_took_over"])
        if taken:
            faults.insert(0, f"the guardian took over {taken} times, as the node was silent")
        return [*faults, *super()._faults()]
