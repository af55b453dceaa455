"""Compiler, extras, browser and ROS 2."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import sysconfig
import webbrowser
from importlib import metadata
from pathlib import Path

from palpate.base.errors import PalpateError
from palpate.cli.doctor.finding import Finding, State

OLDEST_GCC = 12
"""Oldest g++ with which the core was compiled (docs/platforms.md)."""
_USES = {
    "bodies": "rigid bodies in a scene",
    "calibrate": "palpate calibrate",
    "collision": "the paper's contact methods",
    "dask": "studies on a cluster",
    "experiment": "the mixed model of palpate experiment",
    "files": "NIfTI, NRRD, 3MF, COLLADA and label maps",
    "haply": "the stand-in of Haply's service",
    "lab": "palpate bench loop",
    "learning": "data sets of demonstrations, environments, policies",
    "pandas": "records as tables",
    "paper": "palpate reproduce",
    "planning": "palpate plan",
    "registration": "palpate register surface",
    "remote": "sessions across a network",
    "report": "pictures in reports",
    "ros": "ROS 2 nodes",
    "tissue": "soft bodies from surfaces",
    "tracking": "OpenIGTLink",
    "viewer": "the viewer in the browser",
    "vtk": "VTK's files",
}
"""What each extra adds."""


def compiler() -> list[Finding]:
    """Programs that compile the core in a clone, the nodes of ROS 2, and the adapter of OpenHaptics."""
    clone = (Path(__file__).resolve().parents[3] / "CMakeLists.txt").exists()
    needed = "the core of this clone, ROS 2 nodes" if clone else "ROS 2 nodes, own drivers in C"
    lacking: State = "problem" if clone else "optional"
    found = [_gcc(needed, lacking)]
    beside = Path(sys.executable).parent
    for name in ("cmake", "ninja"):
        path = shutil.which(name, path=str(beside)) or shutil.which(name)
        fix = (
            "" if path else "make setup" if clone else f"sudo apt install {'ninja-build' if name == 'ninja' else name}"
        )
        found.append(Finding("compiler", name, "ok" if path else lacking, path or "not found", needed, fix))
    header = Path(sysconfig.get_path("include")) / "Python.h"
    there = header.exists()
    fix, words = ("", str(header)) if there else ("sudo apt install python3-dev", "not found")
    found.append(Finding("compiler", "Python.h", "ok" if there else lacking, words, needed, fix))
    return found


def extras() -> list[Finding]:
    """Which optional packages are installed."""
    return [_extra(extra) for extra in metadata.metadata("palpate").get_all("Provides-Extra") or ()]


def browser() -> list[Finding]:
    """A browser for the viewer, and Chromium for pictures made without a person."""
    from palpate.cli.terminal.chromium import find

    opens = "opening the viewer by itself"
    try:
        viewer = Finding("browser", "browser", "ok", str(getattr(webbrowser.get(), "name", "found")), opens)
    except webbrowser.Error:
        fix = "open the printed address on any machine that reaches this one"
        viewer = Finding("browser", "browser", "optional", "none that this terminal can open", opens, fix)
    path = find()
    fix = "" if path else "sudo apt install chromium"
    needed = "pictures of the viewer: palpate reproduce, bench viewer"
    return [viewer, Finding("browser", "Chromium", "ok" if path else "optional", path or "not found", needed, fix)]


def ros() -> list[Finding]:
    """The ROS 2 that nodes would use, and whether they are compiled for it."""
    from palpate.ros.where import find

    needed = "palpate ros, the real dVRK"
    try:
        found = find()
    except PalpateError as error:
        return [Finding("ROS 2", "installation", "optional", error.what, needed, error.mend)]
    return [Finding("ROS 2", "installation", "ok", found.words, needed)]


def _gcc(needed: str, lacking: State) -> Finding:
    path = shutil.which("g++")
    if path is None:
        return Finding("compiler", "g++", lacking, "not found", needed, "sudo apt install g++")
    words = subprocess.run([path, "-dumpfullversion"], capture_output=True, text=True, check=False).stdout.strip()
    major = int(words.partition(".")[0]) if re.match(r"\d+", words) else 0
    old = major < OLDEST_GCC
    fix = f"install g++-{OLDEST_GCC} or newer, and set CXX" if old else ""
    return Finding("compiler", "g++", lacking if old else "ok", f"{words or 'unknown version'}, {path}", needed, fix)


def _extra(extra: str) -> Finding:
    missing = [name for name in _packages(extra) if not _installed(name)]
    needed = _USES.get(extra, "")
    if not missing:
        return Finding("extras", extra, "ok", "installed", needed)
    shown = ", ".join(missing[:3]) + (f" and {len(missing) - 3} more" if len(missing) > 3 else "")
    fix = f"make setup in a clone, or pip install 'palpate[{extra}]'"
    return Finding("extras", extra, "optional", f"not installed: {shown}", needed, fix)


def _packages(extra: str) -> list[str]:
    """Names of the packages that an extra needs."""
    of_extra = re.compile(rf"""([\w.-]+)[^;]*;.*extra\s*==\s*['"]{extra}['"]""")
    return [found[1] for line in metadata.requires("palpate") or () if (found := of_extra.match(line))]


def _installed(name: str) -> bool:
    try:
        metadata.version(name)
    except metadata.PackageNotFoundError:
        return False
    return True
