"""Rate-limited motion: limits hold, the goal is reached without overshoot, and noise alone moves nothing."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from palpate import _core

SPEED, TURN, ACCELERATION = 0.05, 0.8, 0.4
CENTRE = np.array([0.02, -0.01, 0.03])
H = 0.001


def limits(centre=CENTRE, **changes):
    return _core.LiveOptions(**{"speed": SPEED, "turn": TURN, "acceleration": ACCELERATION, "p_OC": centre} | changes)


def pose(p, rotvec=(0, 0, 0)):
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = Rotation.from_rotvec(rotvec).as_matrix(), p
    return X


def run(goal, seconds=4.0, options=None):
    """The object at its end, and its centre (n, 3), velocity and angular velocity (n, 3) at every step."""
    one, path = _core.Approach(pose([0.1, 0.2, 0.3], [0.3, 0.1, -0.2])), []
    for k in range(1, int(seconds / H)):
        one.step(k * H, options or limits(), goal(k * H))
        path.append(((one.X_WO @ [*CENTRE, 1])[:3], one.v, one.w))
    return one, *(np.array([row[i] for row in path]) for i in range(3))


def test_a_jump_of_the_goal_is_approached_within_the_limits():
    goal = pose([0.16, 0.17, 0.33], [-0.4, 0.5, 0.1])
    one, c, v, w = run(lambda t: goal)
    assert np.linalg.norm(v, axis=1).max() == pytest.approx(SPEED, rel=0.01)
    assert np.linalg.norm(w, axis=1).max() == pytest.approx(TURN, rel=0.01)
    moving = np.linalg.norm(v, axis=1) > 1e-3  # an object that comes to rest may lose its last mm/s at once
    assert np.linalg.norm(np.diff(v, axis=0), axis=1)[moving[1:]].max() < ACCELERATION * H * 1.001
    assert np.linalg.norm(np.diff(w, axis=0), axis=1)[moving[1:]].max() < ACCELERATION / 0.1 * H * 1.001
    np.testing.assert_allclose(np.diff(c, axis=0), v[1:] * H, atol=1e-12)
    assert pytest.approx(goal, abs=3e-4) == one.X_WO
    assert not one.v.any()
    assert not one.w.any()
    past = np.linalg.norm(c - c[-1], axis=1)
    assert (np.diff(past) < 1e-6).all(), "it never overshoots"


def test_a_slow_goal_is_followed_with_a_small_lag():
    goal = lambda t: pose([0.1 + 0.005 * np.sin(2 * np.pi * t / 4), 0.2, 0.3], [0.3, 0.1, -0.2])  # noqa: E731
    _, c, _, _ = run(goal, 8.0)
    wanted = np.array([(goal(k * H) @ [*CENTRE, 1])[:3] for k in range(1, 8000)])
    assert np.linalg.norm(c - wanted, axis=1)[2000:].max() < 1.3e-3  # speed over gain: 7.9 mm/s / 8 1/s = 1 mm


def test_a_goal_with_its_velocity_is_followed_without_a_lag():
    """A target every 50 ms, with its velocity: at constant velocity the object is on it, between targets too."""
    v, one = np.array([0.02, -0.01, 0.01]), _core.Approach(pose([0, 0, 0]))
    for k in range(1, 3000):
        t = 0.05 * (k // 50)
        one.step(k * H, limits(), pose(v * t), np.r_[v, 0, 0, 0], False, t)
    np.testing.assert_allclose(one.X_WO[:3, 3], v * 2.999, atol=1e-9)


def test_an_object_turns_about_its_centre_with_the_twist_of_its_origin():
    """A goal on a circle about W's origin, with the twist of O's origin. What lags is its centripetal acceleration."""
    w, one = np.array([0.0, 0.1, 0.3]), _core.Approach(pose([0.05, 0, 0]))
    for k in range(1, 3000):
        X = pose([0, 0, 0], w * k * H) @ pose([0.05, 0, 0])
        one.step(k * H, limits(), X, np.r_[np.cross(w, X[:3, 3]), w])
    v = np.cross(w, X[:3, :3] @ CENTRE + X[:3, 3])
    lag = np.linalg.norm(np.cross(w, v)) / (4.0 * 8.0 * 8.0)  # acceleration over 4 k^2
    off = (one.X_WO - X) @ [*CENTRE, 1]
    assert np.linalg.norm(off) == pytest.approx(lag, rel=0.1)
    assert one.X_WO[:3, :3] == pytest.approx(X[:3, :3], abs=1e-9)
    assert one.v == pytest.approx(v, abs=0.3 * 2 * lag)


@pytest.mark.parametrize("silence", [0.3, 1.0])
def test_an_object_whose_target_is_too_old_brakes_to_rest(silence):
    """From 0.05 m/s at 0.4 m/s^2 in at most v^2 / (2 a) = 3.1 mm, plus v / (4 k) = 1.6 mm of the filter."""
    far, one = pose([0.3, 0.2, 0.3]), _core.Approach(pose([0, 0, 0]))
    for k in range(1, 1000):
        one.step(k * H, limits(), far)
    start, last = one.X_WO[:3, 3], 0.999
    assert np.linalg.norm(one.v) == pytest.approx(SPEED, rel=0.01)
    for k in range(1000, 1000 + int(silence / H)):
        one.step(k * H, limits(max_age=0.05), far, t_target=last)
    assert one.lost
    assert np.linalg.norm(one.v) < (1e-3 if silence < 0.5 else 1e-12)
    assert np.linalg.norm(one.X_WO[:3, 3] - start) < SPEED * 0.051 + 3.1e-3 + 1.6e-3
    assert one.share == pytest.approx(max(1.0 - (silence - 0.05) / 0.5, 0.0), abs=0.01)


def test_irregular_steps_do_not_make_an_object_swing():
    """Steps of 1 ms to 1 s: the distance to the goal never grows."""
    rng, goal, t = np.random.default_rng(1), pose([0.12, 0.2, 0.3], [0.3, 0.1, -0.2]), 0.0
    one = _core.Approach(pose([0.1, 0.2, 0.3], [0.3, 0.1, -0.2]))
    for _ in range(2000):
        t += H if rng.random() < 0.95 else rng.uniform(0.01, 1.0)
        one.step(t, limits(np.zeros(3)), goal)
        assert np.linalg.norm(one.X_WO[:3, 3] - goal[:3, 3]) < 0.021
    assert np.linalg.norm(one.X_WO[:3, 3] - goal[:3, 3]) < 3e-4


def test_noise_alone_does_not_move_an_object():
    """Poses at 100 Hz with the noise of an optical tracker about the object's own pose; a shift of 1 mm is followed."""
    rng, one = np.random.default_rng(0), _core.Approach(pose([0, 0, 0]))
    for k in range(1, 13000):
        if k % 10 == 1:
            shift = np.array([1e-3 if k > 10000 else 0.0, 0, 0])
            goal = pose(shift + rng.normal(scale=2.5e-4, size=3), rng.normal(scale=2e-3, size=3))
        one.step(k * H, limits(np.zeros(3)), goal)
        assert k > 10000 or not one.v.any()
    assert one.X_WO[:3, 3] == pytest.approx([1e-3, 0, 0], abs=4e-4)
