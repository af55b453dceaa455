"""Poses along chains of named frames against products of matrices."""

import numpy as np
import pytest

from palpate.base.arrays.rigid import displaced, inverse
from palpate.sensing.tf_tree import TfTree


def pose(seed):
    return displaced(np.eye(4), np.random.default_rng(seed).normal(size=6))


def test_poses_go_up_and_down_the_tree():
    tree, A, B, C = TfTree(), pose(1), pose(2), pose(3)
    tree.add("world", "base", A, 0.0)
    tree.add("base", "camera", B, 0.0)
    tree.add("world", "table", C, 0.0)
    assert tree.pose("camera", "world", 1.0) == pytest.approx(A @ B)
    assert tree.pose("camera", "table", 1.0) == pytest.approx(inverse(C) @ A @ B)
    assert tree.pose("world", "camera", 1.0) == pytest.approx(inverse(A @ B))
    assert tree.pose("camera", "nowhere", 1.0) is None


def test_the_nearest_stamp_counts_and_nonsense_is_ignored():
    tree = TfTree()
    for t in (1.0, 2.0, 3.0):
        tree.add("world", "camera", pose(int(t)), t)
    tree.add("world", "camera", np.full((4, 4), np.nan), 2.1)
    tree.add("camera", "camera", pose(9), 2.1)
    assert tree.pose("camera", "world", 2.2) == pytest.approx(pose(2))
    tree.add("camera", "world", pose(4), 0.0)  # a circle ends
    tree.pose("camera", "elsewhere", 0.0)
