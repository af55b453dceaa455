"""Runs of a scene's pairs, each alone and all together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from rich.table import Table

from palpate.base.arrays import Array
from palpate.base.errors import PalpateError
from palpate.devices.certificate.scene import certificates, worst_of
from palpate.devices.certificate.touched import touched
from palpate.record.reader import Record
from palpate.record.ticks import Ticks
from palpate.scene import Scene
from palpate.scene.rig import build
from palpate.session import PairsSession, Session
from palpate.session.summary import Summary

LONGEST = 600.0
"""Longest simulated time [s]."""


@dataclass(frozen=True)
class Row:
    """What one hand feels alone, and what the others add; forces on the hand."""

    pair: str
    peak_alone_N: float
    peak_N: float
    peak_50ms_alone_N: float  # largest mean of the force over 50 ms
    peak_50ms_N: float
    added_mean_N: float  # mean magnitude of the difference of the force, while it differs
    added_peak_N: float
    added_s: float  # time in which the force differs
    instrument_peak_N: float  # force of the other instruments on the tool
    contact_s: float  # time in which another instrument touches
    K_surface_N_per_m: float  # stiffest object
    K_with_instrument_N_per_m: float
    verdict_alone: str
    verdict_with_instrument: str
    stable_below_N_per_m: float | None  # with the instrument of another pair; None: no limit


@dataclass(frozen=True)
class Found:
    """A row with the forces on the hand (n,) [N] at the times t (n,) [s]."""

    row: Row
    t: Array
    alone: Array
    together: Array


def run(file: Path, pair: str = "", duration: float | None = None) -> list[Found]:
    """Run every pair alone and all together, in lockstep.

    Args:
        file: scene with the section `pairs`.
        pair: the only pair to study; empty: all.
        duration: simulated time [s]; the scene's when left out.

    Raises:
        PalpateError: the scene has no pairs, or the duration is out of range. SceneError: the scene cannot run.
    """
    scene = Scene.load(file)
    if not scene.pairs:
        mend = "run it with palpate run, or give it a section pairs"
        raise PalpateError("the study compares pairs, and the scene has one", where=scene.file, mend=mend)
    seconds = scene.duration if duration is None else duration
    if not 0.0 < seconds <= LONGEST:
        raise PalpateError(f"--duration {seconds:g}: must be above 0 and at most {LONGEST:g} s", mend="e.g. 5")
    if pair:
        scene.pair(pair)  # refuses an unknown name
    summaries, ticks = _together(scene, seconds)
    names = [pair] if pair else list(scene.pairs)
    return [_compared(scene, name, _alone(scene, name, seconds), (summaries[name], ticks[name])) for name in names]


def _together(scene: Scene, seconds: float) -> tuple[dict[str, Summary], dict[str, Ticks]]:
    with TemporaryDirectory() as folder:
        found = PairsSession(scene, out=folder).run(seconds).pairs
        return found, {name: _ticks(one) for name, one in found.items()}


def _alone(scene: Scene, name: str, seconds: float) -> tuple[Summary, Ticks]:
    """The pair alone, with the seed that its hand has beside the others."""
    seed = (scene.seed + list(scene.pairs).index(name)) % 2**64
    with TemporaryDirectory() as folder:
        found = Session(scene.pair(name), out=folder, seed=seed).run(seconds)
        return found, _ticks(found)


def _ticks(summary: Summary) -> Ticks:
    assert summary.record is not None
    return Record.open(summary.record).ticks


def _compared(scene: Scene, name: str, alone: tuple[Summary, Ticks], together: tuple[Summary, Ticks]) -> Found:
    (one, without), (other, beside) = alone, together
    n = min(len(without), len(beside))
    difference = np.linalg.norm(beside["F_H_L"][:n] - without["F_H_L"][:n], axis=1)
    dt, differs = 1.0 / scene.rates.haptic, difference > 0.0
    rig = build(scene.pair(name))
    K = max(surface.K for surface in touched(rig))
    both = K + scene.instruments.stiffness
    own, shared = (worst_of(certificates(rig.scene, stiffness, None, rig)) for stiffness in (None, both))
    pushes = np.linalg.norm(beside["F_instrument_W"], axis=1)
    row = Row(
        pair=name,
        peak_alone_N=one.peak_force_N,
        peak_N=other.peak_force_N,
        peak_50ms_alone_N=one.peak_50ms_N,
        peak_50ms_N=other.peak_50ms_N,
        added_mean_N=float(difference[differs].mean()) if differs.any() else 0.0,
        added_peak_N=float(difference.max(initial=0.0)),
        added_s=float(dt * differs.sum()),
        instrument_peak_N=float(pushes.max(initial=0.0)),
        contact_s=float(dt * (beside["instrument_gap"] < 0.0).sum()),
        K_surface_N_per_m=float(K),
        K_with_instrument_N_per_m=float(both),
        verdict_alone=own.verdict or "",
        verdict_with_instrument=shared.verdict or "",
        stable_below_N_per_m=float(shared.k_max) if np.isfinite(shared.k_max) else None,
    )
    forces = (np.linalg.norm(t["F_H_L"][:n], axis=1) for t in (without, beside))
    return Found(row, beside["t"][:n], *forces)


def table(rows: Sequence[Row]) -> Table:
    """The rows as a table."""
    found = Table(title="What each hand feels, alone and beside the others (simulated)")
    for head in ("pair", "peak alone", "together", "added", "instruments touch", "stiffness", "verdict"):
        found.add_column(head)
    for r in rows:
        below = "without limit" if r.stable_below_N_per_m is None else f"below {r.stable_below_N_per_m:.0f} N/m"
        found.add_row(
            r.pair,
            f"{r.peak_alone_N:.2f} N, {r.peak_50ms_alone_N:.2f} over 50 ms",
            f"{r.peak_N:.2f} N, {r.peak_50ms_N:.2f} over 50 ms",
            f"{r.added_mean_N:.3f} N, at most {r.added_peak_N:.2f} N, for {r.added_s:.2f} s",
            f"{r.contact_s:.2f} s, up to {r.instrument_peak_N:.2f} N",
            f"{r.K_surface_N_per_m:g} N/m, with an instrument {r.K_with_instrument_N_per_m:g} N/m",
            f"{r.verdict_alone}, with an instrument {r.verdict_with_instrument} ({below})",
        )
    return found
