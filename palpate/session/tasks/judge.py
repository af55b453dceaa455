"""Judges of tasks: they look at the world a hundred times a second, whoever moves the hands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from palpate.base.arrays import Array
from palpate.scene.task import FindSection, FollowSection, PassSection, PlaceSection, TaskSection

_REST = 0.005  # speed below which a body rests [m/s]
_FALL = 0.15  # speed of a fall that is a drop [m/s]


@dataclass(frozen=True)
class Seen:
    """The world at one moment."""

    t: float
    """Time [s]."""
    p_WT: Array
    """(tools, 3) positions of the tools [m]."""
    bodies: dict[str, Array] = field(default_factory=dict)
    """X_WO (4, 4) [m] of the bodies that move, by name."""
    held: dict[str, int] = field(default_factory=dict)
    """Number of tools that hold each body."""
    lost: int = 0
    """How often bodies left the field and came back to their start."""
    marks: Sequence[Array] = ()
    """Positions (3,) of a tool when the pedal coag was pressed [m]."""
    holders: dict[str, tuple[int, ...]] = field(default_factory=dict)
    """Numbers of the tools that hold each body."""


@dataclass(frozen=True)
class TaskResult:
    """Result of a task."""

    success: bool
    score: float  # limit - time - penalty, at least 0; 0 without success
    drops: int  # how often a body was dropped
    time_s: float  # to the end of the task, or of the run
    done: bool  # the task ended: by success, or by its limit
    progress: str  # in words
    errors: dict[str, float]  # what else the judge counted or measured, SI units in the names


class Judge:
    """Judges a task from what is seen."""

    objects = 1
    """Number of objects, by which drops are weighed."""

    def __init__(self, limit: float) -> None:
        self.limit, self.time, self.begun = limit, 0.0, 0.0
        self.drops, self.success = 0, False
        self.errors: dict[str, float] = {}
        self.progress = ""
        self._carried: set[str] = set()
        self._before: Seen | None = None
        self._falling: set[str] = set()

    @property
    def done(self) -> bool:
        """True after the end of the task."""
        return self.success or self.time >= self.limit

    def see(self, seen: Seen) -> None:
        """Look at the world; times rise."""
        if self.done:
            return
        if self._before is None:
            self.begun = seen.t
        self.time = seen.t - self.begun
        self._count_drops(seen)
        self.success = self.judge(seen)
        self._before = seen

    def judge(self, seen: Seen) -> bool:
        """Whether the task is done."""
        raise NotImplementedError

    def result(self) -> TaskResult:
        """The result up to now."""
        score = max(0.0, self.limit - self.time - self.penalty()) if self.success else 0.0
        words = "done" if self.success else "time is over" if self.done else self.progress
        return TaskResult(self.success, score, self.drops, round(self.time, 3), self.done, words, dict(self.errors))

    def penalty(self) -> float:
        """Penalty: the percentage of the objects that were dropped, as in the FLS."""
        return 100.0 * self.drops / self.objects

    def _count_drops(self, seen: Seen) -> None:
        """A drop: a body that was held falls, or leaves the field."""
        if self._before is None:
            self._carried = {name for name, count in seen.held.items() if count}
            return
        dt = max(seen.t - self._before.t, 1e-6)
        for name, X in seen.bodies.items():
            if seen.held.get(name, 0):
                self._carried.add(name)
                self._falling.discard(name)
                continue
            v = (X[2, 3] - self._before.bodies[name][2, 3]) / dt
            if name in self._carried and v < -_FALL and not self.may_fall(X):
                self._falling.add(name)
            if abs(v) < _REST:
                if name in self._falling:
                    self.drops += 1
                self._falling.discard(name)
                self._carried.discard(name)
        self.drops += seen.lost - self._before.lost

    def may_fall(self, X_WO: Array) -> bool:
        """Whether a body that falls here falls where it belongs, such as down its peg."""
        return False

    @property
    def share(self) -> float:
        """Share of the task that is done, from 0 to 1."""
        return float(self.success)

    def target(self) -> Array | None:
        """Where the task goes on (3,), in W [m]; None: nobody tells, or it is done."""
        return None


class PlaceJudge(Judge):
    """Bodies stand at their targets; with `back`, then at their start."""

    def __init__(self, section: PlaceSection, limit: float) -> None:
        super().__init__(limit)
        self.section, self.objects = section, len(section.bodies)
        self.start: dict[str, Array] = {}
        self.returning = False
        self._targets = np.array(section.targets)
        self._placed: dict[str, int] = {}

    def judge(self, seen: Seen) -> bool:
        """Whether every body stands at its place."""
        if not self.start:
            self.start = {name: seen.bodies[name][:3, 3].copy() for name in self.section.bodies}
        self._placed = placed = self.placed(seen)
        self.progress = f"{len(placed)} of {self.objects} {'back' if self.returning else 'in place'}"
        if len(placed) < self.objects:
            return False
        if self.section.back and not self.returning:
            self.returning, self._placed = True, {}
            return False
        return True

    @property
    def share(self) -> float:
        """Bodies that stand in their place; of a task with `back`, half of it for each way."""
        part = len(self._placed) / self.objects
        return 1.0 if self.success else 0.5 * (self.returning + part) if self.section.back else part

    def target(self) -> Array | None:
        """A place that is free."""
        free = [k for k in range(len(self.places())) if k not in self._placed.values()]
        return None if self.success or not free else np.asarray(self.places()[free[0]])

    def places(self) -> Array:
        """(n, 3) where bodies have to stand now [m]."""
        return np.array(list(self.start.values())) if self.returning else self._targets

    def middle(self) -> Array:
        """(3,) between the start of the bodies and their targets [m]."""
        return np.asarray(0.5 * (self._targets.mean(axis=0) + np.array(list(self.start.values())).mean(axis=0)))

    def placed(self, seen: Seen) -> dict[str, int]:
        """Bodies that stand at a place, with its number."""
        places = self.places()
        found: dict[str, int] = {}
        for name in self.section.bodies:
            p, free = seen.bodies[name][:3, 3], [k for k in range(len(places)) if k not in found.values()]
            near = [k for k in free if self.stands(p, places[k])]
            if near and not seen.held.get(name, 0):
                away = np.linalg.norm(places[near] - p, axis=1)
                found[name] = near[int(np.argmin(away))]
        return found

    def stands(self, p: Array, place: Array) -> bool:
        """Whether a body at `p` (3,) stands at a place (3,), both in W [m]."""
        across = float(np.linalg.norm((p - place)[:2]))
        return across <= self.section.tolerance and abs(float(p[2] - place[2])) <= self.section.tolerance

    def may_fall(self, X_WO: Array) -> bool:
        """Bodies may fall near a place or their start."""
        every = [*self.places(), *self.start.values()]
        return any(float(np.linalg.norm((X_WO[:3, 3] - p)[:2])) <= self.section.tolerance for p in every)


class FindJudge(Judge):
    """The mark lies above the lump."""

    def __init__(self, section: FindSection, limit: float, X_WO: Array, at: Array) -> None:
        super().__init__(limit)
        corners = np.array(section.area) @ X_WO[:3, :3].T + X_WO[:3, 3]
        self.section, self.p_lump_W = section, np.asarray(X_WO[:3, :3] @ at + X_WO[:3, 3])
        self.area = (corners.mean(axis=0), 0.5 * np.abs(corners[1] - corners[0]))  #: middle and half size in W [m]

    def judge(self, seen: Seen) -> bool:
        """Whether the newest mark lies above the lump."""
        self.progress = "no mark" if not seen.marks else f"{len(seen.marks)} wrong marks"
        if not seen.marks:
            return False
        away = [float(np.linalg.norm((mark - self.p_lump_W)[:2])) for mark in seen.marks]
        self.errors = {"mark_error_m": away[-1], "wrong_marks": float(sum(d > self.section.within for d in away))}
        return away[-1] <= self.section.within

    def penalty(self) -> float:
        """20 s for each wrong mark."""
        return 20.0 * self.errors.get("wrong_marks", 0.0)


class FollowJudge(Judge):
    """The ring passed the whole wire in order."""

    def __init__(self, section: FollowSection, limit: float) -> None:
        super().__init__(limit)
        self.section, self.points, self.reached = section, np.array(section.wire), 0
        self._off = False
        self.errors = {"off_wire": 0.0, "rms_from_wire_m": 0.0}
        self._squares: list[float] = []

    def judge(self, seen: Seen) -> bool:
        """Whether the ring has come to the end, in order."""
        p = seen.bodies[self.section.body][:3, 3]
        nearest = [_nearest(p, a, b) for a, b in pairwise(self.points)]
        away = min(nearest)
        on = away <= self.section.tolerance
        last = len(self.points) - 1
        while (
            on
            and self.reached < last
            and float(np.linalg.norm(p - self.points[self.reached + 1])) <= 1.5 * self.section.tolerance
        ):
            self.reached += 1
        if self.reached > 0 and not on and not self._off:
            self.errors["off_wire"] += 1.0
        self._off = not on
        if self.reached > 0:
            self._squares.append(away**2)
            self.errors["rms_from_wire_m"] = float(np.sqrt(np.mean(self._squares)))
        self.progress = f"{100 * self.reached / last:.0f} % of the wire"
        return self.reached == last

    @property
    def share(self) -> float:
        """Points of the wire that were reached."""
        return self.reached / (len(self.points) - 1)

    def target(self) -> Array | None:
        """The next point of the wire."""
        return None if self.success else np.asarray(self.points[min(self.reached + 1, len(self.points) - 1)])

    def penalty(self) -> float:
        """10 s for each time off the wire."""
        return super().penalty() + 10.0 * self.errors["off_wire"]


class PassJudge(Judge):
    """The tip of the needle passed every gate within its tolerance."""

    def __init__(self, section: PassSection, limit: float) -> None:
        super().__init__(limit)
        self.section, self.passed = section, 0
        self._gates, along = np.array(section.gates), np.array(section.along)
        self._along = along / np.linalg.norm(along)
        self._tip: Array | None = None
        self._entered: float | None = None
        self.errors = {"missed_gates": 0.0, "worst_entry_m": 0.0}

    def judge(self, seen: Seen) -> bool:
        """Whether the tip has passed the last gate."""
        X = seen.bodies[self.section.body]
        tip = X[:3, :3] @ np.array(self.section.tip) + X[:3, 3]
        before, self._tip = self._tip, tip
        if before is not None and self.passed < len(self._gates):
            self._at_gate(before, tip)
        self.progress = f"{self.passed} of {len(self._gates)} gates"
        return self.passed == len(self._gates)

    @property
    def share(self) -> float:
        """Gates that were passed."""
        return self.passed / len(self._gates)

    def target(self) -> Array | None:
        """The next gate."""
        return None if self.success else np.asarray(self._gates[self.passed])

    def _at_gate(self, before: Array, tip: Array) -> None:
        gate = self._gates[self.passed]
        a, b = float((before - gate) @ self._along), float((tip - gate) @ self._along)
        if a < 0.0 <= b:
            p = before + (tip - before) * (-a / (b - a))
            across = float(np.abs((p - gate) - ((p - gate) @ self._along) * self._along).max())
            if across <= self.section.tolerance:
                self._entered = across
            elif across <= 4.0 * self.section.tolerance:
                self.errors["missed_gates"] += 1.0
        if self._entered is not None and b < 0.0:
            self._entered = None
        if self._entered is not None and b >= self.section.depth:
            self.errors["worst_entry_m"] = max(self.errors["worst_entry_m"], self._entered)
            self.passed, self._entered = self.passed + 1, None

    def penalty(self) -> float:
        """10 s for each missed gate."""
        return super().penalty() + 10.0 * self.errors["missed_gates"]


def judge_of(task: TaskSection, lump: tuple[Array, Array] | None = None) -> Judge:
    """The judge of a task; lump: X_WO (4, 4) of the object and place (3,) of the hidden lump in it [m]."""
    if task.place is not None:
        return PlaceJudge(task.place, task.limit)
    if task.follow is not None:
        return FollowJudge(task.follow, task.limit)
    if task.gates is not None:
        return PassJudge(task.gates, task.limit)
    assert task.find is not None
    assert lump is not None
    return FindJudge(task.find, task.limit, *lump)


def _nearest(p: Array, a: Array, b: Array) -> float:
    """Distance of p from the segment a-b [m]."""
    s = float(np.clip((p - a) @ (b - a) / max(float((b - a) @ (b - a)), 1e-18), 0.0, 1.0))
    return float(np.linalg.norm(a + s * (b - a) - p))
