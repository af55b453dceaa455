"""The paper's virtual wall on the whole simulation: hand, MTM, drives with their delay, haptic cycle.

The paper counts y from the master's base towards the handle; the base frame of the da Vinci, in which the scene is
written, has its y axis the other way: the wall y = 0.385 m of the paper is y = -0.385 m there.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, fields, replace
from functools import cache
from pathlib import Path
from typing import Self

import numpy as np

from palpate import _core
from palpate.arrays import Array
from palpate.record.ticks import as_ticks
from palpate.scene import Scene
from palpate.scene.rig import Rig, build

WALL = 0.385  # from the master's base, along y; overshoot is read against it [m]
KP = 400.0  # [N/m]
SECONDS = 4.0
END = 0.6  # of a run that is judged for rest [s]
SETTLED = 0.05  # share of the peak penetration
OSCILLATES = 5e-4  # swing at the end, peak to peak [m]
_START = 0.2  # the hand begins to move [s]
_HERE = Path(__file__).resolve().parents[2]


def scene_file() -> Path:
    """``scenes/wall.yaml``, beside the installed package or in the repository."""
    return next(p for p in (_HERE / "scenes" / "wall.yaml", _HERE.parent / "scenes" / "wall.yaml") if p.is_file())


@dataclass(frozen=True)
class Press:
    """A hand, what it does, and how late the arm answers."""

    mass_kg: float
    damping_N_s_per_m: float
    stiffness_N_per_m: float
    push_N: float
    """On a wall of infinite stiffness, at rest."""
    approach_s: float
    """Duration of the hand's intended way, from 20.5 mm before the wall (minimum jerk)."""
    delay_s: float
    """From the computed force to the torque; sampling and the tool's way come on top of it."""

    @classmethod
    @cache
    def fitted(cls) -> Self:
        """As the scene says."""
        scene = Scene.load(scene_file())
        o, path = scene.operator, scene.operator.path or ()
        push = o.stiffness * (-path[-1].xyz[1] - WALL)
        return cls(o.mass, o.damping, o.stiffness, push, path[-1].t - path[0].t, scene.loop_delay)

    def scaled(self, **factors: float) -> Self:
        """With some values multiplied."""
        return replace(self, **{name: getattr(self, name) * factor for name, factor in factors.items()})

    def of_another(self, person: int) -> Self:
        """Another person's hand, by number: mass, damping, stiffness, push and speed log-normal, 95 % within 2."""
        rng = np.random.default_rng([2016, person])
        own = [field.name for field in fields(self) if field.name != "delay_s"]
        scale = np.exp(rng.normal(0.0, np.log(2.0) / 1.96, len(own)))
        return self.scaled(**dict(zip(own, scale.tolist(), strict=True)))


@dataclass(frozen=True)
class Setting:
    """The wall, and how it is rendered."""

    kd: float
    """K_d [N s/m]."""
    kp: float = KP
    rate: float = 500.0
    """Of the haptic cycle [Hz]."""
    passivity: str = "off"
    """As in a scene: `stability.passivity`."""
    coulomb_scale: float = 1.0
    """Of the arm's dry friction."""


@dataclass(frozen=True)
class Trace:
    """What happened."""

    t: Array
    """(n,) [s]."""
    y: Array
    """(n,) the handle, along the paper's y [m]."""
    F_cell: Array
    """(n,) of the arm on the hand, out of the wall [N]."""
    energy: Array
    """(n,) taken from the hand by the rendered force; below zero it was generated [J]."""


@dataclass(frozen=True)
class Outcome:
    """A row of Table 1, measured."""

    overshoot_percent: float
    """Largest penetration over 0.385 m."""
    settling_s: float | None
    """From the touch until within 5 % of the peak penetration around the rest; None when it never rests."""
    steady_state_m: float
    """Depth at rest; half the swing when it never rests."""
    limit_cycle: bool
    swing_m: float
    """Peak to peak in the last 0.6 s."""
    energy_J: float
    """At the end; below zero the wall has made energy."""
    rigidity_N_per_m: float | None
    """As felt: the load cell's force at rest over the depth there; None when it never rests."""
    rebound: float
    """Speed out of the wall over the speed into it, of the first bounce: 1 is a spring, 0 a sponge."""


@cache
def _rig(setting: Setting) -> Rig:
    scene = Scene.load(scene_file())
    wall = scene.objects[0].model_copy(update={"stiffness": (setting.kp,) * 3, "damping": (setting.kd,) * 3})
    stability = scene.stability.model_copy(update={"passivity": setting.passivity})
    rates = scene.rates.model_copy(update={"haptic": setting.rate})
    leader = scene.arms.leader.model_copy(update={"coulomb_scale": setting.coulomb_scale})
    arms = scene.arms.model_copy(update={"leader": leader})
    changed = {"objects": (wall,), "stability": stability, "rates": rates, "arms": arms}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that it may oscillate is what the study shows
        return build(scene.model_copy(update=changed))


def press(setting: Setting, hand: Press, seconds: float = SECONDS) -> Trace:
    """The hand moves the handle into the wall and pushes on."""
    rig = _rig(setting)
    o = rig.options()
    held = o.hand
    held.mass, held.damping, held.stiffness = hand.mass_kg, hand.damping_N_s_per_m, hand.stiffness_N_per_m
    o.hand, o.loop_delay = held, hand.delay_s
    start = rig.path.positions_W[0]
    end = start.copy()
    end[1] = -WALL - hand.push_N / hand.stiffness_N_per_m
    path = _core.HandPath([_START, _START + hand.approach_s], np.stack([start, end]))
    arms = rig.arms
    simulation = _core.Simulation(o, arms.leader, arms.leader, arms.follower, rig.snapshot, path)
    ticks = as_ticks(simulation.run(round(seconds * setting.rate)))
    return Trace(ticks["t"], -ticks["p_LH"][:, 1], ticks["F_cell_L"][:, 1], ticks["energy_port"])


def judge(trace: Trace) -> Outcome:
    """The row of Table 1 that a run makes."""
    t, depth = trace.t, trace.y - WALL
    inside, last = np.flatnonzero(depth > 0.0), t > t[-1] - END
    swing, rest, peak = float(np.ptp(depth[last])), float(depth[last].mean()), float(depth.max())
    oscillates = swing > OSCILLATES
    away = np.flatnonzero(np.abs(depth - rest) > SETTLED * peak)
    rests = not oscillates and len(inside) > 0 and rest > 0.0
    settled = t[min(int(away[-1]) + 1, len(t) - 1)] - t[inside[0]] if rests and len(away) else 0.0
    return Outcome(
        overshoot_percent=100.0 * max(peak, 0.0) / WALL,
        settling_s=float(settled) if rests else None,
        steady_state_m=rest if rests else 0.5 * swing,
        limit_cycle=oscillates,
        swing_m=swing,
        energy_J=float(trace.energy[-1]),
        rigidity_N_per_m=float(trace.F_cell[last].mean()) / rest if rests else None,
        rebound=_rebound(trace, int(inside[0])) if len(inside) else 0.0,
    )


def _rebound(trace: Trace, touch: int) -> float:
    v = np.gradient(trace.y, trace.t)
    turns = touch + np.flatnonzero(np.diff(np.sign(v[touch:])) != 0)
    if len(turns) < 2:
        return 0.0
    return float(-v[turns[0] : turns[1] + 2].min() / v[touch])
