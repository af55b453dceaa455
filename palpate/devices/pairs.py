"""A session of several pairs of which some are felt on devices: each device with its own loop, thread and watchdog."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from itertools import combinations
from pathlib import Path

import numpy as np

from palpate import _core
from palpate.base.errors import DeviceError, SceneError, StateError
from palpate.base.values import Pose
from palpate.devices.leader import Leader, leader_of
from palpate.devices.loop import DeviceLoop, mapped_rig
from palpate.devices.session import DeviceSession
from palpate.scene import held
from palpate.scene.rig import Rig
from palpate.scene.scene import Scene
from palpate.scene.surface import Bodies
from palpate.scene.together import Rigs, build_pairs
from palpate.session.pair import Paired, Run
from palpate.session.pairs import PairsSession, States
from palpate.session.pairs_summary import PairsSummary

_APART = 0.3
"""Distance along x at which devices are drawn whose place nobody states [m]."""


class DevicePair(Paired, DeviceSession):
    """The session of one pair that is felt on a device."""

    def __init__(self, name: str, loop: DeviceLoop, out: Path | None, run: Run) -> None:
        self._enter(name, run, loop.rig.scene.rates.haptic)
        super().__init__(loop, out)

    @property
    def joined(self) -> _core.DeviceCycle:
        """The cycle of the device."""
        assert isinstance(self._loop, DeviceLoop)
        return self._loop.cycle


class DrivenPairs(PairsSession):
    """Runs all pairs of a scene in real time: those with a driver are felt on their devices, the others simulated.

        scene = palpate.Scene.load("my_two_hands.yaml")
        summary = palpate.devices.DrivenPairs(scene, out="runs").run(60.0)

    Each device has a thread and a watchdog of its own, at its own rate. A device that fails ends its pair with zero
    force; its instrument then rests where it was, and the other pairs go on.

    Args:
        scene: a scene with the section `pairs`, of which at least one has ``arms.leader.driver``.
        out: folder for records, in which each run gets a folder with one record per pair; None: nothing is recorded.
        seed: seed of the simulated hands; the scene's when left out.

    Raises:
        DeviceError: a driver is missing, invalid or not trusted; two pairs have the same device or the same grip.
        SceneError, MeshError: the scene cannot run. OutputError: `out` cannot be written.
    """

    leaders: dict[str, Leader]
    """The devices by the names of their pairs."""

    def run(
        self,
        duration: float | None = None,
        realtime: bool = True,
        on_progress: Callable[[States], None] | None = None,
    ) -> PairsSummary:
        """Run all pairs for a time, or until Ctrl-C; then close the records.

        Args:
            duration: time [s]; no limit when left out.
            realtime: True: a device has no other time.
            on_progress: called with the states of all pairs about ten times a second.

        Raises:
            StateError: `realtime` is False.
        """
        if not realtime:
            raise StateError("a device cannot run in lockstep", mend="run in real time")
        return super().run(np.inf if duration is None else duration, True, on_progress)

    def _end_of_run(self, seconds: float) -> Callable[[], bool]:
        """By the clock, not by the ticks: a device whose service is late has fewer of them."""
        end = time.monotonic() + seconds
        return lambda: time.monotonic() >= end or all(session.ended is not None for session in self.pairs.values())

    def step(self, n: int = 1) -> States:
        """Refused: a device has no lockstep."""
        raise StateError("a device cannot be stepped", mend="call run() or start()")

    def _build(self, scene: Scene) -> Rigs:
        """Open the devices, then build the rigs of all pairs."""
        held.refuse_graspable(scene)
        if scene.bodies:
            what = "bodies are not moved by several hands of which one is on a device"
            raise SceneError(what, where=scene.where("bodies"), mend="leave them out, use one device, or simulate both")
        self.leaders = {}
        for name, one in scene.each_pair().items():
            if one.arms.leader.driver is not None:
                try:
                    self.leaders[name] = leader_of(one)
                except DeviceError as error:
                    where = error.where or one.where("arms", "leader", "driver")
                    raise DeviceError(
                        f"pair {name}: {error.what}", where=where, why=error.why, mend=error.mend
                    ) from None
        _require_different(self.leaders)
        made_by = {name: _builder(leader, i) for i, (name, leader) in enumerate(self.leaders.items())}
        return build_pairs(scene, made_by=made_by)

    def _pair(self, name: str, rig: Rig, seed: int) -> Paired:
        leader = self.leaders.get(name)
        return super()._pair(name, rig, seed) if leader is None else DevicePair(name, leader.loop(rig), self._out, self)

    def _begin_anew(self, changed: Callable[[], Scene], why_not: str) -> None:
        what = "followers and instruments of devices cannot be exchanged in a session"
        raise StateError(what, mend="exchange them in the scene, and run it again")


def _builder(leader: Leader, index: int) -> Callable[[Scene, Bodies], Rig]:
    """What builds the rig of a device; devices without a place are drawn beside each other."""

    def build(scene: Scene, bodies: Bodies) -> Rig:
        rig = mapped_rig(leader.scene, leader.workspace, bodies)
        section = leader.scene.arms.leader
        if index == 0 or section.base is not None or section.frame != "world":
            return rig
        x, y, z = rig.arms.X_WL[:3, 3].tolist()
        moved = section.model_copy(update={"base": Pose(xyz=(x + index * _APART, y, z))})
        arms = leader.scene.arms.model_copy(update={"leader": moved})
        return mapped_rig(leader.scene.model_copy(update={"arms": arms}), leader.workspace, bodies)

    return build


def _require_different(leaders: Mapping[str, Leader]) -> None:
    for (one, a), (other, b) in combinations(leaders.items(), 2):
        for part in set(a.hardware) & set(b.hardware):
            what = f"the pairs {one} and {other} both have {part}"
            mend = "name another device by its serial number, or another grip: driver: {haply: {id: 04C3, grip: none}}"
            raise DeviceError(what, where=b.scene.where("arms", "leader", "driver"), mend=mend)
