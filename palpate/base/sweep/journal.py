"""The journal of a sweep: an append-only file with one line per finished point, written immediately.

The first line identifies the sweep. Each line begins with its CRC-32, so that a line truncated by a kill or a full
disk is detected (`palpate.base.sweep.lines`); its point is computed again.
"""

from __future__ import annotations

import inspect
import json
import pickle
import time
import warnings
from dataclasses import dataclass, fields, is_dataclass
from hashlib import sha256
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from palpate.base.arrays.plain import plain
from palpate.base.errors import JournalError, PalpateWarning
from palpate.base.sweep.grid import Scalar
from palpate.base.sweep.lines import Lines
from palpate.base.sweep.work import PointResult, Work

SYNC_SECONDS = 0.5
"""Time between two calls of fsync [s]. A killed process loses nothing; a power cut loses at most this time of work."""


@dataclass(frozen=True)
class Fingerprint:
    """Properties that must be identical when a sweep is resumed; the first line of a journal, in this order."""

    fn: str
    """Module and name of the function."""
    code: str
    """Digest of the function's source file and of its bound arguments."""
    seed: int
    version: str
    """Version of palpate with a digest of its sources."""
    axes: dict[str, list[Scalar]]
    points: str
    """Number of points with a digest of their indices."""

    @classmethod
    def of(cls, work: Work, indices: list[int]) -> Self:
        """The fingerprint of a sweep over the points with these indices."""
        return cls(
            fn=name_of(work.fn),
            code=_code_of(work.fn),
            seed=work.seed,
            version=work.version,
            axes={name: list(axis.values) for name, axis in work.grid.axes.items()},
            points=f"{len(indices)} ({_digest(repr(indices).encode())})",
        )


def name_of(fn: Any) -> str:
    """Module and name of a function; ``functools.partial`` is unwrapped."""
    inner = inspect.unwrap(getattr(fn, "func", fn))
    return f"{inner.__module__}.{inner.__qualname__}"


def _code_of(fn: Any) -> str:
    """Fingerprint of the source file of a function and of its bound arguments."""
    inner = inspect.unwrap(getattr(fn, "func", fn))
    try:
        source = Path(inspect.getfile(inner)).read_bytes()
    except (OSError, TypeError):
        source = inner.__code__.co_code
    bound = steady((fn.args, fn.keywords)) if hasattr(fn, "func") else b""
    return _digest(source + bound)


def steady(value: Any) -> bytes:
    """Bytes of a bound argument, equal in every process. Those of pickle are not: the order of a set is random."""
    if isinstance(value, (set, frozenset)):
        return b"{%s}" % b",".join(sorted(map(steady, value)))
    if isinstance(value, (list, tuple)):
        return b"[%s]" % b",".join(map(steady, value))
    if isinstance(value, dict):
        return b"<%s>" % b",".join(steady(key) + b":" + steady(one) for key, one in value.items())
    if isinstance(value, Path):
        return str(value).encode()
    if is_dataclass(value) and not isinstance(value, type):
        return steady((type(value).__qualname__, {one.name: getattr(value, one.name) for one in fields(value)}))
    if hasattr(value, "model_fields_set"):  # a model of pydantic, such as a scene, with the set of what was given
        return steady((type(value).__qualname__, value.__getstate__()))
    return pickle.dumps(value)


def _digest(data: bytes) -> str:
    return sha256(data).hexdigest()[:16]


class Journal:
    """The journal of one sweep; ``done`` contains the answers of earlier runs.

    Args:
        path: journal file; created if missing, otherwise continued.
        mark: fingerprint of the sweep.

    Raises:
        JournalError: the file belongs to another sweep, or is not a journal.
        SweepError: another process writes the journal.
        OutputError: the file cannot be written.
    """

    def __init__(self, path: Path, mark: Fingerprint) -> None:
        self.path, self.done = path, {}  # type: tuple[Path, dict[int, PointResult]]
        self._synced = time.monotonic()
        self._lines = Lines(path)
        try:
            self._take_up(mark)
        except BaseException:
            self._lines.close()
            raise

    def _take_up(self, mark: Fingerprint) -> None:
        if self._lines.empty:
            self._lines.append([plain(mark)])
            return
        first, entries = self._lines.entries[:1], self._lines.entries[1:]
        _require_same(first[0] if first else None, mark, self.path)
        self._lines.take_up()
        self.done = {e["point"]: PointResult(e["point"], e["values"]) for e in entries if e is not None}
        if broken := entries.count(None):
            what, mend = f"{broken} broken lines", "nothing to do: their points are computed again"
            warnings.warn(PalpateWarning(what, where=str(self.path), mend=mend), stacklevel=4)

    def keep(self, answers: list[PointResult]) -> None:
        """Append answers. A failed point is not written, so that the next run tries it again.

        Raises:
            OutputError: the file cannot be written.
        """
        self._lines.append([{"point": a.point, "values": a.values} for a in answers if a.values is not None])
        if time.monotonic() - self._synced > SYNC_SECONDS:
            self._sync()

    def _sync(self) -> None:
        self._lines.sync()
        self._synced = time.monotonic()

    def __enter__(self) -> Self:
        """Return the journal itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Flush the file to the disk and close it."""
        try:
            self._sync()
        finally:
            self._lines.close()


def _require_same(found: Any, mark: Fingerprint, path: Path) -> None:
    expected = json.loads(json.dumps(plain(mark)))
    if not isinstance(found, dict) or found.keys() != expected.keys():
        raise _no_journal(path)
    for key, value in expected.items():
        if found[key] != value:
            why = f"{key} was {_short(found[key])} and is {_short(value)}"
            mend = "resume the sweep with its original parameters and code, or name another journal"
            raise JournalError("the journal belongs to another sweep", where=str(path), why=why, mend=mend)


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) < 200 else f"{text[:200]} ... ({_digest(text.encode())})"


def _no_journal(path: Path) -> JournalError:
    return JournalError("this is not a journal of a sweep", where=str(path), mend="name another file")
