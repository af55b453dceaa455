"""``palpate study certificate --swings``: the judge of oscillations against the eigenvalues of random loops.

A bilateral loop without friction and counts is linear: it oscillates if an eigenvalue of its sampled motion lies
outside the unit circle. The judge (`core/palpate/verify/swing.hpp`) sees only the simulated motion.
"""

from __future__ import annotations

from typing import Literal, TypedDict

import numpy as np
from rich.console import RenderableType
from rich.table import Table
from scipy.linalg import expm

from palpate import _verify
from palpate.base.sweep.grid import Point
from palpate_lab.studies._command import Sweeper
from palpate_lab.studies.passivity.work import log_uniform

SHORT = 2.0  # duration of the shorter runs [s]
NEAR, NEAR_SHARE = 0.1, 0.4  # K within this distance of the limit, and share of these loops [-]
FAR = (0.3, 3.0)  # K of the other loops over the limit, log-uniform [-]
UNCLEAR = 0.01  # smaller changes of the amplitude within the judged time are not counted [-]
RUNS = {"needed": None, "short": SHORT}  # duration [s]; None: as long as the judge needs


class Judged(TypedDict):
    """Verdicts on the loops whose amplitude changes by 1 % or more within the judged time."""

    run: Literal["needed", "short"]
    growing: int
    growing_called: int
    growing_undecided: int
    decaying: int
    decaying_called: int
    decaying_undecided: int
    agreement: float


class Swings(TypedDict):
    """Result of ``palpate study certificate --swings``."""

    simulated: bool
    seed: int
    loops: int
    runs: list[Judged]


def growth(o: _verify.AxisOptions) -> float:
    """The largest real part of log z / T over the eigenvalues z of the sampled bilateral loop with its delay [1/s]."""
    M, D, T = o.mass + o.hand_mass, o.damping + o.hand_damping, 1.0 / o.rate
    A = np.array([[0.0, 1.0, 0.0], [-o.hand_stiffness / M, -D / M, 1.0 / M], [0.0, 0.0, 0.0]])
    whole = int(o.delay / T + 1e-9)
    late = max(o.delay - whole * T, 0.0)  # the older force acts so long
    old, new = expm(A * late), expm(A * (T - late))
    share = 1.0 - np.exp(-2 * np.pi * o.velocity_cutoff * T) if o.velocity_cutoff > 0.0 else 1.0
    n = 5 + whole  # x, v, the last x, the last filtered velocity, and the forces sent before: the newest first
    W, velocity, force = np.zeros((n, n)), np.zeros(n), np.zeros(n)
    velocity[[0, 2, 3]] = share / T, -share / T, 1.0 - share
    force[0] = -o.K
    force -= o.B * velocity
    sent = np.vstack([force, np.eye(n)[4:]])
    W[:2, :2] = new[:2, :2] @ old[:2, :2]
    W[:2] += np.outer(new[:2, 2], sent[whole]) + np.outer(new[:2, :2] @ old[:2, 2], sent[whole + 1])
    W[2, 0], W[3], W[4] = 1.0, velocity, force
    W[np.arange(5, n), np.arange(4, n - 1)] = 1.0
    return float(np.log(np.abs(np.linalg.eigvals(W)).max()) / T)


def linear(rng: np.random.Generator) -> _verify.AxisOptions:
    """A random bilateral loop without friction and counts, with K around its limit."""
    o = _verify.AxisOptions()
    o.mass, o.damping = log_uniform(rng, 0.05, 1.5), log_uniform(rng, 0.05, 5.0)
    o.rate, o.delay = float(rng.choice([250.0, 1000.0, 4000.0])), rng.uniform(0.0, 0.03)
    o.velocity_cutoff = float(rng.choice([0.0, log_uniform(rng, 10.0, 300.0)]))
    o.B, o.bilateral = float(rng.choice([0.0, log_uniform(rng, 0.1, 8.0)])), True
    o.hand_mass, o.hand_damping = log_uniform(rng, 0.03, 0.8), log_uniform(rng, 0.5, 25.0)
    o.hand_stiffness = float(rng.choice([0.0, log_uniform(rng, 30.0, 1000.0)]))
    near = rng.uniform(1.0 - NEAR, 1.0 + NEAR)
    o.K = _limit(o) * (near if rng.random() < NEAR_SHARE else log_uniform(rng, *FAR))
    return o


def _limit(o: _verify.AxisOptions) -> float:
    """A stiffness at which decay turns into growth, by bisection [N/m]; 1 N/m if damping alone makes the loop grow."""
    low, high = 1.0, 1e6
    while high > 1.001 * low:
        o.K = float(np.sqrt(low * high))
        low, high = (low, o.K) if growth(o) > 0.0 else (o.K, high)
    return float(np.sqrt(low * high))


def judged(point: Point, seed: int) -> dict[str, float | str]:
    """Growth and verdict of one random loop, judged for as long as needed and for 2 s."""
    o = linear(np.random.default_rng(seed))
    true, found = growth(o), dict[str, float | str]()
    for run, seconds in RUNS.items():
        result = _verify.Axis(o).run(duration=seconds, push=1.0, v0=0.1)
        clear = abs(true) * 0.75 * result.duration >= UNCLEAR
        found |= {f"{run}_swing": result.swing, f"{run}_oscillates": float(result.oscillates)}
        found |= {f"{run}_clear": float(clear or result.diverged)}
    return {"growth_per_s": true, **found}


def swings(loops: int, seed: int, sweep: Sweeper) -> Swings:
    """Verdicts on random loops; the keys are those of docs/json.md."""
    rows = sweep(judged, {"loop": range(loops)}, seed, title="swings").rows()
    out: list[Judged] = []
    for run in RUNS:
        clear = [row for row in rows if row[f"{run}_clear"]]
        counts: dict[str, int] = {}
        for name, mine in (("growing", [r for r in clear if r["growth_per_s"] > 0.0]),
                           ("decaying", [r for r in clear if r["growth_per_s"] <= 0.0])):  # fmt: skip
            counts |= {name: len(mine), f"{name}_called": sum(bool(r[f"{run}_oscillates"]) for r in mine),
                       f"{name}_undecided": sum(r[f"{run}_swing"] == "undecided" for r in mine)}  # fmt: skip
        right = counts["growing_called"] + counts["decaying"] - counts["decaying_called"]
        out.append({"run": run, **counts, "agreement": right / len(clear)})  # type: ignore[typeddict-item]
    return {"simulated": True, "seed": seed, "loops": loops, "runs": out}


def table(found: Swings) -> list[RenderableType]:
    """The verdicts as a table for a terminal."""
    out = Table(box=None, pad_edge=False, title=f"{found['loops']} random loops", title_justify="left")
    columns = ("run", "growing", "called", "undecided", "decaying", "called", "undecided", "agreement")
    for column in columns:
        out.add_column(column, justify="left" if column == "run" else "right")
    for row in found["runs"]:
        counts = [str(row[key]) for key in ("growing", "growing_called", "growing_undecided", "decaying",
                                            "decaying_called", "decaying_undecided")]  # fmt: skip
        out.add_row("as long as needed" if row["run"] == "needed" else f"{SHORT:g} s", *counts,
                    f"{100 * row['agreement']:.1f} %")  # fmt: skip
    return [out, "simulated one-axis loops"]
