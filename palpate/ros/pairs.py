"""All pairs of a scene on ROS 2, in one process."""

from __future__ import annotations

import os
import threading
import weakref
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Self

from palpate import ros
from palpate.base.errors import PalpateError
from palpate.ros.haptics import Devices, HapticSession, Limits, join_bodies
from palpate.scene.scene import Scene
from palpate.scene.together import build_pairs, capsules
from palpate.session.console import Console
from palpate.session.summary import Summary
from palpate.world.bodies.engine import World


class PairedHapticSession(HapticSession):
    """The session of one of several pairs, whose record holds the contact with the other instruments."""

    paired = True


class HapticPairs:
    """Haptic nodes of several pairs with one console; their instruments push each other.

        with HapticPairs(scene, out="runs") as pairs, PedalTopics(pairs.console, pairs.domain):
            pairs.start()
            pairs.console.press("clutch")              # for all hands

    Every pair has its own nodes, guardian process and record; a node that fails ends alone.

    Args:
        scene: a scene with the section `pairs`, each with `devices`.
        limits: caps and rates of every pair.
        only: names of the pairs to run; all when left out. The other pairs' instruments are not known here.
        console: CRTK name of the console.
        out: folder for records, which gets a folder for each pair; None: no record.
        context: arguments of the ROS context (`network`, `domain`, `arguments`).

    Raises:
        SceneError, MeshError: the scene cannot run, or arms stand in each other. PalpateError: a pair does not name its
        arms. RosMissingError: no ROS 2. OutputError: `out` cannot be written.
    """

    def __init__(
        self,
        scene: Scene,
        limits: Limits | None = None,
        only: Sequence[str] = (),
        console: str = "console",
        out: str | os.PathLike[str] | None = None,
        context: Mapping[str, Any] | None = None,
    ) -> None:
        require_devices(scene)
        rigs = build_pairs(scene)  # refuses arms that stand in each other before anything moves
        self.sessions: dict[str, HapticSession] = {}
        self.world: World | None = None  #: the rigid bodies of the scene; None: it has none
        try:
            for name in only or scene.pairs:
                devices = scene.pairs[name].devices
                assert devices is not None
                self.sessions[name] = PairedHapticSession(
                    scene.pair(name),
                    Devices(devices.leader, devices.follower, devices.teleop, console, name),
                    limits,
                    None if out is None else Path(out) / name,
                    context,
                )
            self._join(scene, [capsules(rigs[name]) for name in self.sessions])
            first, loops = next(iter(self.sessions.values())), [one.loop for one in self.sessions.values()]
            first.world = self.world = join_bodies({name: one.rig for name, one in self.sessions.items()}, loops)
            if self.world is not None:
                self.world.threaded = False  # its thread goes on when the first node fails
        except BaseException:
            self.close(interrupted=True)
            raise
        #: pedals, presence, locks and scale for the hands of all pairs
        self.console = Console([weakref.proxy(session) for session in self.sessions.values()])
        for session in self.sessions.values():
            session.console = self.console

    def _join(self, scene: Scene, tools: list[Any]) -> None:
        """Put the instruments of all pairs into one world."""
        law, nodes = scene.instruments, [session.loop.node for session in self.sessions.values()]
        if len(nodes) > 1 and law.stiffness > 0.0:
            ros.load().join_nodes(nodes, tools, law.stiffness, law.damping)

    @property
    def domain(self) -> int:
        """ROS domain of the nodes."""
        return int(next(iter(self.sessions.values())).loop.context.domain)

    @property
    def stopped(self) -> threading.Event:
        """Set: the run ends."""
        return next(iter(self.sessions.values())).stopped

    def start(self) -> None:
        """Start the nodes; from now on they send forces."""
        if self.world is not None:
            self.world.core_bodies.start()
        for session in self.sessions.values():
            session.start()

    def close(self, interrupted: bool = False) -> dict[str, Summary]:
        """Stop all nodes with their forces at zero, close the records and return the summaries."""
        summaries = {name: session.close(interrupted) for name, session in self.sessions.items()}
        if self.world is not None:
            self.world.core_bodies.stop()
        return summaries

    def __enter__(self) -> Self:
        """Return the object itself."""
        return self

    def __exit__(self, *error: object) -> None:
        """Close the sessions."""
        self.close()


def require_devices(scene: Scene) -> None:
    """Refuse a scene in which a pair does not name its arms.

    Raises:
        PalpateError: the message names the pair and the line.
    """
    for name, pair in scene.pairs.items():
        if pair.devices is None:
            raise PalpateError(
                f"pair {name} does not name its arms on ROS 2",
                where=scene.where("pairs", name),
                mend="add devices: {leader: MTML, follower: PSM2, teleop: MTML_PSM2}",
            )
