"""PyKDL, which the CRTK clients of dVRK and others import, in the environment of `make setup`.

No wheel of it exists. Where the system has the package for the Python of this environment, the environment gets a link
to its one module, and to nothing else of the system.
"""

from __future__ import annotations

import importlib.machinery
import importlib.util
import sysconfig
from pathlib import Path

SYSTEM = (Path("/usr/lib/python3/dist-packages"),)
"""Where Debian and Ubuntu keep modules of the system's Python."""
INSTALL = "sudo apt install python3-pykdl, then palpate ros setup"


def link(system: tuple[Path, ...] = SYSTEM, into: Path | None = None) -> str:
    """Make `PyKDL` importable in this environment if the system has it; returns a sentence for the user.

    Args:
        system: folders to search.
        into: folder of this environment's modules; default: its site-packages.
    """
    into = into or Path(sysconfig.get_paths()["platlib"])
    for old in into.glob("PyKDL*.so"):
        if old.is_symlink() and not old.exists():  # the system's package was removed
            old.unlink()
    importlib.invalidate_caches()
    if spec := importlib.util.find_spec("PyKDL"):
        return f"PyKDL: {spec.origin}"
    files = [file for folder in system for file in sorted(folder.glob("PyKDL*.so"))]
    fitting = [f for f in files if f.name.removeprefix("PyKDL") in importlib.machinery.EXTENSION_SUFFIXES]
    if fitting:
        target = into / fitting[0].name
        target.symlink_to(fitting[0])
        importlib.invalidate_caches()
        return f"PyKDL: {target}, a link to {fitting[0]}"
    if files:
        version = sysconfig.get_python_version()
        return f"PyKDL: {files[0]} is for another Python than this one ({version}); CRTK's Python clients need it"
    return f"PyKDL: not installed; CRTK's Python clients (dvrk_python) need it. Mend: {INSTALL}"


if __name__ == "__main__":
    print(link())
