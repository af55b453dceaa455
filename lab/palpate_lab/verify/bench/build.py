"""`palpate bench build`: the cost of compiling in CPU seconds per file, per header and in all, next to a control.

Absolute times differ by a factor of three between machines. The control is one file that includes two
headers of Eigen and nothing else, compiled with -O3 and no warnings.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import TypedDict

from rich.table import Table

from palpate.base.errors import PalpateError
from palpate_lab import places

CONTROL = ("Eigen/Dense", "Eigen/Sparse")
_EXTERNAL = re.compile(r"^#include <((?:Eigen|pinocchio|coal|nanobind)/[^>]+)>", re.MULTILINE)

#: Stands before every call of the compiler: appends its CPU seconds and what it made to a log.
_STOPWATCH = """
import os, resource, subprocess, sys
done = subprocess.run(sys.argv[2:]).returncode
spent = resource.getrusage(resource.RUSAGE_CHILDREN)
made = sys.argv[sys.argv.index("-o") + 1] if "-o" in sys.argv else "?"
with open(sys.argv[1], "a") as log:
    log.write(f"{spent.ru_utime + spent.ru_stime:.3f} {made}\\n")
sys.exit(done)
"""


class Unit(TypedDict):
    """One compilation: a file, or the files of a folder together."""

    name: str
    seconds: float
    """CPU time; wall time when it was read from the log of a build [s]"""


class Header(TypedDict):
    """A header of another library that the core or its bindings include."""

    name: str
    seconds: float
    """CPU time of a file that includes it and nothing else [s]"""
    files: int
    """source files and headers of the core that include it"""


class Figures(TypedDict):
    """The keys of `palpate bench build` in docs/json.md."""

    cpu_s: float | None
    """of all compilations; none when it was read from the log of a build [s]"""
    wall_s: float
    control_cpu_s: float | None
    files: list[Unit]
    headers: list[Header]
    cores: int
    load: float


def root() -> Path:
    """The clone of the repository that this package is imported from.

    Raises:
        PalpateError: the package was installed from a wheel, so there is nothing to compile.
    """
    folder = places.repository()
    if folder is None:
        raise PalpateError("there is no source to compile", mend="run this in a clone of the repository")
    return folder


def run(on_progress: Callable[[str], None] = lambda _: None) -> Figures:
    """Compile the core and its bindings in a new folder, with as many processes as there are cores.

    Raises:
        PalpateError: cmake or the compiler failed; their last words are in it.
    """
    with tempfile.TemporaryDirectory(prefix="palpate-build-") as name:
        folder = Path(name)
        (folder / "stopwatch.py").write_text(_STOPWATCH, encoding="utf-8")
        log = folder / "seconds.txt"
        launcher = ";".join((sys.executable, "-I", "-S", str(folder / "stopwatch.py"), str(log)))
        on_progress("configuring")
        settings = {
            "CMAKE_BUILD_TYPE": "Release",
            "CMAKE_EXPORT_COMPILE_COMMANDS": "ON",
            "CMAKE_MAKE_PROGRAM": _tool("ninja"),
            "CMAKE_CXX_COMPILER_LAUNCHER": launcher,
            "Python_EXECUTABLE": sys.executable,
            "nanobind_DIR": _nanobind(),
        }
        defines = [f"-D{key}={value}" for key, value in settings.items()]
        _call([_tool("cmake"), "-S", str(root()), "-B", str(folder / "build"), "-G", "Ninja", *defines])
        log.unlink(missing_ok=True)
        on_progress("compiling")
        began = time.perf_counter()
        _call([_tool("ninja"), "-C", str(folder / "build")])
        wall = time.perf_counter() - began
        units = [Unit(name=_named(made), seconds=float(spent)) for spent, made in _rows(log)]
        flags = _flags(folder / "build" / "compile_commands.json")
        on_progress("the control and the headers")
        control = _control(flags, folder)
        headers = [Header(name=header, seconds=_cpu_of([*flags, "-fsyntax-only"], (header,), folder), files=n)
                   for header, n in _headers().items()]  # fmt: skip
    cpu = sum(unit["seconds"] for unit in units)
    return _figures(cpu, wall, control, units, headers)


def read_last() -> Figures:
    """Wall time per file of this environment's last whole build, from ninja's log; only the control is compiled.

    Raises:
        PalpateError: there is no such log.
    """
    logs = sorted((root() / "build").glob("*/.ninja_log"), key=os.path.getmtime)
    if not logs:
        raise PalpateError("no log of a build", where=str(root() / "build"), mend="run make setup")
    rows = [line.split("\t") for line in logs[-1].read_text().splitlines() if not line.startswith("#")]
    last = {name: (int(begin), int(end)) for begin, end, _, name, *_ in rows if name.endswith(".o")}
    units = [Unit(name=_named(name), seconds=(end - begin) / 1000) for name, (begin, end) in last.items()]
    with tempfile.TemporaryDirectory(prefix="palpate-build-") as name:
        (Path(name) / "stopwatch.py").write_text(_STOPWATCH, encoding="utf-8")
        control = _control(_flags(logs[-1].parent / "compile_commands.json"), Path(name))
    return _figures(None, max((end for _, end in last.values()), default=0) / 1000, control, units, [])


def _figures(
    cpu: float | None, wall: float, control: float | None, units: list[Unit], headers: list[Header]
) -> Figures:
    return {
        "cpu_s": cpu,
        "wall_s": wall,
        "control_cpu_s": control,
        "files": sorted(units, key=lambda unit: -unit["seconds"]),
        "headers": sorted(headers, key=lambda header: -header["seconds"] * header["files"]),
        "cores": os.cpu_count() or 1,
        "load": os.getloadavg()[0],
    }


def tables(figures: Figures, most: int) -> list[Table]:
    """The dearest files and headers, and the total; for a terminal."""
    cpu, control = figures["cpu_s"], figures["control_cpu_s"]
    title = f"compiled in {figures['wall_s']:.0f} s on {figures['cores']} cores"
    title += f", {cpu:.0f} CPU-seconds" if cpu is not None else ""
    title += f"; control (Eigen) {control:.1f} CPU-seconds" if control is not None else ""
    files = Table(title=title, box=None, padding=(0, 2, 0, 0), title_justify="left")
    files.add_column("file, or folder compiled as one")
    files.add_column("seconds", justify="right")
    files.add_column("controls", justify="right")
    for unit in figures["files"][:most]:
        ratio = f"{unit['seconds'] / control:.1f}" if control else "-"
        files.add_row(unit["name"], f"{unit['seconds']:.1f}", ratio)
    headers = Table(title="headers of other libraries", box=None, padding=(0, 2, 0, 0), title_justify="left")
    headers.add_column("header")
    headers.add_column("CPU-seconds alone", justify="right")
    headers.add_column("included by files", justify="right")
    for header in figures["headers"][:most]:
        headers.add_row(header["name"], f"{header['seconds']:.1f}", str(header["files"]))
    return [files, headers] if figures["headers"] else [files]


def _rows(log: Path) -> list[tuple[str, str]]:
    lines = log.read_text(encoding="utf-8").splitlines() if log.is_file() else []
    return [(spent, made) for spent, _, made in (line.partition(" ") for line in lines) if "/cmTC_" not in made]


def _named(made: str) -> str:
    """The source behind an object file: `core/palpate/arm/ik.cpp`, or the name of a group of files compiled as one."""
    name = re.sub(r"^CMakeFiles/[^/]*\.dir/", "", made).removesuffix(".o")
    unit = re.search(r"unity_([\w+]+)_cxx\.", name)
    return unit.group(1).replace("__", "/") + "/" if unit else name


def _headers() -> dict[str, int]:
    """Headers of other libraries, and how many of our files include each."""
    counts: dict[str, int] = {}
    for folder in ("core", "bindings", "simulators"):
        for path in (root() / folder).rglob("*"):
            if path.suffix in (".cpp", ".hpp", ".inl"):
                for header in set(_EXTERNAL.findall(path.read_text(encoding="utf-8"))):
                    counts[header] = counts.get(header, 0) + 1
    return counts


def _flags(commands: Path) -> list[str]:
    """Compiler and flags of the bindings, which see every library; no output."""
    command = next(c["command"] for c in json.loads(commands.read_text()) if "bindings" in c["file"])
    words = shlex.split(command)
    words = words[next(i for i, word in enumerate(words) if word.endswith(("++", "g++", "c++"))) :]
    kept, skip = [], False
    for word in words:
        if skip or word in ("-o", "-c", "-include", "-MT", "-MF"):
            skip = not skip
        elif not word.endswith((".cpp", ".cxx")) and word != "-MD":
            kept.append(word)
    return kept


def _control(flags: list[str], folder: Path) -> float:
    """CPU seconds of the control, with the compiler and the folders of headers in `flags`, whatever else they say."""
    folders = [word for at in pairwise(flags) if at[0] == "-isystem" for word in at]
    return _cpu_of([flags[0], "-std=c++20", "-O3", "-fPIC", *folders], CONTROL, folder)


def _cpu_of(flags: list[str], headers: tuple[str, ...], folder: Path) -> float:
    """CPU seconds of compiling a file that includes these headers and nothing else."""
    source, log = folder / "only.cpp", folder / "only.txt"
    source.write_text("".join(f"#include <{header}>\n" for header in headers), encoding="utf-8")
    log.unlink(missing_ok=True)
    made = str(folder / "only.o")
    _call([sys.executable, "-I", "-S", str(folder / "stopwatch.py"), str(log), *flags, "-c", str(source), "-o", made])
    return float(_rows(log)[0][0])


def _tool(name: str) -> str:
    """A program of this environment, or of the system."""
    own = Path(sys.executable).parent / name
    return str(own) if own.exists() else name


def _nanobind() -> str:
    return _call([sys.executable, "-m", "nanobind", "--cmake_dir"]).strip()


def _call(command: list[str]) -> str:
    try:
        done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "CCACHE_DISABLE": "1"})
    except FileNotFoundError:
        raise PalpateError(f"{command[0]} was not found", mend="run make setup, which installs it") from None
    if done.returncode != 0:
        words = (done.stdout + done.stderr)[-800:]
        raise PalpateError(
            f"{Path(command[0]).name} failed", why=words, mend="compile with make setup and read what it says"
        )
    return done.stdout
