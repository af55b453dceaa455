"""Judges of tasks, on worlds made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from palpate.base.errors import PalpateError
from palpate.metrics import fls_peg_transfer
from palpate.scene import Scene
from palpate.scene.task import TaskSection
from palpate.session.tasks.judge import Seen, judge_of


def at(*p):
    X = np.eye(4)
    X[:3, 3] = p
    return X


def seen(t, held=0, lost=0, **bodies):
    return Seen(t, np.zeros((1, 3)), bodies, dict.fromkeys(bodies, held), lost)


def place(back=False, limit=300.0):
    section = {"bodies": ["a"], "targets": [[0.1, 0, 0]], "back": back}
    return judge_of(TaskSection.model_validate({"limit": limit, "place": section}))


def test_there_and_back_takes_both_and_scores_as_the_fls():
    judge = place(back=True)
    judge.see(seen(0.0, a=at(0, 0, 0)))
    judge.see(seen(1.0, held=1, a=at(0.1, 0, 0)))
    assert not judge.returning, "a body in the hand does not stand at its place"
    judge.see(seen(2.0, a=at(0.1, 0, 0)))
    assert judge.returning
    assert not judge.success
    judge.see(seen(10.0, a=at(0, 0.001, 0)))
    assert judge.success
    assert judge.result().score == pytest.approx(fls_peg_transfer(10.0, 0, 1))


def test_a_body_that_falls_from_the_hand_is_a_drop_and_one_put_down_is_none():
    judge = place()
    judge.see(seen(-0.01, held=1, a=at(0, 0, 0.050)))
    judge.see(seen(0.00, held=1, a=at(0.05, 0, 0.050)))
    for k in range(1, 6):
        judge.see(seen(0.01 * k, a=at(0.05, 0, 0.050 - 0.005 * k)))
    judge.see(seen(0.10, a=at(0.05, 0, 0.025)))
    assert judge.drops == 1
    judge.see(seen(0.20, held=1, a=at(0.05, 0, 0.025)))
    judge.see(seen(0.30, a=at(0.05, 0, 0.025)))
    judge.see(seen(0.40, a=at(0.05, 0, 0.025)))
    assert judge.drops == 1
    judge.see(seen(0.50, lost=1, a=at(0, 0, 0)))
    assert judge.drops == 2, "it left the field"


def test_time_is_over():
    judge = place(limit=5.0)
    judge.see(seen(0.0, a=at(0, 0, 0)))
    judge.see(seen(6.0, a=at(0, 0, 0)))
    assert judge.done
    assert not judge.success
    assert judge.result().score == 0.0


def test_a_gate_is_passed_within_its_tolerance_and_depth_only():
    gates = {"body": "n", "tip": [0, 0, 0], "gates": [[0, 0, 0]], "tolerance": 0.0025, "depth": 0.001}
    task = TaskSection.model_validate({"gates": gates})
    judge = judge_of(task)
    for t, x, y in ((0.0, -0.01, 0.003), (0.1, 0.002, 0.003), (0.2, -0.01, 0.0)):
        judge.see(seen(t, n=at(x, y, 0)))
    assert not judge.success
    assert judge.errors["missed_gates"] == 1.0
    judge.see(seen(0.3, n=at(0.0005, 0.002, 0)))
    assert not judge.success, "half a millimetre deep"
    judge.see(seen(0.4, n=at(0.0011, 0.002, 0)))
    assert judge.success
    assert judge.result().score == pytest.approx(300.0 - 0.4 - 10.0)


def test_a_ring_that_jumps_to_the_end_has_not_followed_the_wire():
    wire = [[0.01 * k, 0, 0] for k in range(6)]
    judge = judge_of(TaskSection.model_validate({"follow": {"body": "r", "wire": wire, "tolerance": 0.004}}))
    judge.see(seen(0.0, r=at(0, 0, 0)))
    judge.see(seen(0.1, r=at(0.05, 0, 0)))
    assert not judge.success
    for k in range(26):
        judge.see(seen(0.2 + 0.1 * k, r=at(0.002 * k, 0, 0.0)))
    assert judge.success


@pytest.mark.parametrize(
    ("task", "words"),
    [
        ({}, "a task is one of place, find, follow, gates; given: none"),
        ({"place": {"bodies": ["nobody"], "targets": [[0, 0, 0]]}}, "'nobody' is not a body that moves freely"),
        ({"find": {"object": "table", "region": "r", "area": [[0, 0, 0], [0, 0, 0]]}}, "there is no object 'table'"),
    ],
)
def test_tasks_that_cannot_be_done_are_refused(task, words):
    with pytest.raises(PalpateError, match=words):
        Scene.model_validate({"objects": [{"name": "liver", "shape": "organ"}], "task": task})
