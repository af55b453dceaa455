"""The journal of one participant. Attempts are numbered and never overwritten; a trial counts once, when it ended.

An event is on the disk before the next one begins. What a kill cut off, an attempt without an end, is repeated as the
next attempt; its record stays.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from palpate.base.errors import JournalError, OutputError
from palpate.base.sweep.lines import Lines, read_lines

FILE = "journal.jsonl"
_VERSION = 1


@dataclass
class Progress:
    """What a participant has done so far."""

    ended: dict[int, dict[str, Any]] = field(default_factory=dict)
    """The event that ended each trial, by its number."""
    attempts: dict[int, int] = field(default_factory=dict)
    """Attempts begun so far, by the number of the trial."""
    aborted: list[dict[str, Any]] = field(default_factory=list)
    """Attempts that ended for a technical reason."""
    answers: dict[str, dict[str, Any]] = field(default_factory=dict)
    """Answers by what was asked about: `block-K`, `end`."""

    @property
    def lost(self) -> int:
        """Attempts that neither ended nor were aborted: the process was killed."""
        return sum(self.attempts.values()) - len(self.ended) - len(self.aborted)

    def take(self, event: Mapping[str, Any]) -> None:
        """Take in the next event.

        Raises:
            JournalError: a trial ended twice.
        """
        kind, number = event["event"], int(event.get("trial", 0))
        if kind == "begin":
            self.attempts[number] = max(self.attempts.get(number, 0), int(event["attempt"]))
        elif kind == "end":
            if number in self.ended:
                raise JournalError(f"trial {number} ended twice", mend="the journal was edited: restore it")
            self.ended[number] = dict(event)
        elif kind == "abort":
            self.aborted.append(dict(event))
        elif kind == "answers":
            self.answers[str(event["about"])] = dict(event["answers"])


def progress_of(path: Path) -> Progress:
    """The progress in a journal; none without a file. Also while another process writes it.

    Raises:
        JournalError: it is no journal, or a line of it is broken.
    """
    if not path.exists():
        return Progress()
    try:
        return _progress(read_lines(path), path)
    except OSError as error:
        why, mend = error.strerror or str(error), "make it readable, or name another folder: --out"
        raise JournalError("the journal cannot be read", where=str(path), why=why, mend=mend) from None


def _progress(entries: list[Any], path: Path) -> Progress:
    found = Progress()
    if entries and (not isinstance(entries[0], dict) or entries[0].get("event") != "opened"):
        raise JournalError("this is no journal of a participant", where=str(path), mend="name another folder: --out")
    if entries and entries[0].get("version") != _VERSION:
        mend = "continue with the version of palpate that manifest.json names"
        raise JournalError("another version of palpate wrote the journal", where=str(path), mend=mend)
    for number, entry in enumerate(entries, 1):
        try:
            found.take(entry)
        except (KeyError, TypeError, ValueError):
            mend = "restore the file from a copy; the records beside it are whole"
            raise JournalError(f"line {number} of the journal is broken", where=str(path), mend=mend) from None
    return found


class Journal:
    """The journal of a participant, open for writing by this process alone.

    Args:
        folder: of the participant.
        trials: number of planned trials.

    Raises:
        SweepError: another process writes it. JournalError: it is no journal. OutputError: it cannot be written.
    """

    def __init__(self, folder: Path, trials: int) -> None:
        self.folder, self._trials = folder, trials
        self._lines = Lines(folder / FILE)
        try:
            self.progress = _progress(self._lines.entries, folder / FILE)
            self._lines.take_up()
            if not self._lines.entries:
                self._append({"event": "opened", "version": _VERSION, "trials": trials})
        except BaseException:
            self._lines.close()
            raise

    def next(self) -> int | None:
        """Number of the first trial that has not ended; None after the last one."""
        return next((k for k in range(1, self._trials + 1) if k not in self.progress.ended), None)

    def begin(self, number: int) -> tuple[int, Path]:
        """Begin the next attempt at a trial; returns its number and its new folder.

        Raises:
            OutputError: the folder cannot be made, or the journal cannot be written.
        """
        attempt = self.progress.attempts.get(number, 0) + 1
        while True:
            folder = self.folder / f"trial-{number:03d}-attempt-{attempt}"
            try:
                folder.mkdir(parents=True)
                break
            except FileExistsError:  # made before a kill, and not yet in the journal
                attempt += 1
            except OSError as error:
                why = error.strerror or str(error)
                raise OutputError("the folder of a trial cannot be made", where=str(folder), why=why) from None
        self._append({"event": "begin", "trial": number, "attempt": attempt})
        return attempt, folder

    def end(self, number: int, attempt: int, found: Mapping[str, Any]) -> None:
        """Keep the end of a trial: it counts from now on."""
        self._append({"event": "end", "trial": number, "attempt": attempt, **found})

    def abort(self, number: int, attempt: int, reason: str) -> None:
        """Keep that an attempt ended for a technical reason; the trial is still to be done."""
        self._append({"event": "abort", "trial": number, "attempt": attempt, "reason": reason})

    def answer(self, about: str, answers: Mapping[str, Any]) -> None:
        """Keep answers."""
        self._append({"event": "answers", "about": about, "answers": dict(answers)})

    def _append(self, event: dict[str, Any]) -> None:
        self._lines.append([event])
        self._lines.sync()
        self.progress.take(event)

    def close(self) -> None:
        """Close the file."""
        self._lines.close()

    def __enter__(self) -> Self:
        """Return the journal itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file."""
        self.close()
