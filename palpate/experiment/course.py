"""The course of a task in its scene: way points on the surface, the start, and when a trial is over."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.polyline import evenly
from palpate.base.errors import SceneError
from palpate.experiment.model import TaskSection
from palpate.metrics import Wanted
from palpate.metrics.force import TOUCH
from palpate.metrics.measures import REMOTE, TRUE_FORCE, remote_tool, true_force
from palpate.record import Record
from palpate.record.ticks import Ticks
from palpate.scene.scene import Scene
from palpate.scene.surface import PlacedSurface

SIGNALS = ("t", "p_WT", *TRUE_FORCE)
"""Signals that judge a trial."""
Result = Literal["success", "failed", "aborted"]


@dataclass(frozen=True)
class Outcome:
    """How a trial ended."""

    result: Result
    """aborted: for a technical reason; the trial is repeated."""
    reason: str
    time_s: float
    """From the first tick to the end [s]."""


@dataclass(frozen=True)
class Course:
    """Way points of the tool's tip in W, and the criteria of the task."""

    points: Array
    """(m, 3) way points [m]."""
    normal: Array | None
    """(3,) outward normal of the surface at the way points; None in free space."""
    start: Array
    """(3,) start of the tip [m]."""
    task: TaskSection
    stiffness: float
    """Stiffness of the touched surface along the normal [N/m]; 0 in free space."""

    @property
    def path(self) -> Array:
        """(n, 3) closely spaced points from the start to the last way point [m]; its foot on a surface first."""
        first = self.start if self.normal is None else self._foot
        whole = np.concatenate([first[None], self.points])
        keep = np.append(True, np.linalg.norm(np.diff(whole, axis=0), axis=1) > 1e-6)
        return evenly(whole[keep])

    @property
    def _foot(self) -> Array:
        assert self.normal is not None
        return np.asarray(self.start - self.normal * float((self.start - self.points[0]) @ self.normal))

    @property
    def wanted(self) -> Wanted:
        """What the measures compare with."""
        return Wanted(self.task.force, self.points if len(self.points) > 1 else None, self.normal)

    def away(self, p: Array, k: int) -> Array:
        """Distances (n,) of the tip (n, 3) from way point k [m]: along the surface where there is one."""
        d = p - self.points[k]
        if self.normal is not None:
            d = d - np.outer(d @ self.normal, self.normal)
        return np.asarray(np.linalg.norm(d, axis=1))


_FARTHEST = 0.25  # distance of a way point from the surface on which it is put [m]


def course_of(task: TaskSection, scene: Scene, surfaces: Sequence[PlacedSurface]) -> Course:
    """Put a task's way points on the surface of its object.

    Raises:
        SceneError: the scene has no such object.
    """
    points = np.array(task.path)
    names = [obj.name for obj in scene.objects]
    if task.object is not None and task.object not in names:
        what = f"the scene has no object {task.object!r}"
        raise SceneError(what, where=scene.file, mend=f"name one of {', '.join(names)}")
    if task.force is None:
        return Course(points, None, _start_in_space(points, task.start), task, 0.0)
    index = names.index(task.object) if task.object is not None else 0
    q, n = surfaces[index].nearest(points)
    away = np.linalg.norm(points - q, axis=1)
    if away.max() > _FARTHEST:
        k = int(away.argmax())
        what = f"way point {k + 1} is {1e3 * away[k]:.0f} mm from the surface of {names[index]!r}"
        raise SceneError(what, where=scene.file, mend="give way points near the surface, in metres in W")
    normal = n.mean(axis=0) / np.linalg.norm(n.mean(axis=0))
    points = q + scene.contact.radius * n
    stiffness = float(normal @ np.diag(scene.objects[index].stiffness) @ normal)
    beside = np.zeros(3)
    if len(points) == 1:  # a single way point is approached along the surface
        beside = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
        beside *= task.start / np.linalg.norm(beside)
    return Course(points, normal, points[0] + beside + task.start * normal, task, stiffness)


def _start_in_space(points: Array, distance: float) -> Array:
    if len(points) > 1:
        return np.asarray(points[0])
    return np.asarray(points[0] + np.array([0.0, 0.0, distance]))


class Referee:
    """Judges the ticks of one trial, live or from its record: the same ticks give the same outcome.

    Args:
        course: of the task.
        rate: ticks per second [Hz].
        remote: True: the tool across the network is judged, with the force measured there, as they arrive.
    """

    def __init__(self, course: Course, rate: float, remote: bool = False) -> None:
        self._course, self._task, self._rate, self._remote = course, course.task, rate, remote
        self._dwell, self._most = round(course.task.dwell * rate), round(course.task.time_limit * rate)
        self._ticks = self._held = 0
        self.reached = 0
        """Way points reached so far."""
        self.outcome: Outcome | None = None

    @property
    def held_s(self) -> float:
        """Time so far at the last way point [s]."""
        return self._held / self._rate

    def take(self, ticks: Ticks) -> Outcome | None:
        """Take in the next ticks (n,); returns the outcome, None before the end."""
        tool, forces = remote_tool(ticks) if self._remote else (ticks["p_WT"], true_force(ticks))
        away = [self._course.away(tool, k).tolist() for k in range(len(self._course.points))]
        for i, force in enumerate(forces.tolist()):
            if self.outcome is not None:
                break
            self._advance(away[self.reached][i], force)
        return self.outcome

    def _advance(self, away: float, force: float) -> None:
        """Take in one tick: distance from the next way point [m], and force on the tool [N]."""
        task, last = self._task, self.reached == len(self._course.points) - 1
        self._ticks += 1
        right = away < task.near and self._presses(force, last)
        if not last:
            self.reached += int(right)
        else:
            self._held = self._held + 1 if right else 0
            if right and self._held >= self._dwell:
                self._end("success", "the last way point was held")
        if task.fail_above is not None and force > task.fail_above:
            self._end("failed", f"the force passed {task.fail_above:g} N")
        elif self.outcome is None and self._ticks >= self._most:
            self._end("failed", f"the time limit of {task.time_limit:g} s passed")

    def _presses(self, force: float, last: bool) -> bool:
        wanted = self._task.force
        if wanted is None:
            return True
        return abs(force - wanted) <= self._task.within * wanted if last else force > TOUCH

    def _end(self, result: Result, reason: str) -> None:
        self.outcome = Outcome(result, reason, self._ticks / self._rate)


def judge(record: Record, course: Course, remote: bool = False) -> Outcome | None:
    """The outcome of a recorded trial; None if the record ends before the trial does."""
    referee = Referee(course, record.rate, remote)
    for ticks in record.blocks((*SIGNALS, *REMOTE) if remote else SIGNALS):
        if referee.take(ticks) is not None:
            break
    return referee.outcome
