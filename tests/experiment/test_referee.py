"""The referee against a slow second algorithm, and the same outcome live and from the record."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate.experiment import Course, Referee
from palpate.experiment.model import TaskSection
from palpate.record.ticks import TICK

RATE = 100.0


def course(m=2, force=0.6, **more):
    points = np.column_stack([0.01 * np.arange(m), np.zeros(m), np.zeros(m)])
    values = {"path": points.tolist(), "dwell": 0.05, "time_limit": 1.0, "near": 0.004} | more
    if force:
        values |= {"force": force, "within": 0.3}
    task = TaskSection.model_validate(values)
    normal = np.array([0.0, 0.0, 1.0]) if force else None
    return Course(points, normal, points[0], task, 400.0)


def ticks_of(x, force, z=0.0):
    ticks = np.zeros(len(x), TICK)
    ticks["p_WT"][:, 0], ticks["p_WT"][:, 2] = x, z
    ticks["F_T_W"][:, 2] = force
    return ticks


def slow(course, x, force):
    """Outcome by the definition: the first tick at which the last `dwell` was right, after the others in order."""
    task, m, n = course.task, len(course.points), len(x)
    k, reached = 0, 0
    need = round(task.dwell * RATE)
    right = []
    for i in range(n):
        if reached < m - 1:
            if abs(x[i] - 0.01 * reached) < task.near and (task.force is None or force[i] > 0.05):
                reached += 1
            right = []
        else:
            in_band = task.force is None or abs(force[i] - task.force) <= task.within * task.force
            right.append(abs(x[i] - 0.01 * (m - 1)) < task.near and in_band)
        k = i + 1
        if task.fail_above is not None and force[i] > task.fail_above:
            return "failed", k
        if right and right[-1] and len(right) >= need and all(right[len(right) - need :]):
            return "success", k
        if k >= round(task.time_limit * RATE):
            return "failed", k
    return None, k


@settings(max_examples=150, deadline=None)
@given(seed=st.integers(0, 10**6), m=st.integers(1, 3), pressed=st.booleans(), limit=st.booleans())
def test_the_outcome_is_that_of_the_definition_whatever_the_blocks(seed, m, pressed, limit):
    rng = np.random.default_rng(seed)
    x = np.repeat(rng.integers(0, m + 1, 30) * 0.01, 4) + rng.uniform(-0.002, 0.002, 120)
    force = np.repeat(rng.choice([0.0, 0.3, 0.6, 0.7, 1.5], 30, p=[0.1, 0.1, 0.5, 0.28, 0.02]), 4)
    one = course(m, 0.6 if pressed else None, **({"fail_above": 1.0} if limit else {}))
    judged = Referee(one, RATE)
    cuts = np.sort(rng.integers(0, 120, 5))
    for block in np.split(ticks_of(x, force), cuts):
        judged.take(block)
    result, k = slow(one, x, force)
    if result is None:
        assert judged.outcome is None
    else:
        assert (judged.outcome.result, judged.outcome.time_s) == (result, pytest.approx(k / RATE))


def test_depth_under_the_surface_is_no_distance_and_height_in_free_space_is():
    x, force = np.zeros(20), np.full(20, 0.6)
    assert Referee(course(1), RATE).take(ticks_of(x, force, z=-0.01)).result == "success"
    assert Referee(course(1, force=None), RATE).take(ticks_of(x, force, z=-0.01)) is None
