"""Transforms between named frames as tf2 sends them: the newest of each child, and the pose along their chain."""

from __future__ import annotations

import threading
from collections import deque

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import inverse

_KEPT = 64  # transforms of a moving child
_DEEPEST = 64  # frames in a chain


class TfTree:
    """A tree of frames; any thread may add transforms while another one asks for poses."""

    def __init__(self) -> None:
        self._edges: dict[str, tuple[str, deque[tuple[float, Array]]]] = {}
        self._lock = threading.Lock()

    def add(self, parent: str, child: str, X: Array, t: float) -> None:
        """Add the pose X (4, 4) of the child in the parent at t [s]. Transforms that are not finite are ignored."""
        if not np.isfinite(X).all() or parent == child:
            return
        with self._lock:
            if child not in self._edges or self._edges[child][0] != parent:
                self._edges[child] = parent, deque(maxlen=_KEPT)
            self._edges[child][1].append((t, X))

    def pose(self, of: str, within: str, t: float) -> Array | None:
        """Pose (4, 4) of one frame in another, from the transforms with stamps nearest to t; None without a chain."""
        with self._lock:
            up, down = self._chain(of, t), self._chain(within, t)
        if up[-1][0] != down[-1][0]:
            return None
        return inverse(down[-1][1]) @ up[-1][1]

    def _chain(self, frame: str, t: float) -> list[tuple[str, Array]]:
        """The frame and those above it, each with the pose of the frame in it."""
        found = [(frame, np.eye(4))]
        while found[-1][0] in self._edges and len(found) < _DEEPEST:
            parent, stamped = self._edges[found[-1][0]]
            X = min(stamped, key=lambda one: abs(one[0] - t))[1]
            found.append((parent, X @ found[-1][1]))
        return found
