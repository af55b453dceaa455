"""Simulated participants: operators in closed loop, through the one session. They are models, not people."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from palpate.base.arrays import Array
from palpate.experiment.course import Outcome, Referee
from palpate.experiment.model import ConditionSection
from palpate.experiment.plan import PlannedTrial
from palpate.experiment.questions import Question
from palpate.experiment.scenes import Setting, Settings
from palpate.record.ticks import Ticks
from palpate.session import Session
from palpate.simulators.operators import STEP, Aim, Errand, Operator, Person, Senses, perform, person
from palpate.simulators.operators.operator import MAX_DURATION

_ARRIVED = 1.5e-3  # remaining path at which the hand stays where it is [m]
_STANDING = 1e-9  # width of a passage along which the hand does not move [m]
_LIFTED = 0.3  # share of the intended force below which the hand presses before it goes on [-]
_SETTLE = 20  # ticks that the simulation runs before the operator acts


@dataclass(frozen=True)
class Performed:
    """A trial as it was performed."""

    outcome: Outcome
    record: Path | None


class _Over(BaseException):
    """The referee has ended the trial."""


class SimulatedParticipant:
    """A person of the cohort of simulated operators.

    Args:
        number: of the person in the cohort.
        seed: of the cohort.
        settings: of the experiment.
    """

    simulated = True

    def __init__(self, number: int, seed: int, settings: Settings) -> None:
        self.person: Person = person(number, seed)
        self._settings = settings

    def perform(self, trial: PlannedTrial, folder: Path) -> Performed:
        """Perform a trial, recorded into a folder.

        Raises:
            SceneError, MeshError: the scene cannot run. OutputError: the folder cannot be written.
        """
        setting = self._settings.of(trial.task, trial.condition)
        rig = self._settings.rig(setting, self.person.hand, self.person.tremor, trial.seed)
        session = Session(rig.scene, folder, rig=rig)
        setting.join(session, trial.seed)
        through = _Through(session, setting)
        operator = Operator(self.person, senses(setting.condition), trial.seed)
        most = min(setting.course.task.time_limit, MAX_DURATION) - STEP
        try:
            perform(through, operator, _errand(setting), rig.arms.X_WL, rig.scene.mapping.scale, most)  # type: ignore[arg-type]
            through.stay()
        except _Over:
            pass
        summary = session.close()
        outcome = through.referee.outcome
        if summary.faults or outcome is None:
            why = "; ".join(summary.faults) or f"simulated hands act for {MAX_DURATION:g} s at most"
            outcome = Outcome("aborted", why, summary.duration_s)
        return Performed(outcome, None if summary.record is None else Path(summary.record))

    def answer(self, questions: list[Question], seed: int, block: Mapping[str, float]) -> dict[str, Any]:
        """Answers that exercise the forms and the analysis, and say nothing about people.

        A scale is answered by the time and the force error of the condition, with noise; a choice is drawn.
        """
        rng = np.random.default_rng([seed, self.person.number])
        load = 0.05 * block.get("time_s", 5.0) + 0.5 * block.get("force_error_N", 0.5)
        found: dict[str, Any] = {}
        for one in questions:
            if one.options:
                found[one.name] = str(rng.choice(one.options))
                continue
            share = float(np.clip(load + rng.normal(0.0, 0.1), 0.0, 1.0))
            found[one.name] = one.low + one.step * round(share * (one.high - one.low) / one.step)
        return found

    def rest(self, seconds: float) -> None:
        """Simulated participants need no break."""


class _Through:
    """The simulation of a session, for `perform`: its ticks are recorded and judged."""

    def __init__(self, session: Session, setting: Setting) -> None:
        self._session, self._hand = session, np.zeros(3)
        self.referee = Referee(setting.course, session.rate, setting.link is not None)

    def run(self, n: int, hand_W: Array | None = None) -> Ticks:
        led = np.tile(self._hand, (n, 1)) if hand_W is None else hand_W
        self._hand = np.array(led[-1])
        ticks = self._session.lead(n, led)
        if self.referee.take(ticks) is not None:
            raise _Over
        return ticks

    def stay(self) -> None:
        """Keep the hand where it is until the referee ends the trial."""
        for _ in range(round(MAX_DURATION / STEP)):
            self.run(_SETTLE)


def senses(condition: ConditionSection) -> Senses:
    """What a simulated participant perceives: a cue of any kind is read like a bar; the task's path is drawn."""
    force: Literal["looks", "shown", "felt"] = "felt" if condition.felt else "shown" if condition.cues.any else "looks"
    return Senses(force, drawn=True)


@dataclass(frozen=True)
class _Held(Errand):
    """The way along a course, at whose end the hand stays; the force is felt as late as the condition says."""

    delay: float = 0.0
    late: list[float] = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "late", [])

    def force(self, tick: Ticks) -> float:
        self.late.append(float(np.linalg.norm(tick["F_T_W"])))
        return self.late[max(0, len(self.late) - 1 - round(self.delay / STEP))]

    def aim(self, x: Array, begin: int, preview: float = 0.0) -> tuple[Aim, int]:
        aim, at = super().aim(x, begin, preview)
        if aim.ahead > _ARRIVED:
            lifted = self.press > 0.0 and (not self.late or self.late[-1] < _LIFTED * self.press)
            return (replace(aim, width=_STANDING) if lifted else aim), at
        error, into = self.path[-1] - x, np.array(self.into)
        error = error - into * float(into @ error) if self.press > 0.0 else error
        return Aim(error, aim.along, 1.0, _STANDING, aim.press, into, aim.stiffness), at


def _errand(setting: Setting) -> Errand:
    course, task = setting.course, setting.course.task
    path = course.path
    width = np.full(len(path), task.near)
    delay = setting.condition.delay
    if course.normal is None:
        return _Held(path, width, 1.0, delay=delay)
    into = (-float(course.normal[0]), -float(course.normal[1]), -float(course.normal[2]))
    return _Held(path, width, course.stiffness, task.need, into, rendered=True, delay=delay)
