"""Runs the trials of a participant, person or simulated, from where the journal ends."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

from palpate.base.errors import PalpateError
from palpate.experiment.course import judge
from palpate.experiment.journal import Journal
from palpate.experiment.plan import PlannedTrial
from palpate.experiment.questions import Question, about_condition, at_end
from palpate.experiment.simulated import Performed
from palpate.experiment.study import Study
from palpate.metrics import summary
from palpate.record import Record

ATTEMPTS = 3
"""Attempts at a trial after which a session ends, in one sitting."""


class Participant(Protocol):
    """Whoever performs trials and answers questions."""

    def perform(self, trial: PlannedTrial, folder: Path) -> Performed:
        """Perform a trial, recorded into a folder."""
        ...

    def answer(self, questions: list[Question], seed: int, block: Mapping[str, float]) -> dict[str, Any]:
        """Answer questions; `block`: mean measures of the condition that they are about, empty at the end."""
        ...

    def rest(self, seconds: float) -> None:
        """Take a break of at least this length [s]."""
        ...


def run_participant(
    study: Study, who: str, participant: Participant, say: Callable[[str], None] = lambda line: None
) -> None:
    """Perform all trials of a participant that have not ended, and ask what has not been answered.

    Raises:
        PalpateError: a trial was aborted `ATTEMPTS` times; the next call continues with it.
        OutputError: the disk is full; nothing that was done is lost.
    """
    with study.journal(who) as journal:
        while (number := journal.next()) is not None:
            trial = study.trial(who, number)
            _ask_before(study, who, journal, participant, number)
            if trial.rest and journal.progress.attempts.get(number, 0) == 0:
                participant.rest(study.experiment.breaks.seconds)
            _perform(study, who, journal, participant, trial, say)
        _ask_before(study, who, journal, participant, len(study.plan[who]) + 1)
        _ask_at_end(study, who, journal, participant)


def _perform(
    study: Study,
    who: str,
    journal: Journal,
    participant: Participant,
    trial: PlannedTrial,
    say: Callable[[str], None],
) -> None:
    for _ in range(ATTEMPTS):
        study.require_space(trial)
        attempt, folder = journal.begin(trial.number)
        done = participant.perform(trial, folder)
        found = done.outcome.result != "aborted" and _measured(study, trial, done)
        if found:
            journal.end(
                trial.number, attempt, {**found, "record": str(Path(found["record"]).relative_to(study.folder))}
            )
            say(
                f"{who} trial {trial.number}/{len(study.plan[who])}: {trial.task}, {trial.condition}: {found['result']}"
            )
            return
        reason = done.outcome.reason if not found else ""
        journal.abort(trial.number, attempt, reason)
        say(f"{who} trial {trial.number}, attempt {attempt} was aborted: {reason}; it is repeated")
    what = f"trial {trial.number} of {who} was aborted {ATTEMPTS} times: {reason}"
    mend = "remove the cause and run the same command again: it continues with this trial; nothing was lost"
    raise PalpateError(what, where=str(journal.folder), mend=mend)


def _measured(study: Study, trial: PlannedTrial, done: Performed) -> dict[str, Any]:
    """Outcome and measures of a trial from its record, which alone counts."""
    assert done.record is not None
    setting = study.settings.of(trial.task, trial.condition)
    course, remote = setting.course, setting.link is not None
    task, record = course.task, Record.open(done.record)
    outcome = judge(record, course, remote) or done.outcome
    found = summary(record, need=task.need, harm=task.harm, threshold=task.need, wanted=course.wanted, remote=remote)
    found |= {"time_s": outcome.time_s, "success": float(outcome.result == "success")}
    return {
        "result": outcome.result,
        "reason": outcome.reason,
        "measures": {name: value if value == value else None for name, value in found.items()},
        "record": str(done.record),
    }


def block_means(study: Study, who: str, journal: Journal, block: int) -> dict[str, float]:
    """Mean of each measure over the trials of a block that have one."""
    rows = [
        journal.progress.ended[one.number]["measures"]
        for one in study.plan[who]
        if one.block == block and one.number in journal.progress.ended
    ]
    found = {}
    for name in rows[0] if rows else ():
        values = [row[name] for row in rows if row[name] is not None]
        if values:
            found[name] = sum(values) / len(values)
    return found


def _ask_before(study: Study, who: str, journal: Journal, participant: Participant, number: int) -> None:
    """Ask about every condition that was finished before a trial, and not yet asked about."""
    questions = about_condition(study.experiment)
    for one in study.plan[who][: number - 1]:
        about = f"block-{one.block}"
        if questions and one.last and about not in journal.progress.answers:
            means = block_means(study, who, journal, one.block)
            journal.answer(about, participant.answer(questions, one.seed, means))


def _ask_at_end(study: Study, who: str, journal: Journal, participant: Participant) -> None:
    questions = at_end(study.experiment, len(study.experiment.conditions))
    if questions and "end" not in journal.progress.answers:
        journal.answer("end", participant.answer(questions, study.plan[who][-1].seed, {}))
