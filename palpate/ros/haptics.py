"""A scene felt on a real or simulated CRTK master: a session whose arms are on ROS 2."""

from __future__ import annotations

import os
import secrets
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from palpate import _core, ros
from palpate.errors import PalpateError
from palpate.record.ticks import STATUS, Ticks
from palpate.ros.guardian import Guardian
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate.session import LiveSession, State
from palpate.session.run_folder import require_writable
from palpate.session.summary import Summary

FORCE_CAP = 1.0
"""Of arms that are real: a scene may ask for more only by name (--force-cap) [N]."""
_LOOK = 0.1  # between two looks at the guardian and the news [s]
_OWN = {"not_following", "clutched", "force_capped", "rate_capped", "passivity", "ik_failed"}  # no faults


@dataclass(frozen=True)
class Devices:
    """Which devices a session works with, by their CRTK names."""

    leader: str = "MTMR"
    follower: str = "PSM1"
    """`virtual`: there is none, the tool is where the map puts it."""
    teleop: str = "MTMR_PSM1"
    """The teleoperation component that runs; `none`: ours."""
    console: str = "console"


@dataclass(frozen=True)
class Limits:
    """What the hand may be given, and when."""

    force_cap: float | None = None
    """Instead of the smaller of the scene's and `FORCE_CAP` [N]."""
    rate: float | None = None
    """Of the cycle, which the leader's publisher must keep up with; the scene's when left out [Hz]."""
    tip_frame: bool = False
    """Wrenches in the leader's tip frame, which it is told; otherwise in that of its measured_cp."""
    needs_state: bool = True
    """Operating states must be told: CRTK says so, a device of another maker may not."""


@dataclass
class Seen:
    """When a fault was first seen, and for how many ticks [s]."""

    first: float
    ticks: int = field(default=0)


class HapticLoop:
    """The node with its guardian, as a `Loop` of a session."""

    def __init__(self, rig: Rig, devices: Devices, limits: Limits, context: Mapping[str, Any]) -> None:
        self.native = ros.load(lambda text: print(text, file=sys.stderr))
        self.names, cycle = self._names(devices), self._cycle(rig, devices, limits)
        self.force_cap = cycle.stability.force_cap  #: [N]
        mark = f"{os.getpid()}_{secrets.token_hex(3)}"
        writer = f"palpate_writer_{mark}"
        self.guardian = Guardian(f"palpate_guardian_{mark}", self.names.wrench, context)
        try:
            options = self.native.HapticNodeOptions(
                self.names, cycle, writer, self.guardian.name, self.guardian.beat_fd
            )
            self.context = self.native.Context(**context)
            self.node = self.native.HapticNode(self.context, options, rig.arms.follower, rig.snapshot)
            self.node.set_fixtures(rig.fixtures)
            self.guardian.await_watching()
        except BaseException:
            self.guardian.kill()
            raise
        self._ended = False

    def _names(self, devices: Devices) -> Any:
        names = self.native.HapticNames()
        names.leader, names.console = devices.leader.strip("/"), devices.console.strip("/")
        names.follower = "" if devices.follower == "virtual" else devices.follower.strip("/")
        names.teleop = "" if devices.teleop == "none" else devices.teleop.strip("/")
        return names

    def _cycle(self, rig: Rig, devices: Devices, limits: Limits) -> _core.CrtkOptions:
        if "virtual" not in devices.follower and devices.teleop != "none":
            _require_aligned(rig)
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
        stability.delay = max(stability.delay, 2.0 / options.rate)  # state to us, wrench to the arm's next cycle
        options.stability = stability
        if devices.teleop == "none":  # a master that nobody has aligned: the tool turns as it does, not to where it is
            mapping = options.mapping
            mapping.align_rate = 0.0
            options.mapping = mapping
        cycle = _core.CrtkOptions(options, rig.arms.q_follower0)
        cycle.virtual_follower = devices.follower == "virtual"
        cycle.own_teleop = devices.teleop == "none"
        cycle.tip_frame, cycle.needs_state = limits.tip_frame, limits.needs_state
        return cycle

    def start(self) -> None:
        """From here on it pushes."""
        self.node.start()

    def stop(self) -> None:
        """Force to zero, then the end: for good, as a guardian guards once."""
        if not self._ended:
            self._ended = True
            self.node.stop()
            self.guardian.end()

    def drain(self) -> Any:
        """Rows since the last drain."""
        return self.node.drain()

    def latest(self) -> Any:
        """The newest row."""
        return self.node.latest()

    def timing(self) -> dict[str, Any]:
        """`HapticNode.timing`; missed ticks are not known to a loop that follows its leader."""
        return {**self.node.timing(), "missed_ticks": 0}

    @property
    def dropped(self) -> int:
        """Rows lost because nobody drained."""
        return int(self.node.dropped)

    @property
    def controls(self) -> _core.Controls:
        """As of `_core.Simulation`."""
        controls: _core.Controls = self.node.controls
        return controls

    @controls.setter
    def controls(self, value: _core.Controls) -> None:
        self.node.controls = value

    def set_snapshot(self, snapshot: _core.Snapshot) -> None:
        """Another scene, whole, at the next step."""
        self.node.set_snapshot(snapshot)

    def set_fixtures(self, fixtures: _core.Fixtures) -> None:
        """Other fixtures of guidance, whole, at the next step."""
        self.node.set_fixtures(fixtures)

    def fault(self) -> str | None:
        """Told by the session, from the ticks."""
        return None


