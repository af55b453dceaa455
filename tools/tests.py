"""Runs all tests: those in real time, and beside them, at the lowest priority, those that only compute.

    python tools/tests.py [--long] [--keep] [options of pytest]

Tests in real time wait most of the time; the others take the processor time that is left. A browser or a process may
miss its deadline on a busy machine: a test that fails is repeated with nothing beside it, and must pass then. A test
that does not end fails after ten minutes (pyproject.toml), a part after LIMIT. The end tells the wall time, the
processor time, and the folders that took most of it beside their shares in KEPT, and each part lists its slowest tests,
so that growth is seen. --keep writes the processor times to KEPT. --long runs the tests of the marker `long`, which add
cases to short versions, and the property tests with all their examples.
"""

from __future__ import annotations

import contextlib
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import IO

ROOT = Path(__file__).resolve().parents[1]
FAILED, NOTHING = 1, 5  # exit codes of pytest after failed tests, and where no test was selected
ENDLESS = 124  # our exit code of a part that did not end
LIMIT = 3600.0  # [s] a part that takes longer is ended
KEPT = ROOT / "tools" / "processor_times.json"  # [s] of each folder of tests, when they were last kept
ROWS = 10  # number of folders that the end lists
#: Number of tests in real time that run at once. A simulated robot and its client are several processes, some with
#: real-time priority, which wait for each other most of the time.
AT_ONCE = 2
LAST = ("nice", "-n", "19")  # runs a command when no other one wants the processor
REAL_TIME = (
    "tests/ros",
    "tests/devices/test_haply.py",
    "tests/realtime/test_no_allocation.py",
    "tests/package/test_readme.py",
    "tests/package/test_wheel.py",
)
#: Each part has its own list of failures.
PARTS = {
    "computing": ["-o", "cache_dir=.pytest_cache/computing", *(f"--ignore={path}" for path in REAL_TIME), "tests"],
    "real time": ["-o", "cache_dir=.pytest_cache/realtime", *REAL_TIME],
}
#: A worker that a test has ended repeats this test in its successor: one successor, no more.
SPREAD = ["--dist", "loadfile", "--max-worker-restart", "1", "--durations", "20", "--no-loadscope-reorder"]
PARALLEL = {
    "computing": ["-n", str(1 + (os.cpu_count() or 1)), *SPREAD],  # some wait for a browser or a process
    "real time": ["-n", str(AT_ONCE), *SPREAD],
}


def compile_once() -> None:
    """Compile the modules of all tests that are new, one process for each core.

    Workers start at the same time, and each of them would compile all modules, which takes most of a minute.
    """

    def compiled(file: Path) -> bool:
        times = (one.stat().st_mtime for one in file.parent.glob(f"__pycache__/{file.stem}.*pytest*.pyc"))
        return any(time > file.stat().st_mtime for time in times)

    new = [str(file) for file in sorted((ROOT / "tests").rglob("test_*.py")) if not compiled(file)]
    cores = os.cpu_count() or 1
    collect = [sys.executable, "-m", "pytest", "--collect-only", "-p", "no:cacheprovider"]
    shares = [new[k::cores] for k in range(cores) if new[k::cores]]
    none = subprocess.DEVNULL
    for process in [subprocess.Popen([*collect, *share], cwd=ROOT, stdout=none, stderr=none) for share in shares]:
        process.wait()


@contextlib.contextmanager
def started(
    part: str, *options: str, before: tuple[str, ...] = (), out: IO[bytes] | None = None
) -> Iterator[subprocess.Popen[bytes]]:
    """A process that runs a part; it is killed at the end of the context, if the user interrupts for instance.

    Args:
        part: key of PARTS.
        options: of pytest.
        before: words before the command.
        out: file for the output; none: that of this process.
    """
    command = [*before, sys.executable, "-m", "pytest", *PARTS[part], *options]
    process = subprocess.Popen(
        command, cwd=ROOT, process_group=0, stdout=out, stderr=out
    )  # its workers are in its group
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):  # all have ended
            os.killpg(process.pid, signal.SIGKILL)


def code_of(process: subprocess.Popen[bytes], part: str) -> int:
    """The exit code of pytest, or ENDLESS."""
    try:
        return process.wait(LIMIT)
    except subprocess.TimeoutExpired:
        print(f"tests: the part {part} did not end within {LIMIT:.0f} s and is killed", flush=True)
        return ENDLESS


def both(*options: str) -> dict[str, int]:
    """Run both parts beside each other; returns the exit code of each. The output of one follows that of the other."""
    codes = {}
    with tempfile.TemporaryFile() as out:
        with started("computing", *PARALLEL["computing"], *options, before=LAST, out=out) as computing:
            print("--- tests: real time, and beside them those that compute ---", flush=True)
            with started("real time", *PARALLEL["real time"], *options) as real_time:
                codes["real time"] = code_of(real_time, "real time")
            print("--- tests: computing; their output follows when they have ended ---", flush=True)
            codes["computing"] = code_of(computing, "computing")
        out.seek(0)
        print(out.read().decode(errors="replace"), flush=True)
    return codes


def alone(part: str, *options: str) -> int:
    """Run a part with nothing beside it; returns its exit code."""
    with started(part, *options) as process:
        return code_of(process, part)


def processor_times() -> Counter[str]:
    """Processor time of each folder of tests in this run [s]; tests/conftest.py keeps that of each part."""
    found: Counter[str] = Counter()
    for options in PARTS.values():
        file = ROOT / options[1].removeprefix("cache_dir=") / "v" / "palpate" / "processor_time"
        found.update(json.loads(file.read_text()) if file.is_file() else {})
        file.unlink(missing_ok=True)
    return found


def growth(now: Counter[str]) -> str:
    """Table of the folders that took most processor time, with their share of all folders, now and in KEPT."""
    before = Counter(json.loads(KEPT.read_text())) if KEPT.is_file() else Counter[str]()
    lines = ["processor time of the tests     CPU-s  share  share kept"]
    for name, seconds in now.most_common(ROWS):
        kept = f"{100 * before[name] / before.total():.1f} %" if name in before else "new" if before else "-"
        lines.append(f"  {name:28s} {seconds:6.0f} {100 * seconds / now.total():5.1f} % {kept:>9s}")
    return "\n".join(lines)


def main(arguments: list[str]) -> int:
    """Run the tests; 0 if all passed, at the latest when they were repeated."""
    began = time.monotonic()
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # processes that tests start would compile all that they import
    options = [a for a in arguments if a not in ("--long", "--keep")]
    if "--long" in arguments:
        os.environ["PALPATE_LONG"] = "1"  # tests/effort.py
        options += ["-m", "long or hypothesis"]
    compile_once()
    processor_times()  # deletes those of an earlier run
    codes = both(*options)
    times = processor_times()
    for part in [part for part, code in codes.items() if code == FAILED]:
        print(f"--- tests that failed ({part}) are repeated, one after the other ---", flush=True)
        codes[part] = alone(part, "--last-failed", *options)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    if times:
        print(growth(times))
    if "--keep" in arguments:
        KEPT.write_text(
            json.dumps({name: round(seconds, 1) for name, seconds in sorted(times.items())}, indent=1) + "\n"
        )
    print(f"tests: {time.monotonic() - began:.0f} s, {used.ru_utime + used.ru_stime:.0f} CPU-s, {os.cpu_count()} cores")
    return max((code for code in codes.values() if code != NOTHING), default=NOTHING)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
