"""The paper's virtual wall in the full simulation: hand, MTM, drives with delay, and haptic cycle.

The paper measures y from the master's base towards the handle. The scene uses the base frame of the da Vinci, whose y
axis has the opposite direction: the paper's wall at y = 0.385 m is at y = -0.385 m in the scene.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, fields, replace
from functools import cache
from typing import Self, TypedDict

import numpy as np

from palpate import _core, _verify
from palpate.base.arrays import Array
from palpate.record.ticks import as_ticks
from palpate.scene import Scene, shipped
from palpate.scene.rig import Rig, build

WALL = 0.385  # distance of the wall from the master's base along y, reference of the overshoot [m]
KP = 400.0  # stiffness of the wall [N/m]
SECONDS = 4.0  # duration of a run [s]
END = 0.6  # final interval that is tested for rest [s]
SETTLED = 0.05  # settling band relative to the peak penetration [-]
OSCILLATES = 5e-4  # smallest final peak-to-peak amplitude of an oscillation [m]
LONGER = 12.0  # further simulation of a run that still moves, to judge whether it oscillates or decays [s]
ARM = 0.55  # mass of the arm at the handle along y [kg]
_START = 0.2  # start of the hand's motion [s]


@dataclass(frozen=True)
class WallPress:
    """A hand, its motion, and the delay of the loop."""

    mass_kg: float
    damping_N_s_per_m: float
    stiffness_N_per_m: float
    push_N: float
    """Static force on an infinitely stiff wall."""
    approach_s: float
    """Duration of the hand's intended motion, which starts 20.5 mm before the wall (minimum jerk)."""
    delay_s: float
    """Delay from the computed force to the torque; sampling and the follower add to this delay."""

    @classmethod
    @cache
    def fitted(cls) -> Self:
        """The hand and the delay of the shipped scene."""
        scene = Scene.load(shipped.file("wall"))
        o, path = scene.operator, scene.operator.path or ()
        push = o.stiffness * (-path[-1].xyz[1] - WALL)
        return cls(o.mass, o.damping, o.stiffness, push, path[-1].t - path[0].t, scene.loop_delay)

    def scaled(self, **factors: float) -> Self:
        """A copy with some values multiplied by factors."""
        return replace(self, **{name: getattr(self, name) * factor for name, factor in factors.items()})

    def of_another(self, person: int) -> Self:
        """Another person's hand, by number: mass, damping, stiffness, push and speed log-normal, 95 % within 2."""
        rng = np.random.default_rng([2016, person])
        own = [field.name for field in fields(self) if field.name != "delay_s"]
        scale = np.exp(rng.normal(0.0, np.log(2.0) / 1.96, len(own)))
        return self.scaled(**dict(zip(own, scale.tolist(), strict=True)))


@dataclass(frozen=True)
class Setting:
    """The wall and the options of its rendering."""

    kd: float
    """Damping K_d of the wall [N s/m]."""
    kp: float = KP
    rate: float = 500.0
    """Rate of the haptic cycle [Hz]."""
    passivity: str = "off"
    """Value of `stability.passivity` in the scene."""
    coulomb_scale: float = 1.0
    """Scale of the arm's dry friction [-]."""
    velocity_cutoff: float | None = None
    """Cutoff of the low-pass of the arm's velocity, 0: none [Hz]; None: as in the scene."""


@dataclass(frozen=True)
class Trace:
    """Signals of a run."""

    t: Array
    """Time (n,) [s]."""
    y: Array
    """Position of the handle along the paper's y (n,) [m]."""
    F_cell: Array
    """Force of the arm on the hand, positive out of the wall (n,) [N]."""
    energy: Array
    """Energy that the rendered force has taken from the hand, negative if generated (n,) [J]."""
    swing: str = "undecided"
    """Verdict of `palpate._verify.judge_swing` on a longer run, if the handle still moves at the end of this one."""


