"""What a simulated operator does in each task: scripts over the hands, as people are taught them.

A script sees what the judge sees. It looks again before each motion, and takes a body again that slipped or fell.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from palpate.base.arrays import Array
from palpate.scene.task import TaskSection
from palpate.session.console import Console
from palpate.session.tasks.hand import CLOSED, OPEN, STEP, Acting, Hand
from palpate.session.tasks.judge import FindJudge, FollowJudge, Judge, PassJudge, PlaceJudge, Seen

UP = np.array([0.0, 0.0, 1.0])
_CLEAR = 0.02  # height of the jaws above what they are about to take [m]
_BESIDE = 0.015  # distance between a place and a body that stands badly, within which the place is not free [m]
_OPENING = 0.02  # of the jaws at each update while they let go [rad]
_AJAR = 0.15  # further opening, for the retreat [rad]
_PUSH = 0.005  # largest push by opening jaws that a hand allows for, along each axis [m]
_ATTEMPTS = 3  # to put a body down


class Script:
    """A script under way.

    Args:
        hands: the hands, in the order of the pairs.
        acts: from the script to its actions.
    """

    def __init__(self, hands: Sequence[Hand], acts: Callable[[Script], Acting]) -> None:
        self.hands, self.seen = hands, Seen(0.0, np.zeros((1, 3)))
        self._acting = acts(self)
        self._over = False
        self.pushed = {hand.number: np.zeros(3) for hand in hands}
        """How far (3,) each hand's opening jaws pushed the last body across, in W [m]."""

    def step(self, seen: Seen) -> None:
        """One update: the next action, then all hands."""
        self.seen = seen
        if not self._over:
            self._over = next(self._acting, self) is self
        for hand in self.hands:
            hand.update()

    def at(self, body: str, point: Sequence[float] = (0.0, 0.0, 0.0)) -> Array:
        """Where a point of a body is (3,), in W [m]."""
        X = self.seen.bodies[body]
        return np.asarray(X[:3, :3] @ np.asarray(point) + X[:3, 3])

    def holds(self, hand: Hand, body: str) -> bool:
        """Whether a hand's jaws hold a body."""
        return hand.number in self.seen.holders.get(body, ())

    def pick(self, hand: Hand, body: str, point: Sequence[float], lift: float) -> Acting:
        """Take a body from above at a point of it, and lift it."""
        yield from hand.grip(OPEN, 0.1)
        above = self.at(body, point) - hand.between + max(lift, _CLEAR) * UP
        if hand.goal[2] < above[2]:
            yield from hand.move(np.array([hand.goal[0], hand.goal[1], above[2]]))
        yield from hand.move(above)
        yield from hand.move(self.at(body, point) - hand.between, 0.6)
        yield from hand.grip(CLOSED)
        yield from hand.move(hand.goal + lift * UP)

    def bring(self, hand: Hand, body: str, to: Array, speed: float = 1.0) -> Acting:
        """Move the hand so that the body that it holds comes to a place; looks twice."""
        for once in (speed, 0.5 * speed):
            yield from hand.move(hand.goal + to - self.at(body), once)

    def release(self, hand: Hand, body: str, up: float) -> Acting:
        """Open the jaws until they let go, and a little more, so that they sweep little; then retreat upwards."""
        while self.holds(hand, body) and hand.pinch < OPEN:
            yield from hand.grip(min(hand.pinch + _OPENING, OPEN), STEP)
        yield from hand.grip(min(hand.pinch + _AJAR, OPEN), 0.3)
        yield from hand.move(hand.goal + up * UP)


def script_of(task: TaskSection, hands: Sequence[Hand], judge: Judge, console: Console) -> Script:
    """The script of a task."""
    if task.place is not None:
        assert isinstance(judge, PlaceJudge)
        return Script(hands, lambda script: _place(script, judge))
    if task.follow is not None:
        assert isinstance(judge, FollowJudge)
        return Script(hands, lambda script: _follow(script, judge))
    if task.gates is not None:
        assert isinstance(judge, PassJudge)
        return Script(hands, lambda script: _pass(script, judge))
    assert isinstance(judge, FindJudge)
    return Script(hands, lambda script: _find(script, judge, console))


