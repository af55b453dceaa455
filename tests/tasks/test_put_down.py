"""How simulated operators put bodies down, in a world without forces: what stands badly is mended before the next."""

from __future__ import annotations

import numpy as np

from palpate.scene.task import TaskSection
from palpate.session.tasks.hand import CLOSED
from palpate.session.tasks.judge import Seen, judge_of
from palpate.session.tasks.scripts import script_of

TARGETS = [[0.1, 0.0, 0.0], [0.1, 0.02, 0.0]]
HELD_HIGH = 0.006  # height of a body that was put down askew [m]


class Table:
    """Two bodies; the first `askew` of those put down stay too high, and jaws that open push by `push` along x [m]."""

    def __init__(self, askew: int, push: float) -> None:
        self.push = push
        self.at = {"a": np.array([0.0, 0.0, 0.0]), "b": np.array([0.04, 0.01, 0.0])}
        self.holders: dict[str, set[int]] = {"a": set(), "b": set()}
        self.askew = askew
        self.put: list[tuple[str, list[float]]] = []  # what was put down, and where

    def seen(self, t: float) -> Seen:
        bodies = {name: np.block([[np.eye(3), p[:, None]], [np.zeros((1, 3)), 1.0]]) for name, p in self.at.items()}
        held = {name: len(hands) for name, hands in self.holders.items()}
        return Seen(t, np.zeros((2, 3)), bodies, held, holders={n: tuple(h) for n, h in self.holders.items()})

    def let_go(self, name: str, number: int) -> None:
        self.holders[name].discard(number)
        if not self.holders[name]:
            self.at[name][0] += self.push
            self.at[name][2] = HELD_HIGH if self.askew else 0.0
            self.askew = max(0, self.askew - 1)
            self.put.append((name, np.round(self.at[name][:2], 3).tolist()))


class Hand:
    """Is where it shall be at once, and carries the body that it closes on."""

    between = np.zeros(3)

    def __init__(self, table: Table, number: int, x: float) -> None:
        self.table, self.number, self.goal = table, number, np.array([x, 0.0, 0.05])

    @property
    def p_WT(self):
        return self.goal

    @property
    def holds(self):
        return [name for name, hands in self.table.holders.items() if self.number in hands]

    def update(self) -> None:
        pass

    def move(self, to, speed=1.0):
        for name in self.holds:
            self.table.at[name] += to - self.goal
        self.goal = np.array(to)
        yield

    def grip(self, pinch, seconds=0.45):
        self.pinch = pinch
        if pinch == CLOSED:
            near = [n for n, p in self.table.at.items() if np.linalg.norm(p - self.goal) < 0.003]
            for name in near:
                self.table.holders[name].add(self.number)
        else:
            for name in self.holds:
                self.table.let_go(name, self.number)
        yield


def put_down(askew=0, push=0.0):
    """What was put down until both bodies stood, and where."""
    table = Table(askew, push)
    place = {"bodies": ["a", "b"], "targets": TARGETS, "tolerance": 0.004, "lift": 0.03, "handed_over": True}
    task = TaskSection.model_validate({"place": place})
    judge = judge_of(task)
    script = script_of(task, [Hand(table, 0, 0.0), Hand(table, 1, 0.1)], judge, None)
    for k in range(300):
        seen = table.seen(0.02 * k)
        judge.see(seen)
        if judge.success:
            break
        script.step(seen)
    assert judge.success
    return table.put


def test_bodies_that_stand_are_left_alone():
    assert put_down(askew=0) == [("a", [0.1, 0.0]), ("b", [0.1, 0.02])]


def test_a_body_that_stands_askew_is_put_down_again_before_the_next():
    assert put_down(askew=2) == 3 * [("a", [0.1, 0.0])] + [("b", [0.1, 0.02])]


def test_no_body_is_put_on_one_that_stands_askew():
    put = put_down(askew=3)  # the operator gives up for now, and goes on with the other body
    assert put[:3] == 3 * [("a", [0.1, 0.0])]
    assert ("b", [0.1, 0.0]) not in put


def test_a_hand_learns_how_far_its_opening_jaws_push_a_body():
    tried = [name for name, _ in put_down(push=0.0045)]
    assert tried == ["a", "a", "b"], "the first try is too far by the push, and the hand knows it for the second body"
