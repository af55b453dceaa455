"""Trajectories against closed forms: bounds kept at every instant, the shortest time, all joints at rest together."""

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from palpate import _dvrk


def follow(q, v, goal, v_max, a_max):
    """Its duration, the step, and positions and speeds at every step until it is done."""
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
    """From rest to rest: a triangle of speed, or a trapezoid."""
    d = abs(d)
    return 2 * np.sqrt(d / a_max) if d * a_max < v_max**2 else d / v_max + v_max / a_max


numbers = st.floats(-3, 3)
limits = st.floats(0.1, 5)
joint = st.tuples(numbers, numbers, limits, limits)


@given(st.lists(joint, min_size=1, max_size=7))
def test_from_rest_it_takes_as_long_as_the_slowest_joint_needs(joints):
    q, goal, v_max, a_max = map(np.array, zip(*joints, strict=True))
    duration, _, path, speed = follow(q, 0 * q, goal, v_max, a_max)
    assert abs(duration - max(map(shortest, goal - q, v_max, a_max))) < 1e-9
    assert np.abs(path[-1] - goal).max() == 0
    assert np.abs(speed[-1]).max() == 0


@given(st.lists(st.tuples(numbers, st.floats(-1, 1), numbers, limits, limits), min_size=1, max_size=7))
@example([(0.0, 1.0, -2.0, 1.0, 0.5)])  # first the wrong way
@example([(0.0, 1.0, 0.01, 2.0, 0.2)])  # too fast to stop in time
def test_speed_and_acceleration_stay_within_limits(joints):
    q, share, goal, v_max, a_max = map(np.array, zip(*joints, strict=True))
    _, dt, path, speed = follow(q, share * v_max, goal, v_max, a_max)
    assert (np.abs(speed) <= v_max + 1e-9).all()
    assert (np.abs(np.diff(speed[:-1], axis=0)) <= dt * a_max + 1e-9).all()
    if len(path) > 3:  # positions are the integral of the speeds: second order in dt at the phases' corners
        travelled = 0.5 * dt * (speed[:-2] + speed[1:-1])
        assert (np.abs(np.diff(path[:-1], axis=0) - travelled) <= 0.5 * a_max * dt**2 + 1e-9).all()
    assert np.abs(path[-1] - goal).max() == 0


@given(st.floats(0.1, 3), limits, limits, st.floats(0.05, 0.95))
def test_a_new_goal_on_the_way_goes_on_without_a_jump(d, v_max, a_max, share):
    path = _dvrk.Trajectory()
    one = np.ones(1)
    path.start(0 * one, 0 * one, d * one, v_max * one, a_max * one)
    path.step(share * path.duration)
    q, v = path.q, path.v
    path.start(q, v, -one, v_max * one, a_max * one)
    path.step(1e-4)
    assert abs(path.v - v)[0] <= a_max * 1e-4 + 1e-12
    assert abs(path.q - q)[0] <= v_max * 1e-4 + 1e-12