def _place(script: Script, judge: PlaceJudge) -> Acting:
    section, lift = judge.section, judge.section.lift
    while True:
        placed = judge.placed(script.seen)
        left = [name for name in section.bodies if name not in placed]
        if not left:
            yield
            continue
        first = script.hands[0] if not judge.returning or len(script.hands) == 1 else script.hands[1]
        last = script.hands[0] if judge.returning or len(script.hands) == 1 else script.hands[1]
        if not section.handed_over:
            last = first
        name = min(left, key=lambda one: float(np.linalg.norm(script.at(one) - first.p_WT)))
        yield from script.pick(first, name, _grasp(judge, first), lift)
        if not script.holds(first, name):
            continue
        if last is not first:
            yield from _hand_over(script, judge, first, last, name)
            if not script.holds(last, name):
                continue
        free = _free(script, judge, placed, name)
        yield from _put(script, judge, last, name, min(free, key=lambda p: float(np.linalg.norm(p - script.at(name)))))


def _free(script: Script, judge: PlaceJudge, placed: dict[str, int], name: str) -> list[Array]:
    """Places for a body: without those taken, and if possible without those where another body stands badly."""
    free = [place for k, place in enumerate(judge.places()) if k not in placed.values()]
    bad = [script.at(other) for other in judge.section.bodies if other != name and other not in placed]
    return [p for p in free if all(float(np.linalg.norm((p - at)[:2])) > _BESIDE for at in bad)] or free


def _put(script: Script, judge: PlaceJudge, hand: Hand, name: str, to: Array) -> Acting:
    """Put a held body down at a place; one that stands badly, on another body or askew, is taken again.

    The hand aims half as far before the place as its opening jaws pushed the body before.
    """
    lift = judge.section.lift
    for attempt in range(_ATTEMPTS):
        if attempt > 0:
            yield from script.pick(hand, name, _grasp(judge, hand), lift)
        aim = to - 0.5 * script.pushed[hand.number]
        yield from script.bring(hand, name, aim + lift * UP)
        if not script.holds(hand, name):
            return
        yield from script.bring(hand, name, aim + 0.002 * UP, 0.6)
        before = script.at(name)
        yield from script.release(hand, name, lift)
        script.pushed[hand.number] = np.clip((script.at(name) - before) * (UP == 0.0), -_PUSH, _PUSH)
        if judge.stands(script.at(name), to):
            return


def _together(*acts: Acting) -> Acting:
    """Actions of several hands at once, until the last one ends."""
    running = list(acts)
    while running:
        running = [act for act in running if next(act, act) is not act]
        if running:
            yield


def _grasp(judge: PlaceJudge, hand: Hand) -> tuple[float, float, float]:
    points = judge.section.grasp
    return points[min(hand.number, len(points) - 1)]


def _hand_over(script: Script, judge: PlaceJudge, first: Hand, last: Hand, name: str) -> Acting:
    """The first hand brings the body to the middle, the last one waits above it and takes it there."""
    point, meeting = _grasp(judge, last), judge.middle() + judge.section.lift * UP
    last.pinch = OPEN
    waiting = last.move(meeting + np.array(point) - last.between + _CLEAR * UP)
    yield from _together(script.bring(first, name, meeting), waiting)
    yield from last.move(script.at(name, point) - last.between + _CLEAR * UP)
    yield from last.move(script.at(name, point) - last.between, 0.6)
    yield from last.grip(CLOSED)
    yield from first.grip(OPEN)
    yield from first.move(first.goal + _CLEAR * UP)


def _follow(script: Script, judge: FollowJudge) -> Acting:
    section, body, hand = judge.section, judge.section.body, script.hands[0]
    points = _dense(judge.points, 0.004)
    while True:
        if not script.holds(hand, body):
            yield from script.pick(hand, body, section.grasp, 0.0)
            continue
        nearest = int(np.argmin(np.linalg.norm(points - script.at(body), axis=1)))
        for place in points[nearest : nearest + 3]:
            yield from hand.move(hand.goal + place - script.at(body), 0.7)


