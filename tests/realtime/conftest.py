"""Programs that count allocations, locks and system calls of a process."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent


def compiled(folder: Path, source: str, name: str, *flags: str) -> Path:
    compiler = os.environ.get("CXX") or shutil.which("c++") or shutil.which("g++")
    if compiler is None:
        pytest.skip("no C++ compiler: heap_guard.cpp cannot be built")
    warnings = ["-Wall", "-Wextra", "-Werror"]
    subprocess.run([compiler, "-std=c++20", "-O2", *warnings, *flags, "-o", folder / name, HERE / source], check=True)
    return folder / name


@pytest.fixture(scope="session")
def guard(tmp_path_factory) -> Path:
    flags = ("-shared", "-fPIC", "-ldl", "-pthread")
    return compiled(tmp_path_factory.mktemp("guard"), "heap_guard.cpp", "heap_guard.so", *flags)


@pytest.fixture(scope="session")
def watch(tmp_path_factory) -> Path:
    return compiled(tmp_path_factory.mktemp("watch"), "syscall_watch.cpp", "syscall_watch")


@pytest.fixture(scope="session")
def watched(guard):
    """A function that runs a case of watched.py under the guard, and returns its counts."""

    def run(*arguments: str, **environment: str) -> dict:
        done = subprocess.run(
            [sys.executable, HERE / "watched.py", *arguments],
            env={**os.environ, "LD_PRELOAD": str(guard), **environment},
            capture_output=True,
            text=True,
            timeout=120,
        )
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run
