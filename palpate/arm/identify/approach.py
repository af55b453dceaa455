"""Approach directions: the direction in which each drive last moved before it stopped at a pose.

Dry friction opposes that motion and is part of the measured holding torque. The rows of a recording are in the order
of visits, so the last motion of each drive is known. If poses were visited at random in an unknown order, the expected
direction follows from the positions alone: a drive at the upper end of its range has come from below.
"""

from __future__ import annotations

import numpy as np

from palpate.arm.identify.recordings import Static
from palpate.base.arrays import Array

_MOVED = 5e-3  # a drive that moved less than this stood still and keeps its earlier direction [rad]


def directions(poses: Static, x: Array) -> Array:
    """Signs (k, n) of the last motion of each drive before it reached its position x (k, n); 0 where unknown."""
    moves = np.diff(x, axis=0, prepend=x[:1])
    signs = np.where(np.abs(moves) > _MOVED, np.sign(moves), 0.0)
    signs[poses.start] = 0.0
    for i in range(1, len(signs)):
        if not poses.start[i]:
            signs[i] = np.where(signs[i] == 0.0, signs[i - 1], signs[i])
    return signs


def expected_directions(x: Array, visited: Array) -> Array:
    """Expected direction (k, n) at x (k, n) if the previous pose is equally likely any of `visited` (m, n).

    It is 2 F(x) - 1, where F(x) is the fraction of `visited` below x.
    """
    below = np.stack([np.searchsorted(np.sort(v), c) + np.searchsorted(np.sort(v), c, side="right")
                      for c, v in zip(x.T, visited.T, strict=True)], axis=1)  # fmt: skip
    return np.asarray(below / len(visited) - 1.0)
