"""Computation of ``palpate study network``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import cast

import numpy as np

from palpate import _network
from palpate.arm.hands import PRESETS
from palpate.base.arrays import Array
from palpate.base.sweep import Axis
from palpate.base.sweep.grid import Point
from palpate.session.network.conditions import Network, burst_loss, network
from palpate_lab.studies._command import Sweeper
from palpate_lab.studies.network.result import Alarm, Moving, Ran, Random, Row
from palpate_lab.studies.network.worlds import SURFACES, Motion, World, options, places

MODES = ("model", "passivity", "direct")
UNKNOWN = "unknown"
"""Of random runs: the mode model in worlds that the scene of both ends does not have."""
WORLDS = ("known", "unknown")
"""Of the random runs, by whether the scene of both ends has them."""
ROUND_TRIPS = (0.02, 0.1, 0.21, 0.5, 0.7)
"""Of the moving worlds [s]."""
LONGEST = 0.5  # round trip of the random runs [s]
BREATHING = (0.005, 4.0)  # amplitude [m] and period [s]
PUSH = 0.005  # [m]
FORCE, PATIENCE = 1.0, 60.0  # of a simulated palpation: force [N], longest time [s]
SETTLE = 60.0  # time after which false alarms count [s]


def figures(r: _network.TrialResult) -> dict[str, float]:
    """The figures of a trial in the units of the result (`Figures`)."""
    return {
        "energy_mJ": 1e3 * min(r.energy_hand, r.energy_site),
        "energy_hand_mJ": 1e3 * r.energy_hand,
        "energy_site_mJ": 1e3 * r.energy_site,
        "energy_ports_mJ": 1e3 * r.energy_ports,
        "felt_over_true": r.felt_over_true,
        "force_rms_N": r.force_rms,
        "force_site_N": r.force_site,
        "kick_N": r.kick,
        "drift_mm": 1e3 * r.drift,
        "round_trip_ms": 1e3 * r.round_trip,
        "lost": r.lost,
        "outages": r.outages,
    }


def trial(mode: str, link: Network, world: World, motion: Motion, seed: int) -> tuple[_network.TrialResult, Array]:
    """One trial: its figures, and a row per tick (n, 19) with the columns trial_columns()."""
    o = options(mode, motion.hand, link.round_trip, seed, world.hidden)
    o.to_site, o.to_operator = link.to_site, link.to_operator
    return _network.trial(o, world.snapshot(True), world.snapshot(False), motion.path(world, link.round_trip))


def palpated(mode: str, link: Network, seed: int) -> float:
    """Time in which a simulated person palpates a plane with `FORCE` at six places [s]; NaN: not within `PATIENCE`."""
    world, o = World(), options(mode, "normal", link.round_trip, seed)
    o.to_site, o.to_operator = link.to_site, link.to_operator
    r = _network.palpation(o, world.snapshot(True), world.snapshot(False), places(world), FORCE, PATIENCE)
    return float(r.palpated) if r.palpated >= 0.0 else math.nan


@cache
def _without_delay(seed: int) -> float:
    return palpated("model", network("none"), seed)


def _condition(point: Point, seed: int) -> dict[str, float]:
    link = network(point["condition"])
    last = max((b + d for b, d in link.to_site.outages), default=0.0)
    motion = Motion(presses=max(6, math.ceil(last) + 2))
    r, _ = trial(point["mode"], link, World(), motion, seed)
    told = 1e3 * r.told_site if last else math.nan
    seconds = palpated(point["mode"], link, seed)
    longer = seconds / _without_delay(seed) - 1.0
    return {**figures(r), "outage_told_ms": told, "palpation_s": seconds, "palpation_longer": longer}


def conditions(names: Sequence[str], modes: Sequence[str], sweep: Sweeper, seed: int) -> list[Row]:
    """A row per condition and mode."""
    rows = sweep(_condition, {"condition": Axis(names), "mode": Axis(modes)}, seed, title="conditions").rows()
    for row in rows:
        for key in ("outage_told_ms", "palpation_s", "palpation_longer"):
            row[key] = None if math.isnan(row[key]) else row[key]
        row.pop("seed", None)
    return cast(list[Row], rows)


def draw(seed: int) -> tuple[Network, World, Motion]:
    """A random network, world and motion."""
    rng = np.random.default_rng(seed)
    round_trip = float(rng.uniform(0.0, LONGEST))
    condition = _network.Condition()
    condition.delay = 0.5 * round_trip
    condition.gilbert = burst_loss(0.2 * float(rng.uniform() < 0.75) * float(rng.uniform(0.5, 1.0)))
    jitter = float(rng.uniform(0.0, 0.05)) * round_trip
    if jitter > 1e-5:
        condition.weights, condition.rates = [1.0], [1.0 / jitter]
    condition.correlation = float(rng.choice([0.0, 0.9]))
    kind = str(rng.choice(SURFACES))
    error = np.clip(rng.normal(0.0, 0.002, 3), -0.004, 0.004)
    turn = float(np.deg2rad(rng.uniform(-1.0, 1.0))) if kind == "registered" else 0.0
    world = World(kind, float(np.exp(rng.uniform(np.log(150.0), np.log(1000.0)))), float(rng.choice([0.0, 0.2, 0.4])),
                  error=(float(error[0]), float(error[1]), float(error[2])), turn=turn)  # fmt: skip
    motion = Motion(str(rng.choice(list(PRESETS))), float(rng.uniform(0.6, 1.5)), 6, float(rng.uniform(0.8, 1.5)),
                    float(rng.uniform(0.0, 0.003)))  # fmt: skip
    return Network("random", condition, condition), world, motion


def _random(point: Point, seed: int) -> dict[str, float]:
    link, world, motion = draw(point["run"])
    mode, hidden = ("model", True) if point["mode"] == UNKNOWN else (point["mode"], False)
    r, _ = trial(mode, link, replace(world, hidden=hidden), motion, point["run"])
    return {**figures(r), "asked_round_trip_ms": 1e3 * link.round_trip}


def random_runs(runs: int, modes: Sequence[str], sweep: Sweeper, seed: int) -> tuple[list[Random], list[Ran]]:
    """Random networks, worlds, hands and motions; the same ones for every mode."""
    if not modes:
        return [], []
    grid = {"run": Axis(range(seed, seed + runs)), "mode": Axis(modes)}
    rows = sweep(_random, grid, seed, title="random").rows()
    mine = cast(list[Ran], rows)
    return [_summed(mode, [r for r in mine if r["mode"] == mode]) for mode in modes], mine


def _summed(mode: str, rows: Sequence[Ran]) -> Random:
    def values(key: str) -> Array:
        found = np.array([r[key] for r in rows], np.float64)  # type: ignore[literal-required]
        return found[np.isfinite(found)]

    def quantiles(key: str) -> list[float]:
        found = values(key)
        return [float(q) for q in np.quantile(found, (0.005, 0.5, 0.995))] if len(found) else []

    felt, rms = values("felt_over_true"), values("force_rms_N")
    lowest = np.minimum(values("energy_mJ"), values("energy_ports_mJ") if mode == "passivity" else 0.0)
    return {
        "mode": mode,
        "runs": len(rows),
        "energy_lowest_mJ": float(values("energy_mJ").min()),
        "energy_ports_lowest_mJ": float(values("energy_ports_mJ").min()),
        "felt_over_true": quantiles("felt_over_true"),
        "force_rms_N": quantiles("force_rms_N"),
        "force_site_largest_N": float(values("force_site_N").max()),
        "kick_largest_N": float(values("kick_N").max()),
        "drift_largest_mm": float(values("drift_mm").max()),
        "not_passive": int((lowest < -0.5).sum()),
        "felt_outside": int(((felt < 0.95) | (felt > 1.05)).sum()),
        "rms_outside": int((rms > 0.03).sum()),
    }


def _delayed(round_trip: float) -> Network:
    condition = _network.Condition()
    condition.delay = 0.5 * round_trip
    condition.weights, condition.rates = [1.0], [1.0 / max(0.05 * round_trip, 1e-4)]
    condition.gilbert = burst_loss(0.2)
    return Network("delayed", condition, condition)


def moving(sweep: Sweeper, seed: int) -> list[Moving]:
    """An organ that breathes by a motion model, a lump that is pushed aside, and a table in the mode passivity."""
    grid = {"case": Axis(("breathing", "pushed", "passivity")), "round_trip": Axis(ROUND_TRIPS)}
    rows = sweep(_moving, grid, seed, title="moving").rows()
    return [{"case": str(r["case"]), "round_trip_ms": 1e3 * float(r["round_trip"]), "force_rms_N": r["force_rms_N"],
             "energy_mJ": r["energy_mJ"], "kick_N": r["kick_N"], "drift_mm": r["drift_mm"],
             "relearnt_s": None if math.isnan(r["relearnt_s"]) else r["relearnt_s"]} for r in rows]  # fmt: skip


def _moving(point: Point, seed: int) -> dict[str, float]:
    link = _delayed(point["round_trip"])
    if point["case"] == "breathing":
        r, _ = trial("model", link, World(breathing=BREATHING), Motion(presses=10), seed)
        return {**_of_moving(r), "relearnt_s": math.nan}
    if point["case"] == "passivity":
        r, _ = trial("passivity", link, World(), Motion(presses=4), seed)
        return {**_of_moving(r), "relearnt_s": math.nan}
    r, _ = pushed(link, seed)
    return {**_of_moving(r), "relearnt_s": r.relearnt if r.relearnt >= 0.0 else math.inf}


def _of_moving(r: _network.TrialResult) -> dict[str, float]:
    found = figures(r)
    return {"force_rms_N": found["force_rms_N"], "energy_mJ": found["energy_mJ"], "kick_N": found["kick_N"],
            "drift_mm": found["drift_mm"]}  # fmt: skip


def pushed(link: Network, seed: int) -> tuple[_network.TrialResult, Array]:
    """A lump that gives way by 5 mm in the middle of a long press."""
    world, motion = World("sphere", 400.0), Motion(presses=2, press=8.0, slide=0.0)
    o = options("model", motion.hand, link.round_trip, seed)
    o.to_site, o.to_operator = link.to_site, link.to_operator
    path = motion.path(world, link.round_trip)
    middle = 0.5 * (len(path) - 1) * 1e-3 + 0.5 * motion.press
    o.push(middle, 0, np.array([0.0, 0.0, -PUSH]))
    return _network.trial(o, world.snapshot(True), world.snapshot(False), path)


def alarms(names: Sequence[str], hours: float, sweep: Sweeper, seed: int) -> list[Alarm]:
    """False alarms of the detector of outages in hours of each network, and when it tells a true one."""
    grid = {"condition": Axis(names), "hours": Axis((hours,))}
    rows = sweep(_alarms, grid, seed, title="alarms").rows()
    for row in rows:
        row.pop("seed", None)
    return cast(list[Alarm], rows)


def _alarms(point: Point, seed: int) -> dict[str, float]:
    found = _network.count_alarms(network(point["condition"]).to_site, 3600.0 * point["hours"], SETTLE, seed)
    told = found.told - found.p999 if found.told >= 0.0 else math.inf
    return {
        "false_alarms_per_hour": found.false_alarms / point["hours"],
        "p999_ms": 1e3 * found.p999,
        "told_ms": 1e3 * told,
        "possible_ms": 1e3 * (found.possible - found.p999),
    }
