"""How long from a fresh clone to the first force? Wall and CPU time of `make demo` with empty package caches.

    python tools/first_force.py            # clones this repository's HEAD into a temporary folder

The control is that of `palpate bench build` in the new clone: one file that includes Eigen and one header of Pinocchio.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def timed(command: list[str], folder: Path, environment: dict[str, str]) -> tuple[float, float]:
    """Wall and CPU seconds of a command and all that it starts; ends this program when the command fails."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)} failed:\n{(done.stdout + done.stderr)[-2000:]}")
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Clone, run the demo, compile the control, print one line for each."""
    with tempfile.TemporaryDirectory(prefix="palpate-clone-") as name:
        clone, cache = Path(name) / "palpate", Path(name) / "cache"
        environment = {**os.environ, "UV_CACHE_DIR": str(cache / "uv"), "PIP_CACHE_DIR": str(cache / "pip"),
                       "XDG_CACHE_HOME": str(cache), "CCACHE_DISABLE": "1"}  # fmt: skip
        environment.pop("VIRTUAL_ENV", None)
        timed(["git", "clone", "--quiet", str(ROOT), str(clone)], Path(name), environment)
        wall, whole = timed(["make", "demo", "ARGS=--headless --duration 5"], clone, environment)
        print(f"fresh clone to the end of the demo: {wall:.0f} s of wall time, {whole:.0f} CPU-seconds")
        wall, cpu = timed(["make", "demo", "ARGS=--headless --duration 5"], clone, environment)
        print(f"the demo a second time: {wall:.1f} s of wall time, {cpu:.1f} CPU-seconds")
        command = [str(clone / ".venv/bin/palpate"), "bench", "build", "--last", "--json", "control.json"]
        timed(command, clone, environment)
        control = json.loads((clone / "control.json").read_text())["control_cpu_s"]
        print(f"control, Eigen and one header of Pinocchio: {control:.1f} CPU-seconds; ratio {whole / control:.1f}")


if __name__ == "__main__":
    main()
