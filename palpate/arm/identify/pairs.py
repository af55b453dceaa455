"""Poses reached from both sides: half of the torque difference is friction, and the mean is free of friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from palpate.arm.identify.recordings import Static
from palpate.base.arrays import Array

_SAME_POSE = 0.03  # two poses closer than this form a pair [rad]


@dataclass(frozen=True)
class PairFigures:
    """The figures of the pairs; each array has one value per joint."""

    count: int
    half_difference_Nm: Array  # median
    half_difference_p95_Nm: Array


@dataclass(frozen=True)
class Pairs:
    """Pairs of poses from two recordings of the same poses in opposite order."""

    means: Static
    half_difference: Array  # (k, n) magnitude [N m]

    def figures(self, joints: tuple[int, ...]) -> PairFigures:
        """The figures for these joints (from 0)."""
        halves = self.half_difference[:, list(joints)]
        return PairFigures(len(halves), np.median(halves, axis=0), np.percentile(halves, 95, axis=0))


def find_pairs(poses: Static, joints: tuple[int, ...]) -> Pairs | None:
    """Pair the poses of consecutive files; None unless 90 % of the poses have a partner."""
    file, j = np.cumsum(poses.start), list(joints)
    q, tau, halves = [], [], []
    for k in range(1, int(file.max()), 2):
        one, two = poses.only(file == k), poses.only(file == k + 1)
        near, rows = cKDTree(one.q[:, j]).query(two.q[:, j])
        close = near < _SAME_POSE
        rows = rows[close]
        q.append(0.5 * (one.q[rows] + two.q[close]))
        tau.append(0.5 * (one.tau[rows] + two.tau[close]))
        halves.append(0.5 * np.abs(one.tau[rows] - two.tau[close]))
    count = sum(len(h) for h in halves)
    if 2 * count < 0.9 * len(poses):
        return None
    means = Static(np.concatenate(q), np.concatenate(tau), np.ones(count, dtype=bool), poses.files, poses.samples)
    return Pairs(means, np.concatenate(halves))
