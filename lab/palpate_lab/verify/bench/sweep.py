"""`palpate bench sweep`: throughput of simulated wall runs of 2 s with one worker process and with several.

In a run, a hand presses a simulated one-axis device into a virtual wall. This process distributes the work and collects
the answers; with as many workers as cores, the speed-up shows the cost of this distribution. The answers must be
identical for any number of workers.
"""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable
from typing import TypedDict, cast

import numpy as np
from rich.table import Table

from palpate import _verify
from palpate.base.sweep import Axis, sweep
from palpate.base.sweep.grid import Point
from palpate.base.sweep.local import cores

RUNS, SECONDS, TURNS = 10_000, 2.0, 3
SEED = 1


class PressResult(TypedDict):
    """Result of one run."""

    oscillates: bool
    peak_m: float
    energy_J: float


class Timed(TypedDict):
    """All turns with one number of processes."""

    workers: int
    seconds: list[float]
    start_s: float
    runs_per_s: float


class SweepBench(TypedDict):
    """Result of the benchmark. The keys are the documented contract of ``--json``."""

    runs: int
    simulated_s: float
    cores: int | None
    load: float
    identical: bool
    rows: list[Timed]
    ratio: float
    ratio_started: float
    ratios: list[float]


def wall_run(point: Point, seed: int) -> dict[str, float | bool]:
    """Simulate 2 s of a press of a random device into a random wall by a random hand."""
    rng = np.random.default_rng(seed)
    o = _verify.AxisOptions()
    o.mass, o.damping, o.coulomb = rng.uniform(0.1, 1.0), rng.uniform(0.1, 2.0), rng.uniform(0.0, 0.3)
    o.delay, o.jitter, o.quantum, o.velocity_cutoff = rng.uniform(0.0, 5e-3), 1e-3, 1e-5, 100.0
    o.K, o.B, o.seed = rng.uniform(100.0, 3000.0), rng.uniform(0.0, 10.0), seed
    o.hand_mass, o.hand_damping, o.hand_stiffness = 0.1, rng.uniform(1.0, 10.0), rng.uniform(50.0, 500.0)
    found = _verify.Axis(o).run(duration=SECONDS, x0=-1e-3, push=rng.uniform(0.5, 3.0))
    return {"oscillates": found.oscillates, "peak_m": found.peak, "energy_J": found.energy_port}


def run(
    runs: int = RUNS, turns: int = TURNS, many: int | None = None, on_progress: Callable[[str], None] = lambda _: None
) -> SweepBench:
    """Measure; the result has the keys of `palpate bench sweep` in docs/json.md. Times include starting the workers."""
    many = many or max(2, cores())
    seconds: dict[int, list[float]] = {1: [], many: []}
    starts: dict[int, list[float]] = {1: [], many: []}
    answers = []
    for turn in range(turns):
        for workers in seconds if turn % 2 == 0 else reversed(seconds):
            starts[workers].append(_timed(workers, workers)[0])
            took, rows = _timed(runs, workers)
            seconds[workers].append(took)
            answers.append(rows)
            on_progress(f"{runs:,} runs, {workers} process(es): {runs / took:.0f} a second")
    total, start = ({w: statistics.median(times) for w, times in runs_of.items()} for runs_of in (seconds, starts))
    return {
        "runs": runs,
        "simulated_s": SECONDS,
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0],
        "identical": all(rows == answers[0] for rows in answers),
        "rows": [
            {"workers": w, "seconds": seconds[w], "start_s": start[w], "runs_per_s": runs / total[w]} for w in seconds
        ],
        "ratio": total[1] / total[many],
        "ratio_started": max(total[1] - start[1], 0.0) / max(total[many] - start[many], 1e-9),
        "ratios": [one / several for one, several in zip(seconds[1], seconds[many], strict=True)],
    }


def _timed(runs: int, workers: int) -> tuple[float, list[PressResult]]:
    begin = time.perf_counter()
    rows = sweep(wall_run, {"run": Axis(range(runs))}, SEED, workers=workers).rows()
    return time.perf_counter() - begin, cast(list[PressResult], rows)


def table(result: SweepBench) -> Table:
    """The result as a table for a terminal."""
    title = f"{result['runs']:,} wall runs of {result['simulated_s']:g} s, simulated, medians"
    out = Table(title=title, box=None, padding=(0, 2, 0, 0), title_justify="left")
    for column in ("processes", "seconds", "starting", "runs a second"):
        out.add_column(column, justify="right")
    for row in result["rows"]:
        out.add_row(str(row["workers"]), f"{statistics.median(row['seconds']):.1f}", f"{row['start_s']:.1f}",
                    f"{row['runs_per_s']:.0f}")  # fmt: skip
    same = "the same numbers" if result["identical"] else "DIFFERENT NUMBERS"
    out.caption_justify = "left"
    out.caption = (
        f"{result['ratio']:.2f} times as fast, {result['ratio_started']:.2f} once started; {same};\n"
        f"load of the machine {result['load']:.1f} on {result['cores']} cores"
    )
    return out
