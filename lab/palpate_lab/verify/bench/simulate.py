"""`palpate bench simulate`: speed of parallel runs compared with consecutive sessions.

Both compute the same runs of the palpation scene with different stiffnesses. They alternate, so that both see the same
load of the machine. The memory per run is the growth of this process per additional concurrent run.
"""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TypedDict

import numpy as np
from rich.table import Table

from palpate.base.sweep.local import cores
from palpate.scene import Scene, shipped
from palpate.session import Session
from palpate.session.batch import MEASURED, Variation, simulate
from palpate.session.batch.one import BatchOptions, SharedSurfaces, simulate_one

RUNS, SECONDS, TURNS = 40, 5.0, 2
_SOFTEST, _STIFFEST = 200.0, 600.0  # range of the stiffness [N/m]
_ALIVE = 12  # number of concurrent runs for the memory measurement


Numbers = dict[str, bool | int | float]
"""The numbers of a summary that do not depend on the machine, by key."""


class Figures(TypedDict):
    """Result of the benchmark. The keys are the documented contract of ``--json``."""

    runs: int
    sessions: int
    simulated_s: float
    workers: int
    sessions_s: float
    simulate_s: float
    share: float
    shares: list[float]
    identical: bool
    memory_per_run_bytes: float
    load: float


def run(
    runs: int = RUNS,
    seconds: float = SECONDS,
    turns: int = TURNS,
    scene: Path | None = None,
    on_progress: Callable[[str], None] = lambda _: None,
    sessions: int = 0,
) -> Figures:
    """Measure; the result has the keys of `palpate bench simulate` in docs/json.md.

    Args:
        runs: number of runs of each kind per turn.
        seconds: simulated time of a run [s].
        turns: number of alternations of sessions and `simulate`.
        scene: scene file; default: the shipped palpation scene.
        on_progress: called after each measurement.
        sessions: number of runs that are also single sessions, spread over all; their time is scaled to all runs.
            0: every run.
    """
    base = Scene.load(scene or shipped.file("palpation"))
    variations = [Variation(base, {"objects.0.stiffness": float(K)}) for K in np.linspace(_SOFTEST, _STIFFEST, runs)]
    memory = _memory_of_a_run(variations[0])
    sample = np.unique(np.linspace(0, runs - 1, min(sessions or runs, runs)).round().astype(int)).tolist()
    took, same = _alternate(variations, sample, seconds, turns, on_progress)
    consecutive, parallel = (statistics.median(took[name]) for name in took)
    return {
        "runs": runs,
        "sessions": len(sample),
        "simulated_s": seconds,
        "workers": cores(),
        "sessions_s": consecutive,
        "simulate_s": parallel,
        "share": parallel / consecutive,
        "shares": [b / a for a, b in zip(took["sessions"], took["simulate"], strict=True)],
        "identical": same,
        "memory_per_run_bytes": memory,
        "load": os.getloadavg()[0],
    }


def _alternate(
    variations: list[Variation],
    sample: list[int],
    seconds: float,
    turns: int,
    on_progress: Callable[[str], None],
) -> tuple[dict[str, list[float]], bool]:
    """Times of all turns [s] for sessions and for `simulate`, and whether both compute the same numbers.

    Sessions compute the variations of the sample alone, and their time is scaled to all.
    """
    took: dict[str, list[float]] = {"sessions": [], "simulate": []}
    same = True
    for turn in range(turns):
        answers: dict[str, list[Numbers]] = {}
        for name in took if turn % 2 == 0 else reversed(took):
            began = time.perf_counter()
            some = [variations[i] for i in sample] if name == "sessions" else variations
            compute = _consecutive if name == "sessions" else _parallel
            answers[name] = compute(some, seconds)
            spent = time.perf_counter() - began
            took[name].append(spent * len(variations) / len(some))
            on_progress(f"{len(some)} runs of {seconds:g} s, {name}: {spent:.1f} s")
        same = same and answers["sessions"] == [answers["simulate"][i] for i in sample]
    return took, same


def _consecutive(variations: list[Variation], seconds: float) -> list[Numbers]:
    found = (asdict(Session(variation.resolved()).run(seconds)) for variation in variations)
    return [_deterministic(summary) for summary in found]


def _parallel(variations: list[Variation], seconds: float) -> list[Numbers]:
    summary = simulate(variations, seconds).summary
    rows = ({key: values[i].item() for key, values in summary.items()} for i in range(len(variations)))
    return [_deterministic(row) for row in rows]


def _deterministic(summary: Mapping[str, object]) -> Numbers:
    return {k: v for k, v in summary.items() if isinstance(v, (bool, int, float)) and k not in MEASURED}


def _memory_of_a_run(variation: Variation) -> float:
    """Resident memory per concurrent run, without the mesh and its index, which all runs share [bytes]."""
    shared, options = SharedSurfaces(), BatchOptions(0.2, (), 100.0)
    simulate_one(shared, 0, variation, options)  # allocates shared data: mesh, modules, first pages of the allocator
    before, alive = _resident(), []
    for _ in range(_ALIVE):
        rig = shared.rig(variation, SECONDS)
        sim = rig.simulation()
        alive.append((rig, sim, sim.run(100)))
    return (_resident() - before) / len(alive)


def _resident() -> int:
    """Resident memory of this process [bytes]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")


def table(result: Figures) -> Table:
    """The result as a table for a terminal."""
    title = f"{result['runs']} runs of {result['simulated_s']:g} s, simulated, in turns, medians"
    out = Table(title=title, box=None, padding=(0, 2, 0, 0), title_justify="left")
    for column, side in (("", "left"), ("seconds", "right"), ("runs a second", "right")):
        out.add_column(column, justify="right" if side == "right" else "left")
    for words, took in (("sessions one by one", result["sessions_s"]), ("palpate.simulate", result["simulate_s"])):
        out.add_row(words, f"{took:.1f}", f"{result['runs'] / took:.1f}")
    same = "the same numbers" if result["identical"] else "DIFFERENT NUMBERS"
    out.caption_justify = "left"
    out.caption = (
        f"{result['sessions']} of the runs measured as sessions;\n"
        f"{100 * result['share']:.0f} % of the time with {result['workers']} threads; {same};\n"
        f"{result['memory_per_run_bytes'] / 2**20:.2f} MB a run in flight; load of the machine {result['load']:.1f}"
    )
    return out
