"""Sends the frames of a running session and the felt force to 3D Slicer by OpenIGTLink."""

from __future__ import annotations

import threading
import time
from typing import Protocol, Self

from palpate.arrays import Array, so3
from palpate.record import live
from palpate.record.ticks import Ticks
from palpate.scene.rig import Rig
from palpate.trackers.openigtlink import PORT, OpenIGTLinkServer

RATE = 30.0
"""Rate of the messages [Hz]."""


class _Session(Protocol):
    rig: Rig

    def latest(self) -> Ticks:
        """The newest tick."""
        ...


class FrameSender:
    """Sends all frames and the force of a session while the context is open, on the loopback interface.

    TRANSFORM messages carry the pose in the world of each frame of the scene, each object, both arms' bases, and the
    `tool`, under the frame's name. The STRING message `force` holds the force on the operator's hand, three numbers in
    the world's axes [N]. Make it in the main thread.

    Args:
        session: the session.
        port: port of the server; 0 for a free one.

    Raises:
        MissingExtraError: pyigtl is not installed. PortError: the port cannot be used.
    """

    def __init__(self, session: _Session, port: int = PORT) -> None:
        self._session, self._server = session, OpenIGTLinkServer(port)
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
            if self._server.is_connected:
                self._send(time.time())

    def _send(self, now: float) -> None:
        tick, rig = self._session.latest(), self._session.rig
        for name, X in poses(rig, tick).items():
            self._server.send_pose(name, X, now)
        F_H_W = rig.arms.X_WL[:3, :3] @ tick["F_H_L"]
        self._server.send_text("force", " ".join(f"{x:.4f}" for x in F_H_W))


def poses(rig: Rig, tick: Ticks) -> dict[str, Array]:
    """Pose in W (4, 4) [m] of all frames, objects, bases and of the tool at a tick."""
    found = {name: rig.frames.pose(name).X for name in rig.frames.frames[1:]}
    found |= object_poses(rig, tick)
    found["tool"] = so3.pose(tick["p_WT"], tick["quat_WT"])
    return found


def object_poses(rig: Rig, tick: Ticks) -> dict[str, Array]:
    """X_WO (4, 4) [m] of every object at a tick, as the loop renders it."""
    t, found, slot = float(tick["t"]), {}, 0
    for obj in rig.snapshot.objects:
        X_WO = live.object_pose(tick, slot) if obj.is_live else None
        found[obj.name] = obj.pose(t) if X_WO is None else X_WO
        slot += obj.is_live
    return found
