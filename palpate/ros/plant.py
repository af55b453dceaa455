"""A CRTK master, real or simulated, as the plant of a session; its loop is a ROS 2 node."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from palpate import _core
from palpate.base.errors import PalpateError
from palpate.record.ticks import Ticks
from palpate.ros import jitter
from palpate.ros.haptics import Devices, HapticLoop, Limits
from palpate.ros.reports import ForceReports
from palpate.scene import held
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate.scene.surface import Bodies
from palpate.scene.together import Joined
from palpate.session import Session
from palpate.world.bodies.engine import World

NO_TIMEOUT = (
    "an arm of the dVRK has no timeout for wrenches: if the network between this node and the arm fails, the arm keeps "
    "the last force until its operator leaves the console, presses a pedal or stops it. Run the node on the arm's "
    "computer wherever that is possible (docs/ros2-real-arm.md)"
)
"""Advice at the start of a session that commands an arm over a network."""


class CrtkPlant:
    """A master that leads in a session (`palpate.session.plants.Plant`). Its node runs once.

        plant = CrtkPlant(scene, Devices("MTMR", "virtual", "none"))
        with palpate.Session(scene, plant=plant) as session:
            session.run(60.0)

    Args:
        scene: scene to render, of one pair.
        devices: CRTK names of the arms.
        limits: caps and rates.
        context: arguments of the ROS context (`network`, `domain`, `arguments`).
    """

    simulated = False
    driver = None
    buttons = 0

    def __init__(
        self,
        scene: Scene,
        devices: Devices | None = None,
        limits: Limits | None = None,
        context: Mapping[str, Any] | None = None,
    ) -> None:
        self.devices, self.limits = devices or Devices(), limits or Limits()
        rate = self.limits.rate or scene.rates.haptic
        self.scene = scene.model_copy(update={"rates": scene.rates.model_copy(update={"haptic": rate})})
        followers = () if self.devices.follower == "virtual" else (self.devices.follower,)
        self.hardware = (self.devices.leader, *followers)
        self.lag = 2.0 / rate
        self.reports = ForceReports()  #: what holds the force back, told once and counted
        self.events: list[str] = []  #: what has happened on the network and to the force, newest last
        driver = scene.arms.leader.driver
        if driver is not None:
            self.events.append(f"the scene's driver {driver} is not used: the hand is on {self.devices.leader}")
        self.world: World | None = None
        self._context = dict(context or {})
        self._loop: HapticLoop | None = None
        self._turned = ""

    def build(self, bodies: Bodies | None = None, index: int = 0) -> Rig:
        """The rig of the scene, as a running teleoperation maps it."""
        rig, self._turned = as_teleoperated(build(self.scene, bodies), self.devices)
        return rig

    def begin(self, rig: Rig, seed: int, shared: bool) -> HapticLoop:
        """Find the arm, and make its node and guardian; an arm takes no seed.

        Raises:
            RosMissingError: no ROS 2. PalpateError: the force cap is above the scene's.
        """
        self._loop = HapticLoop(rig, self.devices, self.limits, self._context)
        advice = [*self._loop.advice, self._turned, NO_TIMEOUT if self._context.get("network") else ""]
        self.events += [words for words in advice if words]
        if not shared:
            try:
                self.world = held.join({"": rig}, [self.joined], self.lag, self.scene.rates.haptic)
            except BaseException:
                self._loop.stop()
                raise
        return self._loop

    @property
    def loop(self) -> HapticLoop:
        """The loop, once `begin` has made it."""
        assert self._loop is not None
        return self._loop

    @property
    def joined(self) -> Joined:
        """The node, before it has ended."""
        node: Joined = self.loop.node
        return node

    def phase(self, t: float) -> str:
        """Empty: the hand is not simulated."""
        return ""

    def look(self) -> None:
        """Take the events of the node, a new offset of the leader's clock, and what its ticks say about the force."""
        self.events += self.loop.node.take_events()
        self._look_at_clock()
        t = float(self.loop.latest_tick()["t"])
        self.events += [f"t = {t:.1f} s: {words}" for words in self.reports.sentences()]

    def see(self, ticks: Ticks) -> None:
        """Count what holds the force back in ticks."""
        self.reports.take(ticks)

    def notices(self) -> list[str]:
        """How often the guardian took over."""
        self.look()
        taken = int(self.loop.timing()["guardian_took_over"])
        return [f"the guardian took over {taken} times, as the node was silent"] if taken else []

    def attach(self, remote: _core.RemoteEnd | None) -> None:
        """Refuse a link.

        Raises:
            PalpateError: always.
        """
        raise PalpateError("this session does not run across a network", mend="use the loop of an arm or a device")

    def take_back(self) -> str:
        """Take the shift of the tool against the hand back, which pauses after faults have left; returns a sentence.

        The tool moves at 20 mm/s while it follows the hand and touches nothing.
        """
        shift = np.nan_to_num(self.loop.latest_tick()["p_shift_W"])
        controls = self.loop.controls
        controls.take_back_requests += 1
        self.loop.controls = controls
        words = f"the tool returns by {1e3 * float(np.linalg.norm(shift)):.1f} mm while it touches nothing"
        self.events.append(words)
        return words

    def _look_at_clock(self) -> None:
        """Tell a new offset of the leader's clock."""
        timing, loop = self.loop.timing(), self.loop
        if not timing["leader_messages"]:
            return
        offset = float(timing["leader_clock_s"])
        if abs(offset - loop.told_offset) < jitter.NAMED:
            return
        loop.told_offset = offset
        words = jitter.offset_words(offset, loop.stale_after)
        self.events.append(words or "the leader's clock agrees with this machine's again")


class News:
    """What a session on an arm has to tell, each sentence once.

    Args:
        session: a session whose plant is a `CrtkPlant`, or another one, which has only its notes.
    """

    def __init__(self, session: Session) -> None:
        self._session, self._told = session, [0, 0]

    def take(self) -> list[str]:
        """The sentences since the last call, oldest first."""
        plant = self._session.plant
        events = plant.events if isinstance(plant, CrtkPlant) else []
        fresh = []
        for k, words in enumerate((events, self._session.notes)):
            now = len(words)
            fresh += words[self._told[k] : now]
            self._told[k] = now
        return fresh


def plant_of(session: Session) -> CrtkPlant:
    """The arm of a session.

    Raises:
        PalpateError: its hand is elsewhere.
    """
    if not isinstance(session.plant, CrtkPlant):
        mend = "give palpate.Session plant=CrtkPlant(scene, Devices(...))"
        raise PalpateError("the hand of this session is on no arm of ROS 2", mend=mend)
    return session.plant


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
