"""Disk cache of arrays: one ``KIND-KEY.npz`` file per entry, in ``$XDG_CACHE_HOME/palpate`` (``~/.cache/palpate``).

A large block of bytes is a ``KIND-KEY.npy`` file, which is mapped into memory instead of read.

The key is a digest of all inputs, including the source code, so an entry can become unused but never outdated. Files
are written under a temporary name and then renamed, so other processes never see a partial file. The checksums in the
zip format reveal damaged files, which are replaced. If the cache cannot be read or written, the arrays are recomputed.
"""

from __future__ import annotations

import os
import platform
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

Arrays = Mapping[str, npt.NDArray[Any]]
Bytes = npt.NDArray[np.uint8]

LIMIT_BYTES = 2 * 2**30
"""Maximum size of the cache; above it, the least recently used entries are deleted.

A million triangles take 0.17 GB.
"""

_AT_ONCE = 1 << 20  # [bytes]
_ABANDONED = 3600.0  # temporary files older than this are deleted: their writer was killed [s]


@dataclass(frozen=True)
class Entry:
    """One file of the cache."""

    path: Path
    kind: str
    bytes: int
    used: float
    """Time of the last use [s since 1970]."""


def folder() -> Path | None:
    """Folder of the cache, which may not exist yet; None if the user has no home folder."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    if os.path.isabs(base):  # the XDG specification ignores relative paths
        return Path(base) / "palpate"
    with suppress(RuntimeError):
        return Path.home() / ".cache" / "palpate"
    return None


def source_key(files: Iterable[str | Path], *inputs: object) -> str:
    """Key of arrays computed from the source ``files`` and the values ``inputs``, which are compared by their ``repr``.

    The key includes numpy's version and the processor type, because sines may differ in the last bit.
    """
    digest = sha256(repr((np.__version__, platform.machine(), *inputs)).encode())
    for file in files:
        digest.update(Path(file).read_bytes())
    return digest.hexdigest()[:32]


def load_or_make(kind: str, key: str, make: Callable[[], Arrays]) -> Arrays:
    """The arrays of an entry: read from the cache, or computed and stored in the cache.

    Args:
        kind: name of the entry in `palpate cache`; letters and underscores.
        key: digest from `source_key`.
        make: computes the arrays, by name.
    """
    found = load(kind, key)
    if found is None:
        found = make()
        keep(kind, key, found)
    return found


def load(kind: str, key: str) -> Arrays | None:
    """The arrays of an entry; None if there is none, or it is damaged."""
    place = folder()
    return None if place is None else _read(place / f"{kind}-{key}.npz")


def keep(kind: str, key: str, arrays: Arrays) -> None:
    """Store the arrays of an entry, if the cache can be written."""
    _store(f"{kind}-{key}.npz", lambda file: np.savez(file, **arrays))  # type: ignore[arg-type]  # none is allow_pickle


def load_bytes(kind: str, key: str) -> Bytes | None:
    """The bytes of an entry, mapped from its file; None if there is none, or its sum is wrong."""
    place = folder()
    if place is None:
        return None
    path = place / f"{kind}-{key}.npy"
    try:
        words = np.load(path, mmap_mode="r", allow_pickle=False)
        size, total = words[-2:].tolist()
        if words.dtype != np.uint64 or int(words[:-1].sum(dtype=np.uint64)) != total:
            return None
        os.utime(path)
        found: Bytes = words.view(np.uint8)[:size]
    except Exception:  # as in _read
        return None
    return found


def keep_bytes(kind: str, key: str, pieces: Sequence[Bytes]) -> None:
    """Store the bytes of an entry, given in pieces, with their number and their sum, if the cache can be written."""
    size = sum(map(len, pieces))
    words = size // 8 + (2 if size % 8 else 1)  # of the bytes and of their number
    form = {"descr": "<u8", "fortran_order": False, "shape": (words + 1,)}

    def write(file: IO[bytes]) -> None:
        np.lib.format.write_array_header_1_0(file, form)
        total, rest = size, np.empty(0, np.uint8)
        for piece in pieces:
            for at in range(0, len(piece), _AT_ONCE):
                some = np.concatenate([rest, piece[at : at + _AT_ONCE]])
                whole = len(some) // 8 * 8
                total += int(some[:whole].view(np.uint64).sum(dtype=np.uint64))
                file.write(some[:whole].data)
                rest = some[whole:]
        last = np.concatenate([rest, np.zeros(-len(rest) % 8, np.uint8)]).view(np.uint64)
        total += int(last.sum(dtype=np.uint64))
        file.write(np.append(last, np.array([size, total % 2**64], np.uint64)).tobytes())

    _store(f"{kind}-{key}.npy", write)


def _store(name: str, write: Callable[[IO[bytes]], None]) -> None:
    place = folder()
    if place is not None:
        with suppress(OSError):  # the disk is full or read-only: the next run computes them again
            _write(place / name, write)
            _trim(place)


def entries() -> list[Entry]:
    """All entries, the most recently used first."""
    return _entries(folder())


def clear() -> int:
    """Delete all entries; return the number of bytes freed."""
    return sum(_delete(entry) for entry in entries())


def _read(path: Path) -> Arrays | None:
    """The arrays of a file; None if the file is missing or damaged."""
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        os.utime(path)
    except Exception:  # zip and numpy raise a dozen kinds of error for damaged files
        return None
    return arrays


def _write(path: Path, write: Callable[[IO[bytes]], None]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(prefix=".", suffix=".tmp", dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            write(file)
        os.replace(temporary, path)
    except BaseException:
        with suppress(OSError):
            os.unlink(temporary)
        raise


def _trim(place: Path) -> None:
    """Delete entries above the size limit, and temporary files of killed writers."""
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
    for path in place.glob("*-*.np[yz]") if place is not None else ():
        with suppress(OSError):  # another process may delete the file meanwhile
            state = path.stat()
            found.append(Entry(path, path.stem.rpartition("-")[0], state.st_size, state.st_mtime))
    return sorted(found, key=lambda entry: entry.used, reverse=True)


def _delete(entry: Entry) -> int:
    with suppress(OSError):
        entry.path.unlink()
        return entry.bytes
    return 0
