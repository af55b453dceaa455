"""Runs all tests: first those that only compute, then those in real time, for which they would leave no processor.

    python tools/tests.py [--long] [options of pytest]

A browser or a process may miss its deadline on a busy machine: a test that fails is repeated with nothing beside it,
and must pass then. A test that does not end fails after ten minutes (pyproject.toml), a part after LIMIT. The end tells
the wall time and the processor time, and each part lists its slowest tests, so that growth is seen. --long runs the
tests of the marker `long`, which add cases to short versions, and the property tests with all their examples.
"""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FAILED, NOTHING = 1, 5  # exit codes of pytest after failed tests, and where no test was selected
ENDLESS = 124  # our exit code of a part that did not end
LIMIT = 1800.0  # [s] a part that takes longer is ended
#: Number of tests in real time that run at once. A simulated robot and its client are several processes, some with
#: real-time priority, which wait for each other most of the time: two tests use half of two cores.
AT_ONCE = 3
REAL_TIME = (
    "tests/ros",
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
SPREAD = ["--dist", "loadfile", "--max-worker-restart", "1", "--durations", "20"]
PARALLEL = {
    "computing": ["-n", str(1 + (os.cpu_count() or 1)), *SPREAD, "--no-loadscope-reorder"],  # some wait for a browser
    "real time": ["-n", str(AT_ONCE), *SPREAD, "--no-loadscope-reorder"],
}


def run(part: str, *options: str) -> int:
    """Run a part, and return the exit code of pytest, or ENDLESS."""
    command = [sys.executable, "-m", "pytest", *PARTS[part], *options]
    process = subprocess.Popen(command, cwd=ROOT, process_group=0)  # its workers have the same group
    try:
        return process.wait(LIMIT)
    except subprocess.TimeoutExpired:
        print(f"tests: the part {part} did not end within {LIMIT:.0f} s and was killed", flush=True)
        return ENDLESS
    finally:
        with contextlib.suppress(ProcessLookupError):  # it did not end, or the user interrupts
            os.killpg(process.pid, signal.SIGKILL)


def main(arguments: list[str]) -> int:
    """Run the tests; 0 if all passed, at the latest when they were repeated."""
    began = time.monotonic()
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # processes that tests start would compile all that they import
    options = [a for a in arguments if a != "--long"]
    if "--long" in arguments:
        os.environ["PALPATE_LONG"] = "1"  # tests/effort.py
        options += ["-m", "long or hypothesis"]
    codes = {}
    for part, parallel in PARALLEL.items():
        print(f"--- tests: {part} ---", flush=True)
        codes[part] = run(part, *parallel, *options)
        if codes[part] == FAILED:
            print(f"--- tests that failed ({part}) are repeated, one after the other ---", flush=True)
            codes[part] = run(part, "--last-failed", *options)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"tests: {time.monotonic() - began:.0f} s, {used.ru_utime + used.ru_stime:.0f} CPU-s, {os.cpu_count()} cores")
    return max((code for code in codes.values() if code != NOTHING), default=NOTHING)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
