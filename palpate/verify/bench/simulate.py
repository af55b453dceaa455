"""How much faster are many runs at once than sessions one by one? `palpate bench simulate`.

Both compute the same runs: the palpation scene with another stiffness each. They go in turns, so that both see the same
machine. Memory is the growth of this process by runs that are in flight together, beyond one run alone.
"""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from palpate.batch import MEASURED, Variation, simulate
from palpate.batch.one import BatchOptions, SharedSurfaces, simulate_one
from palpate.scene import Scene
from palpate.session import Session
from palpate.sweep.local import cores
from palpate.verify.bench.start import default_scene

RUNS, SECONDS, TURNS = 40, 5.0, 2
_SOFTEST, _STIFFEST = 200.0, 600.0  # [N/m]
_ALIVE = 12  # runs that are held in memory together


def run(
    runs: int = RUNS,
    seconds: float = SECONDS,
    turns: int = TURNS,
    scene: Path | None = None,
    on_progress: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """Measure; the keys of `palpate bench simulate` in docs/json.md.

    Args:
        runs: of each kind in a turn.
        seconds: simulated time of a run [s].
        turns: sessions and `simulate` take turns, in alternating order.
        scene: the shipped palpation scene when left out.
        on_progress: told what has been measured.
    """
    base = Scene.load(scene or default_scene())
    wanted = [Variation(base, {"objects.0.stiffness": float(K)}) for K in np.linspace(_SOFTEST, _STIFFEST, runs)]
    memory = _memory_of_a_run(wanted[0])
    took: dict[str, list[float]] = {"sessions": [], "simulate": []}
    same = True
    for turn in range(turns):
        answers: dict[str, list[dict[str, Any]]] = {}
        for name in took if turn % 2 == 0 else reversed(took):
            began = time.perf_counter()
            answers[name] = _sessions(wanted, seconds) if name == "sessions" else _at_once(wanted, seconds)
            took[name].append(time.perf_counter() - began)
            on_progress(f"{runs} runs of {seconds:g} s, {name}: {took[name][-1]:.1f} s")
        same = same and answers["sessions"] == answers["simulate"]
    one_by_one, at_once = (statistics.median(took[name]) for name in took)
    return {
        "runs": runs,
        "simulated_s": seconds,
        "workers": cores(),
        "sessions_s": one_by_one,
        "simulate_s": at_once,
        "share": at_once / one_by_one,
        "shares": [b / a for a, b in zip(took["sessions"], took["simulate"], strict=True)],
        "identical": same,
        "memory_per_run_bytes": memory,
        "load": os.getloadavg()[0],
    }


def _sessions(wanted: list[Variation], seconds: float) -> list[dict[str, Any]]:
    found = (asdict(Session(one.resolved()).run(seconds)) for one in wanted)
    return [_fixed(summary) for summary in found]


def _at_once(wanted: list[Variation], seconds: float) -> list[dict[str, Any]]:
    summary = simulate(wanted, seconds).summary
    return [_fixed({key: values[i].item() for key, values in summary.items()}) for i in range(len(wanted))]


def _fixed(summary: dict[str, Any]) -> dict[str, Any]:
    """Numbers that do not depend on the machine."""
    return {k: v for k, v in summary.items() if isinstance(v, (bool, int, float)) and k not in MEASURED}


def _memory_of_a_run(one: Variation) -> float:
    """Resident memory that a run in flight adds, mesh and index apart, which all runs share [bytes]."""
    shared, options = SharedSurfaces(), BatchOptions(0.2, (), 100.0)
    simulate_one(shared, 0, one, options)  # what is made once: the mesh, modules, the allocator's first pages
    before, alive = _resident(), []
    for _ in range(_ALIVE):
        rig = shared.rig(one, SECONDS)
        sim = rig.simulation()
        alive.append((rig, sim, sim.run(100)))
    return (_resident() - before) / len(alive)


def _resident() -> int:
    """Of this process [bytes]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")


def table(result: dict[str, Any]) -> Table:
    """For a terminal."""
    title = f"{result['runs']} runs of {result['simulated_s']:g} s, simulated, in turns, medians"
    out = Table(title=title, box=None, padding=(0, 2, 0, 0), title_justify="left")
    for column, side in (("", "left"), ("seconds", "right"), ("runs a second", "right")):
        out.add_column(column, justify="right" if side == "right" else "left")
    for words, key in (("sessions one by one", "sessions_s"), ("palpate.simulate", "simulate_s")):
        out.add_row(words, f"{result[key]:.1f}", f"{result['runs'] / result[key]:.1f}")
    same = "the same numbers" if result["identical"] else "DIFFERENT NUMBERS"
    out.caption_justify = "left"
    out.caption = (
        f"{100 * result['share']:.0f} % of the time with {result['workers']} threads; {same};\n"
        f"{result['memory_per_run_bytes'] / 2**20:.2f} MB a run in flight; load of the machine {result['load']:.1f}"
    )
    return out
