"""Time of a tick with a soft body, next to a control.

A small body steps in the cycle. A large one steps on a thread of its own, once in a period; its time of a tick is the
work of the cycle and of the thread in a period, over the ticks of the period. Both run one after the other here.
"""

from __future__ import annotations

import time
from typing import TypedDict

import numpy as np

from palpate.base.arrays import Array
from palpate.world.tissue.blocks import block
from palpate_lab.verify.bench.tissue.bodies import POISSON, PRONY, TICK, YOUNG, Lab, pressed
from palpate_lab.verify.bench.tissue.rows import Found, at_most

SIZES = {"1k": (7, 7, 4), "5k": (12, 12, 6), "7k": (14, 14, 6), "18k": (20, 20, 8)}
"""Cells of blocks with cells of 10 mm, six tetrahedra each."""
LIMITS = {"7k": 0.35, "18k": 0.75}
"""Largest time of a tick on a machine with the control `CONTROL_MS` [ms]."""
PLACES = {"7k": "in the cycle", "18k": "on a thread"}
CONTROL_MS = 0.136  # control of the machine on which the limits were set


class Times(TypedDict):
    """Times of a tick [ms]."""

    p50: float
    p99: float


def measure(lab: Lab, short: bool = False) -> Found:
    """Times of all sizes, each next to its control; the short version has the smallest body."""
    ticks, controls, rows = {}, [], []
    for size in ["1k"] if short else SIZES:
        before = control(100)
        tets, times = tick_times(SIZES[size], 200 if short else 1500, lab)
        now = control(100)
        controls += [before, now]
        ticks[str(tets)] = times
        if size in LIMITS:
            scaled = times["p50"] * CONTROL_MS / min(before["p50"], now["p50"])
            name = f"tick of {tets:,} tetrahedra {PLACES[size]}, scaled by the control"
            rows.append(at_most(name, scaled, LIMITS[size], "ms"))
    middle = {key: float(np.median([one[key] for one in controls])) for key in ("p50", "p99")}
    return Found(tuple(rows), {"tick_ms": ticks, "control_ms": middle})


def tick_times(cells: tuple[int, int, int], ticks: int = 1500, lab: Lab | None = None) -> tuple[int, Times]:
    """Number of tetrahedra of a block, and times of a tick with a sphere that presses and slides."""
    lab = lab or Lab()
    size = np.array(cells) * 0.01
    nodes, tets = block(cells, size)
    soft = lab.make((nodes, tets), young=YOUNG, poisson=POISSON, prony=PRONY, yeoh=0.5, fixed=nodes[:, 2] == 0.0)
    tips = pressed(5e-3, 5e-3, (0.5 * size[0], 0.5 * size[1]), 0.1, max(ticks * TICK - 0.1, TICK))
    tips[:, 2] += size[2]
    tips[:, 0] += 0.02 * np.sin(np.arange(len(tips)) * TICK * 2.0 * np.pi)
    spent, period = lab.touch(soft, tips, radius=5e-3).latency[100:], max(1, round(soft.period / TICK))
    return len(tets), times_of(spent[: len(spent) // period * period].reshape(-1, period).mean(axis=1))


def control(rounds: int = 400) -> Times:
    """Times of a computation that is not Palpate's: sorting 20,000 numbers."""
    values = np.random.default_rng(0).normal(size=20_000)
    spent = []
    for _ in range(rounds):
        begin = time.perf_counter()
        np.sort(values)
        spent.append(time.perf_counter() - begin)
    return times_of(np.array(spent))


def times_of(seconds: Array) -> Times:
    """Percentiles of times [s], in ms."""
    p50, p99 = np.percentile(1e3 * seconds, [50, 99])
    return {"p50": float(p50), "p99": float(p99)}
