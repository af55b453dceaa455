"""A person in the viewer: trials in real time, questionnaires, breaks."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from palpate.base.errors import PalpateError
from palpate.experiment.course import Outcome, Referee
from palpate.experiment.pages import Pages
from palpate.experiment.plan import PlannedTrial
from palpate.experiment.questions import Question
from palpate.experiment.run import run_participant
from palpate.experiment.scenes import Setting
from palpate.experiment.simulated import Performed
from palpate.experiment.study import Study
from palpate.record.ticks import Ticks
from palpate.session import Session
from palpate.viewer import stage_of
from palpate.viewer.cue import Cues
from palpate.viewer.server import close_server, open_server, url
from palpate.viewer.stage import Stage
from palpate.viewer.trial_view import TrialView
from palpate.viewer.views import Framing, overview

ALONE = 2.0
"""Time without a browser after which a trial is aborted [s]."""
SILENT = 3.0
"""Time without a first tick after which a trial is aborted [s]."""
_LOOK = 0.02  # time between two looks at a running trial [s]


class _JudgedSession(Session):
    """A session on the device of its scene, or one whose hand the person drags with the mouse.

    Its referee sees every tick in order of time.
    """

    referee: Referee | None = None

    def _take(self, ticks: Ticks, realtime: bool = False) -> None:
        super()._take(ticks, realtime)
        if self.referee is not None:
            self.referee.take(ticks)


class Person:
    """A person in front of a browser.

    Args:
        study: the experiment.
        server: an open server.
    """

    def __init__(self, study: Study, server: Any) -> None:
        self._study, self._server, self.pages = study, server, Pages(server)
        self.url = url(server)
        self.view: TrialView | None = None
        """View of the running trial."""
        self.cues = Cues()
        """Cues of the running trial."""
        self._reason = ""  # of the last attempt, which was aborted
        self._stage: Stage | None = None

    def perform(self, trial: PlannedTrial, folder: Path) -> Performed:
        """Show the instruction, run the trial until the referee or a fault ends it."""
        setting = self._study.settings.of(trial.task, trial.condition)
        self._instruct(trial, setting)
        try:
            session = self._session(setting, trial, folder)
        except PalpateError as error:
            return self._done(Outcome("aborted", error.what, 0.0), None)
        task = setting.course.task
        self.cues = Cues(**setting.condition.cues.model_dump())
        words = task.words or "Follow the marks."
        points, stage = setting.course.points, self._frame(session)
        view = self.view = TrialView(self._server, session, stage, self.cues, points, task.near, words)
        stopped: list[str] = []
        view.give_up.on_click(lambda _: stopped.append("the participant stopped it"))
        try:
            outcome = self._run(session, stopped)
        finally:
            summary = session.close()
            self.view = None
            view.close()
        if summary.faults:
            outcome = Outcome("aborted", "; ".join(summary.faults), summary.duration_s)
        return self._done(outcome, None if summary.record is None else Path(summary.record))

    def answer(self, questions: list[Question], seed: int, block: Mapping[str, float]) -> dict[str, Any]:
        """Ask in the browser."""
        return self.pages.ask("Questions about the last part" if block else "At the end", questions)

    def rest(self, seconds: float) -> None:
        """Show a page whose button appears after the break."""
        self.pages.show(f"A break. You can go on after {seconds:g} s, or later.", "Go on", seconds)

    def _instruct(self, trial: PlannedTrial, setting: Setting) -> None:
        total = len(next(iter(self._study.plan.values())))
        kind = "Practice" if trial.repetition == 0 else f"Part {trial.block}"
        lines = [f"Trial {trial.number} of {total}. {kind}.", setting.course.task.words]
        if self._reason:
            lines.insert(0, f"The last attempt does not count: {self._reason}. Please repeat the trial.")
        self.pages.show("\n".join(line for line in lines if line), "Start")

    def _frame(self, session: Session) -> Stage:
        """The stage of a session; the first one begins to fill the picture of each browser."""
        first, self._stage = self._stage is None, stage_of(session.rig)
        if first:
            Framing(self._server, lambda aspect: overview(self._stage, aspect))  # type: ignore[arg-type]
        return self._stage

    def _session(self, setting: Setting, trial: PlannedTrial, folder: Path) -> _JudgedSession:
        if setting.scene.arms.leader.driver is not None:
            session = _JudgedSession(setting.scene, folder)
        else:
            rig = self._study.settings.rig(setting, seed=trial.seed)
            session = _JudgedSession(rig.scene, folder, rig=rig)
            setting.join(session, trial.seed)
        session.referee = Referee(setting.course, session.rate, setting.link is not None)
        return session

    def _run(self, session: _JudgedSession, stopped: list[str]) -> Outcome:
        """Run in real time until something ends the trial."""
        referee = session.referee
        assert referee is not None
        try:
            session.start()
            began = seen = time.monotonic()
            while referee.outcome is None:
                time.sleep(_LOOK)
                now = time.monotonic()
                seen = now if self._server.get_clients() else seen
                why = self._trouble(session, now - began) or ("the browser was closed" if now - seen > ALONE else "")
                if why or stopped:
                    return Outcome("aborted", why or stopped[0], now - began)
            return referee.outcome
        except PalpateError as error:  # the device cannot be opened
            return Outcome("aborted", error.what, 0.0)
        finally:
            session.stop()

    def _trouble(self, session: _JudgedSession, since: float) -> str:
        """Why loop, device or record are not healthy; empty if they are."""
        fault = session._loop.fault()
        if fault:
            return fault
        if session.notes:
            return session.notes[-1]
        silent = since > SILENT and float(session.latest()["t"]) <= 0.0
        return f"the loop gave no tick within {SILENT:g} s" if silent else ""

    def _done(self, outcome: Outcome, record: Path | None) -> Performed:
        self._reason = outcome.reason if outcome.result == "aborted" else ""
        return Performed(outcome, record)


def run_person(study: Study, who: str, host: str, port: int, say: Callable[[str], None]) -> None:
    """Run the trials of a person in the viewer, from where they ended, until the last one or Ctrl-C.

    Raises:
        PalpateError: as `run_participant`. KeyboardInterrupt: Ctrl-C; the next call continues.
    """
    server = open_server(host, port, study.experiment.title)
    try:
        person = Person(study, server)
        say(f"viewer: {person.url}   (Ctrl-C ends it; the same command continues)")
        run_participant(study, who, person, say)
        person.pages.show("That was the last trial. Thank you!", "Close")
    finally:
        close_server(server)