def _require_aligned(rig: Rig) -> None:
    """Somebody else's teleoperation moves the tool as the hand, each in its own base: p_B += scale (p_L - p_L0).

    Raises:
        PalpateError: the scene's bases are turned against each other, the force would come from another side.
    """
    R_BL = rig.arms.X_WB[:3, :3].T @ rig.arms.X_WL[:3, :3]
    turn = np.degrees(np.arccos(np.clip((np.trace(R_BL) - 1.0) / 2.0, -1.0, 1.0)))
    if turn > 0.1:
        raise PalpateError(
            f"the bases of leader and follower are turned against each other by {turn:.1f} deg in the scene",
            why="a teleoperation that runs moves the tool as the hand, number for number between their measured_cp",
            mend="give arms.leader.base and arms.follower.base the same rpy_deg, or --teleop none",
        )


class HapticSession(LiveSession):
    """A scene felt on a CRTK master: a session in real time whose loop is a node on ROS 2, for one run.

        with palpate.ros.HapticSession(scene, Devices("MTMR", "virtual", "none")) as session:
            session.run(60.0)

    Args:
        scene: what to feel.
        devices: on which arms.
        limits: caps and rates.
        out: folder for records; None: nothing is recorded.
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
        rig = build(scene)
        self.devices, self.limits = devices or Devices(), limits or Limits()
        self.seen: dict[str, Seen] = {}  #: faults by the name of their bit
        self.told: list[str] = []  #: what the node had to say, newest last
        self.loop = HapticLoop(rig, self.devices, self.limits, dict(context or {}))
        super().__init__(rig, self.loop, self.limits.rate or scene.rates.haptic, scene.seed, out)

    @property
    def state(self) -> State:
        """The newest tick; the hand is a person's, its phase unknown."""
        return State(self.latest(), "")

    def run(
        self,
        duration: float | None = None,
        on_progress: Callable[[State], None] | None = None,
    ) -> Summary:
        """Feel for a while, or until Ctrl-C or SIGTERM; then close the record.

        Args:
            duration: time [s]; without an end when left out.
            on_progress: told the state about ten times a second.
        """
        self._require_idle()
        with self._ctrl_c_waits():
            try:
                self.start()
                end = time.monotonic() + (np.inf if duration is None else duration)
                while time.monotonic() < end and not self._interrupted.wait(_LOOK):
                    self._look()
                    if on_progress is not None:
                        on_progress(self.state)
            except BaseException:
                self.close(interrupted=True)
                raise
            return self.close(interrupted=self._interrupted.is_set())

    def _look(self) -> None:
        self.told += self.loop.node.news()
        if not self.loop.guardian.alive:
            raise PalpateError("the guardian process has died: the session ends, the force is zero")

    def words(self, status: int) -> list[str]:
        """What forbids a force now, the gravest first; empty when nothing does."""
        caps = {"force_capped", "rate_capped", "passivity"}
        return [words for name, (bit, words) in STATUS.items() if status & bit and name not in caps]

    def _take(self, ticks: Ticks, realtime: bool = False) -> None:
        status, t = ticks["status"].astype(np.int64), ticks["t"]
        for name, (bit, _) in STATUS.items():
            hits = np.flatnonzero(status & bit)
            if len(hits) and name not in _OWN:
                self.seen.setdefault(name, Seen(float(t[hits[0]]))).ticks += len(hits)
        super()._take(ticks, realtime)

    def _faults(self) -> list[str]:
        self.told += self.loop.node.news()
        faults = [
            f"{STATUS[name][1]} (first at t = {seen.first:.3f} s, {seen.ticks} ticks)"
            for name, seen in self.seen.items()
        ]
        taken = int(self.timing["guardian_took_over"])
        if taken:
            faults.insert(0, f"the guardian took over {taken} times, as the node was silent")
        return [*faults, *super()._faults()]
