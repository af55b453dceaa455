"""The loop of a real or simulated CRTK master over ROS 2: a haptic node and its guardian."""

from __future__ import annotations

import os
import secrets
import sys
import threading
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from palpate import _core, ros
from palpate.base.errors import PalpateError
from palpate.record.ticks import Ticks, as_tick
from palpate.ros import jitter
from palpate.ros.ended_node import EndedNode
from palpate.ros.guardian import Guardian
from palpate.scene import port
from palpate.scene.rig import Rig

FORCE_CAP = 1.0
"""Default force cap on real arms [N]; only --force-cap can raise it."""


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
        self._ending = threading.RLock()
        self._fault: str | None = None
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
        with self._ending:
            if not isinstance(self.node, EndedNode):
                self.node.stop()
                self.guardian.end()
                self.node = EndedNode(self.node, self._soft)

    def drain(self) -> Any:
        """Ticks since the last call; ends the node if its guardian process has died, without which it sends none."""
        with self._ending:
            if not isinstance(self.node, EndedNode) and not self.guardian.alive:
                self._fault = "the guardian process has died: the force was set to zero"
                self.stop()
            return self.node.drain()

    def latest(self) -> Any:
        """The newest tick."""
        return self.node.latest()

    def latest_tick(self) -> Ticks:
        """The newest tick, with its fields by name."""
        return as_tick(self.latest())

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
        """Why the node ended by itself; what removes the force for a time is in the ticks."""
        return self._fault
