"""A tracked pointer: the mean pose of its tip while it rests, in the world."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from palpate.base.arrays import Array, rigid
from palpate.base.errors import RegistrationError, SceneError
from palpate.scene.scene import Scene
from palpate.sensing.trackers.gate import Gate, Limits
from palpate.sensing.trackers.tracker import Tracker
from palpate.world.frames import FrameGraph

READINGS = 20
"""Readings that are averaged."""
_LONGEST = 3.0  # time in which they must arrive [s]
_STILL = 1.5e-3  # largest rms motion of the tip while it is read [m]


class TrackedPointer:
    """The tip of a tool that a tracker sees.

    Args:
        scene: scene with `registration.pointer`.
        graph: its frames.
        tracker: the tracker that sees the tool.
        clock: present time [s].
        wait: waits for a time [s].

    Raises:
        SceneError: the pointer's frame is not tracked.
    """

    def __init__(
        self,
        scene: Scene,
        graph: FrameGraph,
        tracker: Tracker,
        clock: Callable[[], float] = time.monotonic,
        wait: Callable[[float], None] = time.sleep,
    ) -> None:
        pointer = scene.registration.pointer if scene.registration is not None else None
        section = next((one for one in scene.frames if pointer is not None and one.child == pointer.frame), None)
        if pointer is None or section is None or section.tracker is None:
            what = "the pointer's frame is not tracked"
            mend = "give frames an entry with child: pointer, tracker: NAME"
            raise SceneError(what, where=scene.where("registration", "pointer"), mend=mend)
        edge = graph.edge(section.child)
        self._tool, self._X_KT0, self._limits = section.tool or section.child, edge.X, scene.trackers[section.tracker]
        self._X_WK = graph.pose(edge.parent).X
        self._tip = np.array(pointer.tip)
        self._tracker, self._clock, self._wait, self._began = tracker, clock, wait, clock()
        self.radius = pointer.radius  #: of the tip [m]

    def read(self) -> Array:
        """Pose (4, 4) in W of the pointer with its origin at the tip, the mean of several readings [m].

        Raises:
            RegistrationError: too few good poses arrive, or the pointer moves.
        """
        limits = Limits(self._limits.max_age, 1e-3 * self._limits.max_error_mm)
        gate, end = Gate(self._tool, self._X_KT0, limits), self._clock() + _LONGEST
        self._tracker.poll(self._clock() - self._began)  # readings from before are of another place
        poses: list[Array] = []
        while len(poses) < READINGS and self._clock() < end:
            self._wait(0.02)
            now = self._clock() - self._began
            for seen in self._tracker.poll(now):
                if seen.tool == self._tool and gate.take(seen, now):
                    poses.append(gate.X)
        if len(poses) < READINGS:
            state = gate.status(self._clock() - self._began)
            raise RegistrationError(
                f"{len(poses)} of {READINGS} poses of {self._tool!r} arrived in {_LONGEST:g} s",
                why=state, mend="turn the marker towards the tracker, and try again",
            )  # fmt: skip
        return self._X_WK @ self._mean(np.array(poses))

    def _mean(self, X: Array) -> Array:
        tips = X[:, :3, :3] @ self._tip + X[:, :3, 3]
        moved = float(np.sqrt(np.square(tips - tips.mean(axis=0)).sum(axis=1).mean()))
        if moved > _STILL:
            what = f"the tip moved by {1e3 * moved:.1f} mm rms while it was read"
            raise RegistrationError(what, mend="hold the pointer still, and try again")
        turns = rigid.log(X[:, :3, :3] @ X[0, :3, :3].T).mean(axis=0)
        return rigid.rigid(rigid.exp(turns) @ X[0, :3, :3], tips.mean(axis=0))