class Outcome(TypedDict):
    """Measured values of a row of Table 1."""

    overshoot_percent: float
    """Largest penetration over 0.385 m."""
    settling_s: float | None
    """Time from contact until the depth stays within 5 % of the peak around its final value; None without rest."""
    steady_state_m: float
    """Depth at rest; half the final peak-to-peak amplitude without rest."""
    limit_cycle: bool
    swing_m: float
    """Peak-to-peak amplitude in the last 0.6 s."""
    energy_J: float
    """Energy taken from the hand until the end; negative if the wall has generated energy."""
    rigidity_N_per_m: float | None
    """Load cell's force over depth, both at rest; None without rest."""
    rebound: float
    """Ratio of exit speed to entry speed of the first bounce: 1 for a spring, 0 for a sponge [-]."""


@cache
def _rig(setting: Setting) -> Rig:
    scene = Scene.load(shipped.file("wall"))
    wall = scene.objects[0].model_copy(update={"stiffness": (setting.kp,) * 3, "damping": (setting.kd,) * 3})
    stability = scene.stability.model_copy(update={"passivity": setting.passivity})
    rates = scene.rates.model_copy(update={"haptic": setting.rate})
    imperfections: dict[str, float] = {"coulomb_scale": setting.coulomb_scale}
    if setting.velocity_cutoff is not None:
        imperfections["velocity_cutoff"] = setting.velocity_cutoff
    leader = scene.arms.leader.model_copy(update=imperfections)
    arms = scene.arms.model_copy(update={"leader": leader})
    changed = {"objects": (wall,), "stability": stability, "rates": rates, "arms": arms}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the warning about oscillation is expected here
        return build(scene.model_copy(update=changed))


def press(setting: Setting, hand: WallPress, seconds: float = SECONDS, *, follow: bool = True) -> Trace:
    """Simulate a hand that moves the handle into the wall and continues to push.

    follow: a handle that still moves at the end is followed for `LONGER`, to judge whether it oscillates.
    """
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
    trace = Trace(ticks["t"], -ticks["p_LH"][:, 1], ticks["F_cell_L"][:, 1], ticks["energy_port"])
    if not follow or swing(trace) <= OSCILLATES:
        return trace
    more = as_ticks(simulation.run(round(LONGER * setting.rate)))
    y = np.concatenate([trace.y, -more["p_LH"][:, 1]])[round((_START + hand.approach_s) * setting.rate) :]
    slowest = 2.0 * np.pi * np.sqrt((ARM + hand.mass_kg) / hand.stiffness_N_per_m)  # out of the wall
    return replace(trace, swing=_verify.judge_swing(y.tolist(), 1.0 / setting.rate, slowest, 0.5 * OSCILLATES).swing)


def swing(trace: Trace) -> float:
    """Peak-to-peak motion of the handle in the last `END` of a run [m]."""
    return float(np.ptp(trace.y[trace.t > trace.t[-1] - END]))


def judge(trace: Trace) -> Outcome:
    """Compute the row of Table 1 from a run."""
    t, depth = trace.t, trace.y - WALL
    inside, last = np.flatnonzero(depth > 0.0), t > t[-1] - END
    moves, rest, peak = swing(trace), float(depth[last].mean()), float(depth.max())
    away = np.flatnonzero(np.abs(depth - rest) > SETTLED * peak)
    rests = moves <= OSCILLATES and len(inside) > 0 and rest > 0.0
    settled = t[min(int(away[-1]) + 1, len(t) - 1)] - t[inside[0]] if rests and len(away) else 0.0
    return Outcome(
        overshoot_percent=100.0 * max(peak, 0.0) / WALL,
        settling_s=float(settled) if rests else None,
        steady_state_m=rest if rests else 0.5 * moves,
        limit_cycle=moves > OSCILLATES and trace.swing not in ("rests", "decays"),
        swing_m=moves,
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
