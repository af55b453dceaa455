"""Poses of live objects and tracked frames in a tick: the signals of the stage `tracking`."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array, so3
from palpate.record.ticks import Ticks

STATUS = ("not seen yet", "tracked", "lost")
"""Values of the signal `tracked_status` in words."""


def object_pose(tick: Ticks, slot: int) -> Array | None:
    """X_WO (4, 4) [m] as the loop rendered it, of the object that is number `slot` of those that follow a tracker.

    None before the first tick, and in a record without these signals.
    """
    return _pose(tick["live_p"], tick["live_quat"], slot)


def frame_pose(tick: Ticks, slot: int) -> Array | None:
    """Last good pose X_WF (4, 4) [m] of tracked frame number `slot`; None as for `object_pose`."""
    return _pose(tick["tracked_p"], tick["tracked_quat"], slot)


def _pose(p: Array, quat: Array, slot: int) -> Array | None:
    p, quat = np.asarray(p).reshape(-1, 3)[slot], np.asarray(quat).reshape(-1, 4)[slot]
    return so3.pose(p, quat) if np.isfinite(quat).all() and quat.any() else None
