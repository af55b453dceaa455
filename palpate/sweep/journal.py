"""What is done, on disk as soon as it is done: a file that only grows, a line for each point.

The first line tells which sweep it belongs to. Each line begins with its own CRC-32, so that a line torn by a kill or a
full disk is known for what it is: that point is simply done again.
"""

from __future__ import annotations

import fcntl
import inspect
import json
import os
import pickle
import time
import warnings
from hashlib import sha256
from pathlib import Path
from types import TracebackType
from typing import Any, Self
from zlib import crc32

from palpate.errors import JournalError, OutputError, PalpateWarning, SweepError
from palpate.sweep.work import Answer, Work

SYNC_SECONDS = 0.5
"""Between two calls of fsync: a kill loses nothing at all, a power cut at most what was done in this time."""


def fingerprint(work: Work, indices: list[int]) -> dict[str, Any]:
    """What must be the same when a journal is taken up again."""
    return {
        "fn": name_of(work.fn),
        "code": _code_of(work.fn),
        "seed": work.seed,
        "version": work.version,
        "axes": {name: list(axis.values) for name, axis in work.grid.axes.items()},
        "points": f"{len(indices)} ({_digest(repr(indices).encode())})",
    }


def name_of(fn: Any) -> str:
    """Module and name of a function, through ``functools.partial``."""
    inner = inspect.unwrap(getattr(fn, "func", fn))
    return f"{inner.__module__}.{inner.__qualname__}"


def _code_of(fn: Any) -> str:
    """Fingerprint of the file in which it stands, and of what is bound to it."""
    inner = inspect.unwrap(getattr(fn, "func", fn))
    try:
        source = Path(inspect.getfile(inner)).read_bytes()
    except (OSError, TypeError):
        source = inner.__code__.co_code
    bound = pickle.dumps((fn.args, fn.keywords)) if hasattr(fn, "func") else b""
    return _digest(source + bound)


def _digest(data: bytes) -> str:
    return sha256(data).hexdigest()[:16]


class Journal:
    """Open for one sweep: ``done`` holds the answers that were already there.

    Args:
        path: begun when it is not there, gone on with when it is.
        mark: of the sweep (``fingerprint``).

    Raises:
        JournalError: it belongs to another sweep, or is no journal.
        SweepError: another process writes it.
        OutputError: it cannot be written.
    """

    def __init__(self, path: Path, mark: dict[str, Any]) -> None:
        self.path, self.done = path, {}  # type: tuple[Path, dict[int, Answer]]
        self._synced = time.monotonic()
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        except OSError as error:
            raise _refusal(path, error) from None
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._take_up(mark)
        except BlockingIOError:
            os.close(self._file)
            why = "another process is writing it"
            raise SweepError("the journal is in use", where=str(path), why=why, mend="wait for its end") from None
        except BaseException:
            os.close(self._file)
            raise

    def _take_up(self, mark: dict[str, Any]) -> None:
        data = self.path.read_bytes()
        whole = data.rfind(b"\n") + 1
        if not data:
            self._write([mark])
            return
        lines = data[:whole].splitlines()
        _require_same(_read(lines[0]) if lines else None, mark, self.path)
        os.ftruncate(self._file, whole)  # what was torn off at the end
        os.lseek(self._file, 0, os.SEEK_END)
        entries = [_read(line) for line in lines[1:]]
        self.done = {e["point"]: Answer(e["point"], e["values"]) for e in entries if e is not None}
        if broken := entries.count(None):
            what, mend = f"{broken} broken lines", "nothing to do: their points are done again"
            warnings.warn(PalpateWarning(what, where=str(self.path), mend=mend), stacklevel=4)

    def keep(self, answers: list[Answer]) -> None:
        """Write answers down; a failed point is not kept, it is tried again another time.

        Raises:
            OutputError: they cannot be written.
        """
        self._write([{"point": a.point, "values": a.values} for a in answers if a.values is not None])
        if time.monotonic() - self._synced > SYNC_SECONDS:
            self._sync()

    def _write(self, entries: list[dict[str, Any]]) -> None:
        texts = [json.dumps(entry, separators=(",", ":")).encode() for entry in entries]
        lines = b"".join(b"%08x %s\n" % (crc32(text), text) for text in texts)
        try:
            while lines:
                lines = lines[os.write(self._file, lines) :]
        except OSError as error:
            raise _refusal(self.path, error) from None

    def _sync(self) -> None:
        os.fsync(self._file)
        self._synced = time.monotonic()

    def __enter__(self) -> Self:
        """Itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """All of it on the disk."""
        try:
            self._sync()
        finally:
            os.close(self._file)


def _read(line: bytes) -> Any:
    crc, _, text = line.partition(b" ")
    return json.loads(text) if b"%08x" % crc32(text) == crc else None


def _require_same(found: Any, wanted: dict[str, Any], path: Path) -> None:
    if not isinstance(found, dict) or found.keys() != wanted.keys():
        raise _no_journal(path)
    wanted = json.loads(json.dumps(wanted))
    for key, value in wanted.items():
        if found[key] != value:
            why = f"{key} was {_short(found[key])} and is {_short(value)}"
            mend = "take up the sweep as it was, or begin another journal"
            raise JournalError("the journal belongs to another sweep", where=str(path), why=why, mend=mend)


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) < 200 else f"{text[:200]} ... ({_digest(text.encode())})"


def _no_journal(path: Path) -> JournalError:
    return JournalError("this is no journal of a sweep", where=str(path), mend="name another file")


def _refusal(path: Path, error: OSError) -> OutputError:
    return OutputError("the journal cannot be written", where=str(path), why=error.strerror or str(error))
