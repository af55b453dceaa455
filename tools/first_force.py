"""How long from a fresh clone to the first force? Wall and CPU time of `make demo` with empty package caches, up to the
first line that tells a force, and to the end, when the demo has written its report.

    python tools/first_force.py            # clones this repository's HEAD into a temporary folder

The control is that of `palpate bench build` in the new clone: one file that includes two headers of Eigen.
"""

from __future__ import annotations

import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FORCE = re.compile(r"force +(?!0\.00)[0-9.]+ N ")


def timed(command: list[str], folder: Path, environment: dict[str, str]) -> tuple[float, float]:
    """Wall and CPU seconds of a command and all that it starts; ends this program when the command fails."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)} failed:\n{(done.stdout + done.stderr)[-2000:]}")
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def until_force(command: list[str], folder: Path, environment: dict[str, str]) -> tuple[float, float]:
    """Wall and CPU seconds of a command up to its first line with a force; then lets it end."""
    began = time.perf_counter()
    with subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        lines = (line for line in process.stdout if FORCE.search(line))
        felt = next(((time.perf_counter() - began, spent(process.pid)) for _ in lines), None)
        process.stdout.read()
    if process.returncode != 0 or felt is None:
        sys.exit(f"{' '.join(command)} failed, or told no force")
    return felt


def spent(process: int) -> float:
    """CPU seconds of a process and its descendants; those that have ended are in the figures of who waited for them."""
    tasks = Path(f"/proc/{process}/task")
    children = [int(child) for task in tasks.iterdir() for child in (task / "children").read_text().split()]
    times = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[11:15]
    return sum(map(int, times)) / os.sysconf("SC_CLK_TCK") + sum(map(spent, children))


def main() -> None:
    """Clone, run the demo, compile the control, print one line for each."""
    with tempfile.TemporaryDirectory(prefix="palpate-clone-") as name:
        clone, cache = Path(name) / "palpate", Path(name) / "cache"
        environment = {**os.environ, "UV_CACHE_DIR": str(cache / "uv"), "PIP_CACHE_DIR": str(cache / "pip"),
                       "XDG_CACHE_HOME": str(cache), "CCACHE_DISABLE": "1"}  # fmt: skip
        environment.pop("VIRTUAL_ENV", None)
        timed(["git", "clone", "--quiet", str(ROOT), str(clone)], Path(name), environment)
        demo = ["make", "demo", "ARGS=--headless --duration 5"]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        wall, whole = until_force(demo, clone, environment)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        end = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        print(f"fresh clone to the first force: {wall:.0f} s of wall time, {whole:.0f} CPU-seconds; "
              f"with the demo's report {end:.0f}")  # fmt: skip
        wall, cpu = timed(demo, clone, environment)
        print(f"the demo a second time: {wall:.1f} s of wall time, {cpu:.1f} CPU-seconds")
        command = [str(clone / ".venv/bin/palpate"), "bench", "build", "--last", "--json", "control.json"]
        timed(command, clone, environment)
        control = json.loads((clone / "control.json").read_text())["control_cpu_s"]
        print(f"control, two headers of Eigen: {control:.1f} CPU-seconds; ratio {whole / control:.1f}")


if __name__ == "__main__":
    main()
