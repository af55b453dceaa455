"""A rod that one instrument takes, hands to another one, and that this one puts on a table; closed forms judge."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import palpate
from palpate import _core
from palpate.base.errors import SceneError
from palpate.session import PairsSession

FILE = Path(__file__).resolve().parents[2] / "scenes" / "hand_over.yaml"
DT = 1e-3
NONE, CARRIES, HOLDS_TOO = 0, 1, 2
SETTLED = 600  # ticks in which a rod that was handed over settles


@pytest.fixture(scope="module")
def scene():
    return palpate.Scene.load(FILE)


@pytest.fixture(scope="module")
def ticks(scene):
    """Ticks of both pairs of the whole scene."""
    session, rows = PairsSession(scene), {"right": [], "left": []}
    for name, pair in session.pairs.items():
        take = pair.take
        pair.take = lambda t, *more, name=name, take=take: (rows[name].append(t.copy()), take(t, *more))
    session.run(scene.duration)
    return {name: np.concatenate(each) for name, each in rows.items()}


def pose(p, quat):
    """Poses (n, 4, 4) of positions (n, 3) and quaternions w x y z (n, 4)."""
    X = np.tile(np.eye(4), (len(p), 1, 1))
    X[:, :3, :3] = Rotation.from_quat(np.roll(quat, -1, axis=1)).as_matrix()
    X[:, :3, 3] = p
    return X


def in_tool(t):
    """Pose of the rod in the tool (n, 4, 4)."""
    return np.linalg.inv(pose(t["p_WT"], t["quat_WT"])) @ pose(t["p_WO"], t["quat_WO"])


def sequence(t):
    return [int(h) for h in t["holding"][np.r_[True, np.diff(t["holding"]) != 0]]]


def test_the_rod_goes_from_hand_to_hand(ticks):
    assert sequence(ticks["right"]) == [NONE, CARRIES, NONE]
    assert sequence(ticks["left"]) == [NONE, HOLDS_TOO, CARRIES]
    moved = np.linalg.norm(ticks["left"]["p_WO"][-1] - ticks["left"]["p_WO"][0])
    assert moved > 0.02


def check_carried(t):
    """The rod is fixed to the tool that took it, and moves without a step; handed over, it settles in the new grip."""
    carries = np.flatnonzero(t["holding"] == CARRIES)
    X = in_tool(t)[carries[SETTLED if HOLDS_TOO in sequence(t) else 0 :]]
    assert np.abs(X - X[0]).max() < 1e-5
    assert np.linalg.norm(np.diff(t["p_WO"], axis=0), axis=1).max() < 0.1 * DT


@pytest.mark.parametrize("name", ["right", "left"])
def test_the_carried_rod_is_fixed_to_the_tool(ticks, name):
    check_carried(ticks[name])
    wrong = ticks[name].copy()
    wrong["p_WO"][-200:] += [0.0, 0.0, 2e-4]
    if name == "left":
        with pytest.raises(AssertionError):
            check_carried(wrong)


def test_a_rod_that_nobody_holds_rests(ticks):
    free = (ticks["right"]["holding"] == NONE) & (ticks["left"]["holding"] == NONE)
    assert free[0]
    assert not np.diff(ticks["right"]["p_WO"][free], axis=0).any()


def test_both_hands_feel_the_closed_chain_with_opposite_forces(scene, ticks):
    """F = K (displacement of one grip against the other); the reference is the pose of each tool at its grasp."""
    right, left = ticks["right"], ticks["left"]
    both = np.flatnonzero((right["holding"] == CARRIES) & (left["holding"] == HOLDS_TOO))
    both = both[2:-2]
    np.testing.assert_array_equal(right["F_held_W"][both], -left["F_held_W"][both])
    X_R, X_L = (pose(t["p_WT"], t["quat_WT"]) for t in (right, left))
    X_RO, X_LO = (
        np.linalg.inv(X[both[0]]) @ pose(t["p_WO"], t["quat_WO"])[both[0]] for X, t in ((X_R, right), (X_L, left))
    )
    apart = (X_L[both] @ X_LO)[:, :3, 3] - (X_R[both] @ X_RO)[:, :3, 3]
    rod = scene.graspable
    found = np.linalg.norm(right["F_held_W"][both], axis=1)
    assert found.max() > 0.1
    assert found.max() <= rod.hold
    np.testing.assert_allclose(right["F_held_W"][both], rod.stiffness * apart, atol=0.02)
    for t in (right, left):
        steps = np.linalg.norm(np.diff(t["F_H_L"], axis=0), axis=1)
        assert steps.max() <= _core.StabilityOptions().rate_cap * DT * (1 + 1e-9)
        assert np.linalg.norm(t["F_H_L"], axis=1).max() <= scene.stability.force_cap + 1e-9


def test_the_hand_that_carries_the_rod_feels_where_it_touches(scene, ticks):
    left, right, K = ticks["left"], ticks["right"], scene.objects[0].stiffness[2]
    tick, rod = left[-1], scene.graspable
    ends = (pose(left["p_WO"], left["quat_WO"])[-1] @ np.column_stack([rod.ends, [1, 1]]).T)[2]
    depth = rod.radius - (np.array([*ends, ends.mean()]) + 0.03)
    assert depth.max() > 1e-4
    assert tick["F_T_W"][2] == pytest.approx(K * np.clip(depth, 0.0, None).sum(), rel=0.1)
    assert right["F_T_W"][-1] == pytest.approx([0.0, 0.0, 0.0]), "the hand that let it go feels nothing"


def test_a_rod_needs_a_second_instrument():
    one = "objects: [{plane: {}}]\ngraspable: {name: needle}\n"
    with pytest.raises(SceneError, match="one instrument to another"):
        palpate.Session(palpate.Scene.parse(one))
