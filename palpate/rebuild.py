"""In a developer's editable install: the extensions are compiled when they are needed.

The core is compiled again when one of its sources has changed. `make demo` compiles `_core` alone: the first import of
another extension compiles that one (`PALPATE_PARTS` in CMakeLists.txt).

scikit-build-core can do so at every import, but takes over half a second to find out that nothing has changed. Looking
at the time stamps of the sources takes a few milliseconds. An installed wheel has nothing to rebuild.

One process at a time configures and compiles. A process that waited for another one looks again at what is left to do.
"""

from __future__ import annotations

import fcntl
import os
import re
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib import import_module, invalidate_caches, metadata
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

from palpate.base.errors import MissingExtraError, PalpateError

_ROOT = Path(__file__).resolve().parent.parent
_SOURCES = ("core", "simulators", "bindings", "CMakeLists.txt")


class _Part(NamedTuple):
    """What an extension beside `_core` adds."""

    words: str
    seconds: str = "20 seconds"
    """how long it compiles on two idle cores"""
    library: str = ""
    """distribution of a library that it needs and the core does not"""
    extra: str = ""
    """extra of Palpate with that library"""


_PARTS = {
    "_collision": _Part("the paper's contact methods", library="libcoal", extra="collision"),
    "_guidance": _Part("virtual fixtures"),
    "_tissue": _Part("soft bodies and point clouds"),
    "_dvrk": _Part("the simulated dVRK"),
    "_haply": _Part("the driver of Haply devices"),
    "_network": _Part("teleoperation across a network"),
    "_reference": _Part("Pinocchio's dynamics", library="libpinocchio", extra="lab"),
    "_verify": _Part("the judges of the core", "a minute"),
}


_loops = 0
"""Loops of this process that run in real time: nothing is compiled beside them."""
_counting = threading.Lock()


def forbid() -> None:
    """Compile nothing until as many calls of `allow`: a loop runs in real time and needs the processor."""
    global _loops
    with _counting:
        _loops += 1


def allow() -> None:
    """Undo one call of `forbid`."""
    global _loops
    with _counting:
        _loops -= 1


def extension(name: str) -> ModuleType:
    """The module `palpate._core`, or that of a part, compiled first if it is missing or a source changed.

    Raises:
        ImportError: a source does not compile; the compiler's words are on the standard error.
        MissingExtraError: a library that the part needs is not installed.
        PalpateError: the part is not compiled, and a loop runs in real time in this process.
    """
    refresh()
    part = _PARTS.get(name)
    if part is not None and part.library and not _installed(part.library):
        raise MissingExtraError(f"what {part.words} need ({part.library})", part.extra)
    if name != "_core" and find_spec(f"palpate.{name}") is None:
        _complete(name)
    return import_module(f"palpate.{name}")


def _installed(distribution: str) -> bool:
    try:
        metadata.distribution(distribution)
    except metadata.PackageNotFoundError:
        return False
    return True


def refresh() -> None:
    """Compile what has changed since the last build, unless a loop runs in real time in this process.

    Raises:
        ImportError: a source does not compile; the compiler's words are on the standard error.
    """
    rebuild = _rebuild()
    if rebuild is None or _loops or not _changed():
        return
    with _lock():
        if _changed():
            _compile(rebuild)


def _changed() -> bool:
    return max(_newest(str(_ROOT / source)) for source in _SOURCES) > _compiled(_stamp())


def _complete(name: str) -> None:
    """Compile the part with the extension of this name beside those that are compiled already."""
    tag = f"cp{sys.version_info.major}{sys.version_info.minor}-*"
    build, rebuild = next((_ROOT / "build").glob(f"{tag}/CMakeCache.txt"), None), _rebuild()
    if build is None or rebuild is None:
        raise ImportError(f"palpate.{name} is not compiled. Mend: make setup")
    if _loops:
        raise PalpateError(
            f"{_PARTS[name].words} are not compiled yet",
            why="the compiler would take the processor from the session that runs in real time",
            mend="run make setup once, or stop the session first",
        )
    with _lock():
        if find_spec(f"palpate.{name}") is not None:
            return
        before = _parts(build)
        print(f"palpate: compiling {_PARTS[name].words}, once (about {_PARTS[name].seconds})", file=sys.stderr)

        def configure(parts: list[str]) -> None:
            command = ["cmake", f"-DPALPATE_PARTS={';'.join(parts)}", str(build.parent)]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)

        def build_part() -> None:
            configure([*dict.fromkeys((*before, name.removeprefix("_")))])
            rebuild()

        try:
            _compile(build_part, _PARTS[name].words)
        except ImportError:
            with suppress(OSError, subprocess.CalledProcessError):
                configure(before)  # otherwise the core could not be compiled any more, either
            raise


def _parts(cache: Path) -> list[str]:
    """The parts that a CMakeCache.txt names."""
    found = re.search(r"^PALPATE_PARTS:\w+=(.+)$", cache.read_text(), re.MULTILINE)
    return found[1].split(";") if found else []


def _rebuild() -> Callable[[], None] | None:
    """What compiles and installs the extensions: scikit-build-core's; None in an installed wheel."""
    return getattr(getattr(sys.modules["palpate"], "__loader__", None), "rebuild", None)


@contextmanager
def _lock() -> Iterator[None]:
    """Let one process configure and compile at a time; the system releases the lock even if the process dies."""
    folder = _stamp().parent
    try:
        folder.mkdir(exist_ok=True)
        lock = (folder / "compiling.lock").open("w")
    except OSError as error:
        raise ImportError(
            f"palpate must be compiled, and {folder} cannot be written ({error.strerror}). Mend: run make setup as the "
            "owner of this clone, or use a clone of your own"
        ) from None
    with lock as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            print("palpate: waiting for another process that compiles", file=sys.stderr)
            fcntl.flock(file, fcntl.LOCK_EX)
        invalidate_caches()  # the other process may have installed new files
        yield


def _compile(rebuild: Callable[[], object], what: str = "the C++ core of palpate") -> None:
    began, path = time.time(), os.environ.get("PATH", "")
    os.environ["PATH"] = os.pathsep.join((os.path.join(sys.prefix, "bin"), path))  # cmake and ninja are installed there
    try:
        rebuild()
    except subprocess.CalledProcessError:
        raise ImportError(f"{what}: the sources do not compile; the compiler's words are above") from None
    except FileNotFoundError as error:
        raise ImportError(f"{what}: {error.filename} is missing, which compiles them. Mend: make setup") from None
    finally:
        os.environ["PATH"] = path
    invalidate_caches()
    _stamp().touch()
    os.utime(_stamp(), (began, began))


def _stamp() -> Path:
    return _ROOT / "build" / f"compiled-{sys.implementation.cache_tag}"


def _compiled(stamp: Path) -> float:
    """When the core was compiled last [s since 1970]."""
    if stamp.is_file():
        return stamp.stat().st_mtime
    found = find_spec("palpate._core")
    return (
        os.stat(found.origin).st_mtime if found is not None and found.origin and os.path.exists(found.origin) else 0.0
    )


def _newest(path: str) -> float:
    """The latest change of a file, or of anything in a folder [s since 1970]."""
    latest = os.stat(path).st_mtime if os.path.exists(path) else 0.0
    if os.path.isdir(path):
        with os.scandir(path) as entries:
            for entry in entries:
                latest = max(latest, _newest(entry.path) if entry.is_dir() else entry.stat().st_mtime)
    return latest
