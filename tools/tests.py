"""Runs all tests: those on ROS 2, whose processes mostly wait, beside the others; repeats failures once, alone.

    python tools/tests.py [--long] [options of pytest]

A browser or a process may miss its deadline on a busy machine: a test that fails is repeated without others beside
it, and must pass then. The end tells the wall time and the processor time, and each part lists its slowest tests, so
that growth is seen. --long runs the tests of the marker `long`, which add cases to short versions, and the property
tests with all their examples.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FAILED, NOTHING = 1, 5  # exit codes of pytest after failed tests, and where no test was selected
WORKERS = max(2, os.cpu_count() or 1)
#: Each part has its own list of failures. Processes of ROS 2 run at 1 kHz: two tests beside each other, no more.
PARTS = {
    "ROS 2": ["-o", "cache_dir=.pytest_cache/ros", "tests/ros"],
    "others": ["-o", "cache_dir=.pytest_cache/others", "--ignore", "tests/ros", "tests"],
}
PARALLEL = {
    "ROS 2": ["-n", "2", "--dist", "loadfile"],
    "others": ["-n", str(WORKERS), "--dist", "loadfile", "--no-loadscope-reorder"],
}


def command(part: str, *more: str) -> list[str]:
    """The command line of a part."""
    return [sys.executable, "-m", "pytest", *PARTS[part], *more]


def beside(options: list[str]) -> dict[str, int]:
    """Run both parts beside each other and return their exit codes; the others give way to ROS 2."""
    with tempfile.TemporaryFile() as output:
        ros = subprocess.Popen(
            command("ROS 2", *PARALLEL["ROS 2"], "--durations", "10", *options),
            cwd=ROOT, stdout=output, stderr=subprocess.STDOUT,
        )  # fmt: skip
        others = subprocess.run(
            command("others", *PARALLEL["others"], "--durations", "20", *options),
            cwd=ROOT, check=False, preexec_fn=lambda: os.nice(5) and None,
        ).returncode  # fmt: skip
        code = ros.wait()
        output.seek(0)
        print("--- tests on ROS 2 ---", flush=True)
        sys.stdout.buffer.write(output.read())
        sys.stdout.flush()
    return {"ROS 2": code, "others": others}


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
