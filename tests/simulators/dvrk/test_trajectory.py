"""Trajectories against closed forms: bounds at every instant, the shortest time, simultaneous end of all joints."""

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from palpate import _dvrk


def follow(q, v, goal, v_max, a_max):
    """Duration, time step, and positions and speeds at every step of a trajectory."""
    path = _dvrk.Trajectory()
    path.start(*(np.asarray(x, float) for x in (q, v, goal, v_max, a_max)))
    dt = max(path.duration / 150, 1e-4)
    rows = [(np.asarray(q, float), np.asarray(v, float))]
    while not path.done:
        path.step(dt)
        rows.append((path.q, path.v))
        assert len(rows) < path.duration / dt + 3
    return path.duration, dt, np.array([r[0] for r in rows]), np.array([r[1] for r in rows])


def shortest(d, v_max, a_max):
    """Shortest time from rest to rest, with a triangular or trapezoidal speed profile."""
    d = abs(d)
    return 2 * np.sqrt(d / a_max) if d * a_max < v_max**2 else d / v_max + v_max / a_max


numbers = st.floats(-3, 3)
limits = st.floats(0.1, 5)
joint = st.tuples(numbers, numbers, limits, limits)


@given(st.lists(joint, min_size=1, max_size=7))
def test_duration_from_rest_is_that_of_the_slowest_joint(joints):
    q, goal, v_max, a_max = map(np.array, zip(*joints, strict=True))
    duration, _, path, speed = follow(q, 0 * q, goal, v_max, a_max)
    assert abs(duration - max(map(shortest, goal - q, v_max, a_max))) < 1e-9
    assert np.abs(path[-1] - goal).max() == 0
    assert np.abs(speed[-1]).max() == 0


@given(st.lists(st.tuples(numbers, st.floats(-1, 1), numbers, limits, limits), min_size=1, max_size=7))
@example([(0.0, 1.0, -2.0, 1.0, 0.5)])  # initially in the wrong direction
@example([(0.0, 1.0, 0.01, 2.0, 0.2)])  # too fast to stop before the goal
def test_speed_and_acceleration_stay_within_limits(joints):
    q, share, goal, v_max, a_max = map(np.array, zip(*joints, strict=True))
    _, dt, path, speed = follow(q, share * v_max, goal, v_max, a_max)
    assert (np.abs(speed) <= v_max + 1e-9).all()
    assert (np.abs(np.diff(speed[:-1], axis=0)) <= dt * a_max + 1e-9).all()
    if len(path) > 3:  # positions are the integral of the speeds, of second order in dt at the corners
        travelled = 0.5 * dt * (speed[:-2] + speed[1:-1])
        assert (np.abs(np.diff(path[:-1], axis=0) - travelled) <= 0.5 * a_max * dt**2 + 1e-9).all()
    assert np.abs(path[-1] - goal).max() == 0


@given(st.floats(0.1, 3), limits, limits, st.floats(0.05, 0.95))
def test_new_goal_during_a_motion_gives_no_jump(d, v_max, a_max, share):
    path = _dvrk.Trajectory()
    one = np.ones(1)
    path.start(0 * one, 0 * one, d * one, v_max * one, a_max * one)
    path.step(share * path.duration)
    q, v = path.q, path.v
    path.start(q, v, -one, v_max * one, a_max * one)
    path.step(1e-4)
    assert abs(path.v - v)[0] <= a_max * 1e-4 + 1e-12
    assert abs(path.q - q)[0] <= v_max * 1e-4 + 1e-12
