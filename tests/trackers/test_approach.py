"""Rate-limited motion: limits hold, the goal is reached, and the core's motion equals the one computed here."""

from copy import deepcopy

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from palpate import _core
from palpate.trackers.approach import Approach, RateLimits

LIMITS = RateLimits(speed=0.05, turn=0.8, acceleration=0.4)
H = 0.01


def pose(p, rotvec=(0, 0, 0)):
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = Rotation.from_rotvec(rotvec).as_matrix(), p
    return X


def run(goal, seconds=4.0, centre=(0.02, -0.01, 0.03)):
    one = Approach(pose([0.1, 0.2, 0.3], [0.3, 0.1, -0.2]), np.array(centre), 0.0, LIMITS)
    path = []
    for k in range(int(seconds / H)):
        one.advance(k * H)
        path.append((one.X.copy(), one.v.copy(), one.w.copy()))
        one.aim(goal(k * H), H)
    return one, path


def test_a_jump_of_the_goal_is_approached_within_the_limits():
    goal = pose([0.16, 0.17, 0.33], [-0.4, 0.5, 0.1])
    one, path = run(lambda t: goal)
    v, w = (np.array([row[i] for row in path]) for i in (1, 2))
    assert np.linalg.norm(v, axis=1).max() == pytest.approx(LIMITS.speed, rel=0.02)
    assert np.linalg.norm(w, axis=1).max() == pytest.approx(LIMITS.turn, rel=0.02)
    slower = 1.0 - np.cos(8.0 * H)  # share of its velocity that the object loses between updates
    assert np.linalg.norm(np.diff(v, axis=0), axis=1).max() < LIMITS.acceleration * H + slower * LIMITS.speed
    assert np.linalg.norm(np.diff(w, axis=0), axis=1).max() < LIMITS.acceleration / 0.1 * H + slower * LIMITS.turn
    assert pytest.approx(goal, abs=3e-4) == one.X
    assert not one.moves
    end = (path[-1][0] @ [0.02, -0.01, 0.03, 1])[:3]
    past = [np.linalg.norm((X @ [0.02, -0.01, 0.03, 1])[:3] - end) for X, _, _ in path]
    assert (np.diff(past) < 1e-6).all()  # it never overshoots


def test_a_slow_goal_is_followed_with_a_small_lag():
    goal = lambda t: pose([0.1 + 0.005 * np.sin(2 * np.pi * t / 4), 0.2, 0.3], [0.3, 0.1, -0.2])  # noqa: E731
    _, path = run(goal, 8.0)
    off = [np.linalg.norm(X[:3, 3] - goal(k * H)[:3, 3]) for k, (X, _, _) in enumerate(path)]
    assert max(off[200:]) < 1.3e-3  # speed over gain: 7.9 mm/s / 8 1/s = 1 mm


@pytest.mark.parametrize("t0", [0.0, 0.37, 5000.0])
def test_the_core_moves_the_object_alike(t0):
    """The pose and the velocity of the core at t0 and later, against this class and against finite differences."""
    one = Approach(pose([0.1, 0.2, 0.3], [0.3, 0.1, -0.2]), np.array([0.02, -0.01, 0.03]), t0, LIMITS)
    one.v, one.w = np.array([0.03, -0.01, 0.02]), np.array([0.2, -0.5, 0.4])
    rest, motion = one.motion()
    frame = _core.MotionFrame(rest, motion)
    V = one.V_WO
    for dt in (0.0, 0.004, 0.01):
        X, V_core = frame.at(t0 + dt)
        later = deepcopy(one)
        later.advance(t0 + dt)
        assert np.asarray(X) == pytest.approx(later.X, abs=1e-10)
        assert np.asarray(V_core) == pytest.approx(later.V_WO, abs=1e-9)
    slope = (np.asarray(frame.at(t0 + 1e-4)[0]) - np.asarray(frame.at(t0)[0]))[:3, 3] / 1e-4
    assert slope == pytest.approx(V[:3], abs=2e-5)


@pytest.mark.parametrize("silence", [0.3, 1.0, 7.0])
def test_an_object_without_updates_stays_near(silence):
    """A busy machine: the motion ends by itself within v / omega = 0.05 m/s / 8 1/s."""
    one, _ = run(lambda t: pose([0.3, 0.2, 0.3], [0.3, 0.1, -0.2]), 1.0, centre=(0.0, 0.0, 0.0))
    assert np.linalg.norm(one.v) == pytest.approx(LIMITS.speed, rel=0.02)
    rest, motion = one.motion()
    for dt in np.linspace(0.0, silence, 50):
        X = np.asarray(_core.MotionFrame(rest, motion).at(one.t + dt)[0])
        assert np.linalg.norm(X[:3, 3] - one.X[:3, 3]) < LIMITS.speed / 8.0 * 1.001


def test_irregular_updates_do_not_make_an_object_swing():
    """Updates that come after 10 ms to 1 s, with the estimate of Tracking.step: the distance to the goal shrinks."""
    rng, goal = np.random.default_rng(1), pose([0.12, 0.2, 0.3], [0.3, 0.1, -0.2])
    one, t, interval = Approach(pose([0.1, 0.2, 0.3], [0.3, 0.1, -0.2]), np.zeros(3), 0.0, LIMITS), 0.0, H
    for _ in range(200):
        gap = H if rng.random() < 0.8 else rng.uniform(0.1, 1.0)
        one.aim(goal, interval)
        t, interval = t + gap, max(gap, 0.9 * interval)
        one.advance(t)
        assert np.linalg.norm(one.X[:3, 3] - goal[:3, 3]) < 0.021
    assert np.linalg.norm(one.X[:3, 3] - goal[:3, 3]) < 2e-3


def test_noise_alone_does_not_move_an_object():
    """Poses with the noise of an optical tracker about the object's own pose; a shift of 1 mm is followed."""
    rng, one = np.random.default_rng(0), Approach(pose([0, 0, 0]), np.zeros(3), 0.0, LIMITS)
    for k in range(1000):
        one.advance(k * H)
        one.aim(pose(rng.normal(scale=2.5e-4, size=3), rng.normal(scale=2e-3, size=3)), H)
        assert not one.moves
    for k in range(1000, 1300):
        one.advance(k * H)
        one.aim(pose(np.array([1e-3, 0, 0]) + rng.normal(scale=2.5e-4, size=3), rng.normal(scale=2e-3, size=3)), H)
    assert one.X[:3, 3] == pytest.approx([1e-3, 0, 0], abs=4e-4)
