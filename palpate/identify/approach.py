"""From which side the drives came to a pose: dry friction holds with them, so it decides half of what is measured.

A recording's rows stand in the order of visits, so each drive's last motion is known. For a pose of a recording
visited at random, but in an unknown order, its expected direction follows from the poses alone: whoever stands at the
upper end has come from below.
"""

from __future__ import annotations

import numpy as np

from palpate.arrays import Array
from palpate.identify.recordings import Static

_MOVED = 5e-3  # a drive that moved less than this has stood still, and leans the way it came before [rad]


def directions(poses: Static, x: Array) -> Array:
    """-1, 0, +1 (k, n): the way each drive last moved to reach its position x (k, n); 0 where nobody knows."""
    moves = np.diff(x, axis=0, prepend=x[:1])
    signs = np.where(np.abs(moves) > _MOVED, np.sign(moves), 0.0)
    signs[poses.start] = 0.0
    for i in range(1, len(signs)):
        if not poses.start[i]:
            signs[i] = np.where(signs[i] == 0.0, signs[i - 1], signs[i])
    return signs


def expected_directions(x: Array, visited: Array) -> Array:
    """Mean direction (k, n) at x (k, n) when the arm came from any of `visited` (m, n): 2 F(x) - 1.

    F is the share of `visited` that lies below.
    """
    below = np.stack([np.searchsorted(np.sort(v), c) + np.searchsorted(np.sort(v), c, side="right")
                      for c, v in zip(x.T, visited.T, strict=True)], axis=1)  # fmt: skip
    return np.asarray(below / len(visited) - 1.0)
