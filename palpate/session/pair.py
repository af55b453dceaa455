"""The session of one of several pairs in one run."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np

from palpate.base.arrays import Array
from palpate.record.snapshots import Snapshot
from palpate.record.ticks import Ticks
from palpate.scene.rig import Rig
from palpate.scene.together import Rigs
from palpate.session.camera import CameraArm
from palpate.session.pairs_summary import Met
from palpate.session.plants import Plant
from palpate.session.session import Session
from palpate.world.bodies.engine import World

if TYPE_CHECKING:
    from palpate.planning.live_world import Neighbour
    from palpate.planning.problem import Problem
    from palpate.sensing.source import CloudFrame


class Run(Protocol):
    """The run to which the pairs belong."""

    def new_met(self, rate: float) -> Met:
        """An empty account of meetings, for ticks at a rate [Hz]."""
        ...

    def run_folder(self) -> Path:
        """Folder of the run."""
        ...

    def keeps_shapes(self, name: str) -> bool:
        """True if the record of this pair holds the soft objects and rigid bodies that all pairs touch."""
        ...

    @property
    def camera(self) -> CameraArm | None:
        """The endoscope arm that the hands of all pairs steer."""
        ...

    @property
    def world(self) -> World | None:
        """The rigid bodies that the tools of all pairs touch."""
        ...

    @property
    def rigs(self) -> Rigs:
        """The rigs of all pairs."""
        ...

    @property
    def pairs(self) -> Mapping[str, PairSession]:
        """The sessions of all pairs."""
        ...


class PairSession(Session):
    """One of several pairs. Its record lies in a folder with the pair's name, in the folder of the run.

    Args:
        name: name of the pair.
        plant: where its hand is.
        rig: its rig, which shares the objects with those of the others.
        seed, out: as for `Session`.
        run: the run to which it belongs.
    """

    paired = True

    def __init__(self, name: str, plant: Plant, rig: Rig, seed: int, out: Path | None, run: Run) -> None:
        self.name, self._run = name, run
        self.met = run.new_met(rig.scene.rates.haptic)  #: how the pair met the others since its record began
        super().__init__(rig.scene, out, seed, rig=rig, plant=plant)

    @property
    def ended(self) -> str | None:
        """Why the loop of the pair ended by itself; None if it did not."""
        return self._loop.fault()

    def _own_camera(self) -> CameraArm | None:
        return None  # the pairs of a run have one camera, which all hands steer

    @property
    def camera_arm(self) -> CameraArm | None:
        """The endoscope arm that all pairs share."""
        return self._run.camera

    def note(self, words: str) -> None:
        """Add a problem outside of the loop to the faults of the summary."""
        self._note(words)

    def prepare(self) -> None:
        """Open the record of a run in real time, so that all pairs can start together."""
        self._begin(realtime=True)

    @property
    def taken(self) -> int:
        """Number of ticks of all records."""
        return self._taken

    @property
    def stopped(self) -> threading.Event:
        """Set: the run ends early."""
        return self._interrupted

    def take(self, ticks: Ticks, behind: bool) -> None:
        """Add ticks (n,) in lockstep to the summary and the record, in a thread behind the loop if `behind`."""
        (self._take_behind if behind else self._take)(ticks)

    def _keep(self, ticks: Ticks, snapshots: list[Snapshot]) -> None:
        super()._keep(ticks, snapshots)
        self.met.add(ticks)

    def _problem(self) -> Problem:
        from palpate.planning.problem import Problem

        return Problem.of_pair(self._run.rigs, self.name)

    def _neighbours(self) -> Sequence[Neighbour]:
        from palpate.planning.problem import neighbour

        others = {name: session for name, session in self._run.pairs.items() if name != self.name}
        return [(neighbour(name, session.rig), session.joints) for name, session in others.items()]

    def joints(self) -> Array:
        """The newest joint positions (n,) of the follower [rad, m]."""
        return np.asarray(self.latest()["q_follower"])[: self.rig.arms.follower.n]

    def _body_places(self) -> Mapping[str, Array]:
        return {} if self._run.world is None else self._run.world.drawn()

    def take_cloud(self, name: str, frame: CloudFrame, now: float) -> None:
        """As for one session, in the record of the pair that holds what all pairs touch."""
        if self._run.keeps_shapes(self.name):
            super().take_cloud(name, frame, now)

    def _take_snapshot(self, t: float) -> None:
        self._snapshots.take(t, shapes=self._run.keeps_shapes(self.name))

    def _new_folder(self) -> Path:
        folder = self._run.run_folder() / self.name
        folder.mkdir()
        return folder
