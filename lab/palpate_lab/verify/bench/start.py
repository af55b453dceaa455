"""`palpate bench start`: start-up times of new processes (medians), alternating with a control process.

The control is an interpreter of this environment that imports numpy and ends. Absolute times differ by a factor of
three between machines; the ratio to the control is comparable.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypedDict

from rich.table import Table

from palpate.base.errors import PalpateError
from palpate.scene import shipped

RUNS = 7

#: Runs the command line until the first batch of ticks has been simulated, and ends there.
_TO_FIRST_TICK = """
import os, sys
from palpate.cli import main
from palpate.session import Session
Session._take = Session._take_behind = lambda *_, **__: os._exit(0)
sys.exit(main(sys.argv[1:]) or 1)
"""


class Figures(TypedDict):
    """Result of the benchmark: medians [s]. The keys are the documented contract of ``--json``."""

    help_s: float
    first_tick_s: float
    check_s: float
    control_s: float
    runs: int
    scene: str
    seconds: dict[str, list[float]]
    """Times of all runs, by the key of their median."""
    cores: int | None
    load: float


def run(runs: int = RUNS, scene: Path | None = None, on_progress: Callable[[str], None] = lambda _: None) -> Figures:
    """Measure; the result has the keys of `palpate bench start` in docs/json.md.

    Args:
        runs: number of runs per command; one additional first run fills the caches of the system and of Palpate.
        scene: scene of `palpate run` and `palpate check`; default: the shipped scene.
        on_progress: called after each measurement.
    """
    path = str(scene or shipped.file("palpation"))
    with tempfile.TemporaryDirectory() as folder:
        commands = {
            "help_s": ["-m", "palpate", "--help"],
            "first_tick_s": ["-c", _TO_FIRST_TICK, "run", path, "--headless", "--out", folder],
            "check_s": ["-m", "palpate", "check", path],
            "control_s": ["-c", "import numpy"],
        }
        seconds: dict[str, list[float]] = {name: [] for name in commands}
        for turn in range(runs + 1):
            for name, command in commands.items():
                took = _timed(command, folder)
                if turn > 0:
                    seconds[name].append(took)
            on_progress(f"turn {turn} of {runs}" if turn > 0 else "caches are filled")
    return {
        "help_s": statistics.median(seconds["help_s"]),
        "first_tick_s": statistics.median(seconds["first_tick_s"]),
        "check_s": statistics.median(seconds["check_s"]),
        "control_s": statistics.median(seconds["control_s"]),
        "runs": runs,
        "scene": path,
        "seconds": seconds,
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0],
    }


def _timed(command: list[str], folder: str) -> float:
    """Seconds from the start of a fresh interpreter to its end."""
    guard = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"  # set by the ROS 2 wheels in this process, but not in a user's shell
    environment = {name: value for name, value in os.environ.items() if name != guard}
    began = time.perf_counter()
    done = subprocess.run([sys.executable, *command], env=environment, cwd=folder, capture_output=True, text=True)
    took = time.perf_counter() - began
    if done.returncode != 0:
        raise PalpateError(f"{' '.join(command[-4:])} failed", why=done.stderr[-400:], mend="run it by itself")
    return took


def table(result: Figures) -> Table:
    """The result as a table for a terminal."""
    title = f"from the start of a process, medians of {result['runs']} runs in turns"
    out = Table(title=title, box=None, padding=(0, 2, 0, 0), title_justify="left")
    out.add_column("command")
    out.add_column("seconds", justify="right")
    out.add_column("controls", justify="right")
    rows = {
        "palpate --help": result["help_s"],
        "palpate run, to its first ticks": result["first_tick_s"],
        "palpate check": result["check_s"],
        "control: python -c 'import numpy'": result["control_s"],
    }
    for words, seconds in rows.items():
        out.add_row(words, f"{seconds:.2f}", f"{seconds / result['control_s']:.1f}")
    out.caption_justify = "left"
    out.caption = f"{result['scene']}; load of the machine {result['load']:.1f} on {result['cores']} cores"
    return out
