"""Arrays that took long to make, one ``KIND-KEY.npz`` file each, in ``$XDG_CACHE_HOME/palpate`` (``~/.cache/palpate``).

The key is a digest of everything that the arrays are made of, the code included, so that an entry is never wrong, only
unused. A file is written under another name and then renamed: readers and a second writer see a whole file or none.
The checksums inside the file reveal damage; a damaged file is made anew. The cache may vanish at any moment: whoever
cannot read or write it makes the arrays again.
"""

from __future__ import annotations

import os
import platform
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

Arrays = Mapping[str, npt.NDArray[Any]]

LIMIT_BYTES = 512 * 2**20
"""Size of the whole cache; beyond it the entries that were used least recently are deleted."""

_ABANDONED = 3600.0  # age of a temporary file whose writer must have died [s]


@dataclass(frozen=True)
class Entry:
    """One file of the cache."""

    path: Path
    kind: str
    bytes: int
    used: float
    """Time of its last use [s since 1970]."""


def folder() -> Path | None:
    """The folder of the cache, which may not exist yet; None for a user without a home."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    if os.path.isabs(base):  # the XDG specification ignores relative paths
        return Path(base) / "palpate"
    with suppress(RuntimeError):
        return Path.home() / ".cache" / "palpate"
    return None


def source_key(files: Iterable[str | Path], *made_of: object) -> str:
    """Key of arrays that follow from the source ``files`` and the values ``made_of`` (told apart by their ``repr``).

    numpy's version and the kind of processor are part of it, because sines may differ in their last bit.
    """
    digest = sha256(repr((np.__version__, platform.machine(), *made_of)).encode())
    for file in files:
        digest.update(Path(file).read_bytes())
    return digest.hexdigest()[:32]


def kept(kind: str, key: str, make: Callable[[], Arrays]) -> Arrays:
    """The arrays of an entry: read from the cache, or made and stored there.

    Args:
        kind: what `palpate cache` calls it; letters and underscores.
        key: of `source_key`.
        make: returns the arrays by name.
    """
    place = folder()
    if place is None:
        return make()
    path = place / f"{kind}-{key}.npz"
    found = _read(path)
    if found is None:
        found = make()
        with suppress(OSError):  # the disk is full or read-only: the next run makes them again
            _write(path, found)
            _trim(place)
    return found


def entries() -> list[Entry]:
    """All entries, the most recently used first."""
    return _entries(folder())


def clear() -> int:
    """Delete all entries; returns how many bytes that freed."""
    return sum(_delete(entry) for entry in entries())


def _read(path: Path) -> Arrays | None:
    """The arrays of a file, or None when it is absent or damaged."""
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        os.utime(path)
    except Exception:  # a damaged file makes the readers of zip and numpy raise errors of a dozen kinds
        return None
    return arrays


def _write(path: Path, arrays: Arrays) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    named: dict[str, Any] = dict(arrays)
    handle, temporary = tempfile.mkstemp(prefix=".", suffix=".tmp", dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            np.savez(file, **named)
        os.replace(temporary, path)
    except BaseException:
        with suppress(OSError):
            os.unlink(temporary)
        raise


def _trim(place: Path) -> None:
    """Delete what exceeds the limit, and what writers that were killed left behind."""
    total = 0
    for entry in _entries(place):
        total += entry.bytes
        if total > LIMIT_BYTES:
            _delete(entry)
    for leftover in place.glob(".*.tmp"):
        with suppress(OSError):
            if time.time() - leftover.stat().st_mtime > _ABANDONED:
                leftover.unlink()


def _entries(place: Path | None) -> list[Entry]:
    found = []
    for path in place.glob("*-*.npz") if place is not None else ():
        with suppress(OSError):  # another process has just deleted it
            state = path.stat()
            found.append(Entry(path, path.stem.rpartition("-")[0], state.st_size, state.st_mtime))
    return sorted(found, key=lambda entry: entry.used, reverse=True)


def _delete(entry: Entry) -> int:
    with suppress(OSError):
        entry.path.unlink()
        return entry.bytes
    return 0
