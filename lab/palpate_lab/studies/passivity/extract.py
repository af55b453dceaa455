"""``palpate study passivity --extract``: handle motions that try to take energy out of the layer.

The handle is moved, whatever the force: strokes into and out of the wall with the largest acceleration that the layer
assumes, forwards and then backwards, in the shortest time. The energy is exact: the motion is a polynomial between the
times at which the acceleration or the acting force changes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from rich.console import RenderableType
from rich.table import Table

from palpate import _core, _verify
from palpate.base.arrays import Array
from palpate.base.sweep import Axis
from palpate.base.sweep.grid import Point
from palpate_lab.studies._command import Sweeper
from palpate_lab.studies.passivity.result import Extracted, ExtractedBy
from palpate_lab.studies.passivity.work import log_uniform

MOTIONS = 100  # motions of each case
SECONDS = 3.0  # duration of a motion [s]
STIFFNESS = (200.0, 5000.0)  # range of the wall's stiffness, log-uniform [N/m]
REACH = (-0.006, 0.012)  # range of the positions at which a stroke ends [m]; the wall is at x > 0
PERIOD = 1e-3  # period of the cycle [s]


@dataclass(frozen=True)
class Setting:
    """What the layer does not see exactly. It knows the delay with half of the jitter, and the size of a count."""

    delay: float = 0.0
    """Delay from the measurement to the force [s]."""
    jitter: float = 0.0
    """Additional delay of each cycle, uniform from 0 to this value; forces keep their order [s]."""
    quantum: float = 0.0
    """Encoder count [m]; 0: exact positions."""
    differenced: bool = False
    """True: the velocity is the difference of two counts over the period. False: it is exact."""


CASES: dict[str, Setting] = {
    "no delay": Setting(),
    "delay of 5 ms": Setting(0.005),
    "delay of 20 ms": Setting(0.020),
    "delay of 3.37 ms": Setting(0.00337),
    "delay of 4 ms, counts of 20 um": Setting(0.004, quantum=20e-6),
    "counts of 50 um, velocity as their difference": Setting(quantum=50e-6, differenced=True),
    "delay of 4 ms, jitter of 2 ms": Setting(0.004, 0.002),
    "delay of 4 ms, jitter of 10 ms": Setting(0.004, 0.010),
}
"""The settings of the page docs/stability-study.md."""


@dataclass(frozen=True)
class Strokes:
    """A motion with piecewise constant acceleration: values at the beginning of each piece."""

    t: Array
    x: Array
    v: Array
    a: Array

    def at(self, t: Array) -> tuple[Array, Array]:
        """Position [m] and velocity [m/s] at the times t (n,) [s]."""
        k = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, None)
        s = t - self.t[k]
        return self.x[k] + self.v[k] * s + 0.5 * self.a[k] * s**2, self.v[k] + self.a[k] * s


def strokes(rng: np.random.Generator, acceleration: float) -> Strokes:
    """Strokes between random positions, each with the acceleration in its first half and against it in its second."""
    t, x, rows = 0.0, 0.0, []
    while t < SECONDS:
        goal = rng.uniform(*REACH)
        way, a = goal - x, acceleration * np.sign(goal - x)
        half = float(np.sqrt(abs(way) / acceleration))
        rows += [(t, x, 0.0, a), (t + half, x + 0.5 * way, a * half, -a)]
        t, x = t + 2.0 * half, goal
    return Strokes(*np.array(rows).T)


def extracted(setting: Setting, seed: int, mode: str = "observer") -> float:
    """Largest energy that the handle has taken out at any moment of one motion [J]."""
    rng, o = np.random.default_rng(seed), _core.StabilityOptions()
    o.passivity = mode  # type: ignore[assignment]
    o.delay, o.quantum = setting.delay + 0.5 * setting.jitter, setting.quantum
    K, motion = log_uniform(rng, *STIFFNESS), strokes(rng, o.acceleration)
    sent = np.linspace(0.0, SECONDS, round(SECONDS / PERIOD), endpoint=False)
    acts = np.maximum.accumulate(sent + setting.delay + setting.jitter * rng.uniform(size=len(sent)))
    return largest_return(motion, acts, rendered(motion, sent, o, K, setting))


def rendered(motion: Strokes, t: Array, o: _core.StabilityOptions, K: float, setting: Setting) -> Array:
    """Force (n,) on the hand that the layer lets pass at each cycle [N]."""
    x, v = motion.at(t)
    if setting.quantum > 0.0:
        x = setting.quantum * np.round(x / setting.quantum)
    if setting.differenced:
        v = np.diff(x, prepend=x[0]) / PERIOD
    stage, F = _verify.Stability(o, PERIOD), np.zeros(len(t))
    for k, (position, velocity) in enumerate(zip(x, v, strict=True)):
        wall = [-K * max(position, 0.0), 0.0, 0.0]
        out = stage.step(wall, np.array([position, 0.0, 0.0]), np.array([velocity, 0.0, 0.0]))
        stage.rendered(out.F_H_L)
        F[k] = out.F_H_L[0]
    return F


def largest_return(motion: Strokes, acts: Array, F: Array) -> float:
    """Largest energy returned since the start [J], of forces F (n,) that act from the times ``acts`` (n,) on.

    Between two times at which the force or the direction of the motion changes the energy is monotonous.
    """
    turns = motion.t[(motion.t > acts[0]) & (motion.t < acts[-1])]
    t = np.sort(np.concatenate([acts, turns]))
    acting = F[np.searchsorted(acts, t[:-1], side="right") - 1]
    returned = np.cumsum(acting * np.diff(motion.at(t)[0]))
    return float(max(returned.max(initial=0.0), 0.0))


def _case(point: Point, seed: int) -> dict[str, float]:
    """The energy of one motion in one case, with the layer and without it."""
    setting = CASES[point["case"]]
    return {"extracted_J": extracted(setting, seed), "without_J": extracted(setting, seed, "off")}


def extract(motions: int, seed: int, sweep: Sweeper) -> ExtractedBy:
    """The largest energy of every case; the keys are those of docs/json.md."""
    rows = sweep(_case, {"case": Axis(CASES), "motion": Axis(range(motions))}, seed, title="extract").rows()
    extract: list[Extracted] = []
    for case in CASES:
        mine = [row for row in rows if row["case"] == case]
        extract.append({"case": case, "extracted_J": max(row["extracted_J"] for row in mine),
                        "without_J": max(row["without_J"] for row in mine)})  # fmt: skip
    return {"simulated": True, "seed": seed, "motions": motions, "extract": extract}


def table(found: ExtractedBy) -> list[RenderableType]:
    """The cases as a table for a terminal."""
    out = Table(box=None, pad_edge=False, title_justify="left",
                title=f"largest energy taken out by {found['motions']} motions per case")  # fmt: skip
    for column in ("case", "with the layer", "without"):
        out.add_column(column, justify="left" if column == "case" else "right")
    for row in found["extract"]:
        out.add_row(row["case"], *(f"{1e3 * row[key]:.3g} mJ" for key in ("extracted_J", "without_J")))
    return [out, "simulated motions of the handle, one axis"]
