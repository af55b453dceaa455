"""In a developer's editable install: the core is compiled again when one of its sources has changed.

scikit-build-core can do so at every import, but takes over half a second to find out that nothing has changed. Looking
at the time stamps of the sources takes a few milliseconds. An installed wheel has nothing to rebuild.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path

_ROOT = Path(__file__).resolve().parent.parent
_SOURCES = ("core", "simulators", "bindings", "CMakeLists.txt")


def refresh() -> None:
    """Compile what has changed since the last build.

    Raises:
        ImportError: a source does not compile; the compiler's words are on the standard error.
    """
    rebuild = getattr(getattr(sys.modules["palpate"], "__loader__", None), "rebuild", None)  # scikit-build-core's
    if rebuild is None:
        return
    stamp = _ROOT / "build" / f"compiled-{sys.implementation.cache_tag}"
    if max(_newest(str(_ROOT / source)) for source in _SOURCES) <= _compiled(stamp):
        return
    began, path = time.time(), os.environ.get("PATH", "")
    os.environ["PATH"] = os.pathsep.join((os.path.join(sys.prefix, "bin"), path))  # cmake and ninja are installed there
    try:
        rebuild()
    except subprocess.CalledProcessError:
        raise ImportError("the C++ core of palpate does not compile; the compiler's words are above") from None
    finally:
        os.environ["PATH"] = path
    stamp.touch()
    os.utime(stamp, (began, began))


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