def _dense(points: Array, step: float) -> Array:
    """Points along a line at most `step` apart."""
    found = [points[0]]
    for a, b in pairwise(points):
        n = max(1, int(np.ceil(np.linalg.norm(b - a) / step)))
        found += [a + (k + 1) / n * (b - a) for k in range(n)]
    return np.array(found)


def _pass(script: Script, judge: PassJudge) -> Acting:
    section, body, hand = judge.section, judge.section.body, script.hands[0]
    along = np.array(section.along) / np.linalg.norm(section.along)
    while True:
        if not script.holds(hand, body):
            yield from script.pick(hand, body, section.grasp, 0.02)
            continue
        if judge.passed == len(section.gates):
            yield
            continue
        gate, number = np.array(section.gates[judge.passed]), judge.passed
        for before in (0.012, 0.006):
            yield from hand.move(hand.goal + gate - before * along - script.at(body, section.tip), 0.8)
        for _ in range(3):  # corrected twice on the way
            if judge.passed == number:
                yield from hand.move(
                    hand.goal + gate + (section.depth + 0.002) * along - script.at(body, section.tip), 0.5
                )
        yield from hand.move(hand.goal - 0.016 * along, 0.8)


def _find(script: Script, judge: FindJudge, console: Console) -> Acting:
    """Presses on a grid, then around its hardest place, and marks the hardest."""
    hand, section = script.hands[0], judge.section
    middle, half = judge.area
    pitch = 0.006
    xs = np.arange(-half[0], half[0] + 1e-9, pitch)
    ys = np.arange(-half[1], half[1] + 1e-9, pitch)
    top = hand.goal[2]
    felt: list[tuple[float, Array]] = []
    for row, y in enumerate(ys):
        for x in xs if row % 2 == 0 else xs[::-1]:
            yield from _press(script, hand, np.array([middle[0] + x, middle[1] + y, top]), section.force, felt)
    for _ in range(2):
        best = _hardest(felt)
        for dx, dy in ((0.003, 0.0), (-0.003, 0.0), (0.0, 0.003), (0.0, -0.003)):
            place = np.array([best[0] + dx, best[1] + dy, top])
            yield from _press(script, hand, place, section.force, felt)
    while True:
        best = _hardest(felt)
        yield from hand.move(np.array([best[0], best[1], hand.goal[2]]))
        yield from hand.wait(0.3)
        console.set("coag", True, "operator")
        yield
        console.set("coag", False, "operator")
        yield from hand.wait(0.5)
        felt = [one for one in felt if float(np.linalg.norm((one[1] - best)[:2])) > 0.004]  # the mark was wrong


def _press(script: Script, hand: Hand, place: Array, force: float, felt: list[tuple[float, Array]]) -> Acting:
    """Press at a place until the force is felt; keeps stiffness [N/m] and place."""
    yield from hand.move(place, 1.5)
    touched: float | None = None
    for _ in range(200):
        F = hand.force
        if F > 0.15 and touched is None:
            touched = float(hand.p_WT[2])
        if force <= F:
            break
        hand.goal = hand.goal - np.array([0.0, 0.0, 0.02 * 0.02])
        yield
    depth = max((touched or float(hand.p_WT[2])) - float(hand.p_WT[2]), 1e-4)
    felt.append(((hand.force - 0.15) / depth, hand.p_WT.copy()))
    yield from hand.move(place, 2.0)


def _hardest(felt: Sequence[tuple[float, Array]]) -> Array:
    """Middle of the hardest places, weighted by how much harder they are than most."""
    stiff = np.array([one[0] for one in felt])
    places = np.array([one[1] for one in felt])
    peak = places[int(np.argmax(stiff))]
    near = np.linalg.norm((places - peak)[:, :2], axis=1) <= 0.007
    weight = np.where(near, np.clip(stiff - np.median(stiff), 0.0, None), 0.0)
    return peak if weight.sum() <= 0.0 else np.asarray((weight[:, None] * places).sum(axis=0) / weight.sum())
