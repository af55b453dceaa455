"""Runs all tests: those in real time one after the other, and those that only compute in the processor time they leave.

    python tools/tests.py [--long] [options of pytest]

A browser or a process may still miss its deadline on a busy machine: a test that fails is repeated with nothing beside
it, and must pass then. A test that does not end fails after ten minutes (pyproject.toml), a part after LIMIT. The end
tells the wall time and the processor time, and each part lists its slowest tests, so that growth is seen. --long runs
the tests of the marker `long`, which add cases to short versions, and the property tests with all their examples.
"""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
FAILED, NOTHING = 1, 5  # exit codes of pytest after failed tests, and where no test was selected
ENDLESS = 124  # our exit code of a part that did not end
LIMIT = 2700.0  # [s] a part that takes longer is ended
WORKERS = max(2, os.cpu_count() or 1)
#: A simulated robot and its client are several processes, some with real-time priority: these tests run one by one.
REAL_TIME = ("tests/ros", "tests/realtime", "tests/package")
#: Each part has its own list of failures.
PARTS = {
    "real time": ["-o", "cache_dir=.pytest_cache/realtime", *REAL_TIME],
    "computing": ["-o", "cache_dir=.pytest_cache/computing", *(f"--ignore={folder}" for folder in REAL_TIME), "tests"],
}
#: A worker that a test has ended repeats this test in its successor: one successor, no more.
SPREAD = ["--dist", "loadfile", "--max-worker-restart", "1", "--durations", "20"]
PARALLEL = {
    "real time": ["-n", "1", *SPREAD],
    "computing": ["-n", str(WORKERS), *SPREAD, "--no-loadscope-reorder"],
}


def command(part: str, *more: str) -> list[str]:
    """The command line of a part."""
    return [sys.executable, "-m", "pytest", *PARTS[part], *more]


def give_way() -> None:
    """Let this process and its children run only when no other process wants the processor."""
    with contextlib.suppress(AttributeError, OSError):  # Linux alone has this policy
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))


def beside(options: list[str]) -> dict[str, int]:
    """Run both parts beside each other and return their exit codes."""
    end = time.monotonic() + LIMIT
    with tempfile.TemporaryFile() as output:
        parts = {
            "real time": started("real time", *options, stdout=output, stderr=subprocess.STDOUT),
            "computing": started("computing", *options, preexec_fn=give_way),
        }
        try:
            codes = {name: ended(parts[name], end - time.monotonic()) for name in ("computing", "real time")}
        finally:
            for part in parts.values():
                kill(part)
        output.seek(0)
        print("--- tests in real time ---", flush=True)
        sys.stdout.buffer.write(output.read())
        sys.stdout.flush()
    for name in [name for name, code in codes.items() if code == ENDLESS]:
        print(f"tests: the part {name} did not end within {LIMIT:.0f} s and was killed", flush=True)
    return codes


def started(part: str, *options: str, **more: Any) -> subprocess.Popen[bytes]:
    """A part, with its workers in a process group of its own."""
    return subprocess.Popen(command(part, *PARALLEL[part], *options), cwd=ROOT, process_group=0, **more)


def ended(part: subprocess.Popen[bytes], seconds: float) -> int:
    """The exit code of a part; ENDLESS if it runs longer."""
    try:
        return part.wait(max(1.0, seconds))
    except subprocess.TimeoutExpired:
        return ENDLESS


def kill(part: subprocess.Popen[bytes]) -> None:
    """Kill what is left of a part: it did not end, or the user interrupts."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(part.pid, signal.SIGKILL)


def main(arguments: list[str]) -> int:
    """Run the tests; 0 if all passed, at the latest when they were repeated."""
    began = time.monotonic()
    options = [a for a in arguments if a != "--long"]
    if "--long" in arguments:
        os.environ["PALPATE_LONG"] = "1"  # tests/effort.py
        options += ["-m", "long or hypothesis"]
    codes = beside(options)
    for part, code in codes.items():
        if code == FAILED:
            print(f"--- tests that failed ({part}) are repeated, one after the other ---", flush=True)
            codes[part] = subprocess.run(command(part, *options, "--last-failed"), cwd=ROOT, check=False).returncode
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"tests: {time.monotonic() - began:.0f} s, {used.ru_utime + used.ru_stime:.0f} CPU-s, {os.cpu_count()} cores")
    return max((code for code in codes.values() if code != NOTHING), default=NOTHING)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
