"""Sends the frames of a running session and the felt force to 3D Slicer by OpenIGTLink."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping, Sequence
from typing import Protocol, Self

import numpy as np

from palpate.base.arrays import Array, so3
from palpate.record.ticks import Ticks
from palpate.scene.live_targets import object_poses
from palpate.scene.rig import Rig
from palpate.sensing.trackers import wire
from palpate.sensing.trackers.openigtlink import PORT, OpenIGTLinkServer

RATE = 30.0
"""Rate of the messages [Hz]."""
REPEAT = 2.0
"""All felt points are sent again after this time, for clients that come late [s]."""
SPACING, MOST_POINTS = 1e-3, 2000
"""Smallest distance of two felt points [m], and most points of an object."""


OF_PAIR = ("leader", "follower", "tool")
"""Frames that each pair has for itself."""


class _Session(Protocol):
    rig: Rig

    def latest(self) -> Ticks:
        """The newest tick."""
        ...


class FrameSender:
    """Sends all frames and the force of a session while the context is open, on the loopback interface.

    TRANSFORM messages carry the pose in the world of each frame of the scene, each object, both arms' bases, and the
    `tool`, under the frame's name. The STRING message `force` holds the force on the operator's hand, three numbers in
    the world's axes [N]. With several pairs, `tool`, `force` and the bases of the arms have the name of their pair in
    front: `right tool`. POINT messages hold the places where each object was felt (`FeltPoints`), under the name
    ``felt`` and the object's: they lie on the segmentation of which the object was made. Make it in the main thread.

    Args:
        sessions: the session; of several pairs, their sessions by name.
        port: port of the server; 0 for a free one.

    Raises:
        MissingExtraError: pyigtl is not installed. PortError: the port cannot be used.
    """

    def __init__(self, sessions: _Session | Mapping[str, _Session], port: int = PORT) -> None:
        self._sessions = sessions if isinstance(sessions, Mapping) else {"": sessions}
        self._server, self._felt = OpenIGTLinkServer(port), FeltPoints()
        self._repeated = 0.0
        self.port = self._server.port
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="palpate-openigtlink", daemon=True)
        self._thread.start()

    def __enter__(self) -> Self:
        """The sender itself."""
        return self

    def __exit__(self, *error: object) -> None:
        """Stop sending and free the port."""
        self._stop.set()
        self._thread.join()
        self._server.close()

    def _run(self) -> None:
        while not self._stop.wait(1.0 / RATE):
            ticks = {name: one.latest() for name, one in self._sessions.items()}
            for name, tick in ticks.items():
                self._felt.take(tick, list(object_poses(self._sessions[name].rig, tick).items()))
            if self._server.is_connected:
                now = time.time()
                self._send_poses(now, ticks)
                self._send_points(now)

    def _send_poses(self, now: float, ticks: Mapping[str, Ticks]) -> None:
        found: dict[str, Array] = {}
        for pair, tick in ticks.items():
            rig = self._sessions[pair].rig
            of_pair = {name: f"{pair} {name}".strip() for name in (*OF_PAIR, "force")}
            found |= {of_pair.get(name, name): X for name, X in poses(rig, tick).items()}
            F_H_W = rig.arms.X_WL[:3, :3] @ tick["F_H_L"]
            self._server.send_text(of_pair["force"][: wire.LONGEST_NAME], " ".join(f"{x:.4f}" for x in F_H_W))
        for name, X in found.items():
            self._server.send_pose(name, X, now)

    def _send_points(self, now: float) -> None:
        for name in self._felt.points if now - self._repeated > REPEAT else self._felt.changed:
            points = self._felt.points[name] * [-1.0, -1.0, 1.0]  # LPS to RAS
            self._server.send_points(f"felt {name}"[: wire.LONGEST_NAME], points, now)
        if now - self._repeated > REPEAT:
            self._repeated = now
        self._felt.changed.clear()


class FeltPoints:
    """Where each object was felt, in its own axes: of a mesh from a segmentation these are LPS.

    A point is kept if it is `SPACING` away from all before; an object keeps `MOST_POINTS`.
    """

    def __init__(self) -> None:
        self.points: dict[str, Array] = {}
        """Points (n, 3) [m] by the name of the object."""
        self.changed: set[str] = set()
        """Names of the objects with new points."""

    def take(self, tick: Ticks, objects: Sequence[tuple[str, Array]]) -> None:
        """Keep where the tool touches now.

        Args:
            tick: a tick.
            objects: name and X_WO (4, 4) [m] of each object at this tick, in the order of the scene.
        """
        places = np.reshape(tick["p_WC"], (-1, 3))
        for k in range(min(int(tick["contacts"]), len(places))):
            name, X_WO = objects[int(tick["touch_object"][k])]
            p_OC = (places[k] - X_WO[:3, 3]) @ X_WO[:3, :3]
            known = self.points.get(name, np.empty((0, 3)))
            if len(known) < MOST_POINTS and not (np.linalg.norm(known - p_OC, axis=1) < SPACING).any():
                self.points[name] = np.vstack((known, p_OC))
                self.changed.add(name)


def poses(rig: Rig, tick: Ticks) -> dict[str, Array]:
    """Pose in W (4, 4) [m] of all frames, objects, bases and of the tool at a tick."""
    found = {name: rig.frames.pose(name).X for name in rig.frames.frames[1:]}
    found |= object_poses(rig, tick)
    found["tool"] = so3.pose(tick["p_WT"], tick["quat_WT"])
    return found
