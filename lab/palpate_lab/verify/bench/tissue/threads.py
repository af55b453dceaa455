"""Bodies on a thread of their own: force and energy beside the same body in the cycle, and missed ticks."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TypedDict

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.record.ticks import as_ticks
from palpate.scene import Scene, rig
from palpate.scene.contact import render
from palpate.world.tissue import Tissue
from palpate.world.tissue.blocks import block
from palpate_lab.verify.bench.tissue.bodies import TICK, Lab
from palpate_lab.verify.bench.tissue.rows import Found, at_least, at_most
from palpate_lab.verify.bench.tissue.ticks import SIZES

RADIUS, DEPTH = 5e-3, 3e-3  # of the sphere, of its press [m]
PERIOD = 10e-3  # of the thread [s]
SLOWER = (20e-3, 50e-3)  # periods of threads that are told beside it, for the stiffest body [s]
YOUNG = (5e3, 20e3, 60e3)  # [Pa]
RATES = (1.0, 2.0, 4.0, 8.0)  # of the oscillation that is to take energy [Hz]
PRONY = ((0.3, 0.02), (0.2, 0.2), (0.1, 2.0))
LATE = 1 << 33  # bit soft_late of the status


class Apart(TypedDict):
    """A body on a thread beside the same body in the cycle."""

    young: float  #: [Pa]
    period: float  #: of the thread [s]
    rms: float  #: difference of the forces over the force in the cycle, both root mean squares [-]
    peak: float  #: largest difference over the largest force [-]
    taken: float  #: least energy that the tool has put in at any time while it oscillates; below 0: it was given [J]
    taken_in_cycle: float  #: the same in the cycle [J]


class RealTime(TypedDict):
    """A loop in real time with a soft body, and a bare loop in turns with it."""

    tets: int
    period: float  #: of the body's thread; 0: it steps in the cycle [s]
    ticks: int
    contact: int  #: ticks in contact
    missed: int  #: ticks of the loop
    control_missed: int  #: ticks of the bare loop
    late: int  #: ticks in which the shape of the body was late
    cycle_p50_us: float
    cycle_p99_us: float


def slab(young: float, thread: str, period: float = PERIOD, **material: object) -> Tissue:
    """A slab of 60 x 60 x 30 mm, fixed at its ground, with its top at z = 0."""
    nodes, tets = block((6, 6, 3), (0.06, 0.06, 0.03))
    nodes = nodes - [0.03, 0.03, 0.03]
    values = {"young": young, "fixed": nodes[:, 2] < -0.0299, "thread": thread, "period": period}
    return Tissue((nodes, tets), **{**values, **material})  # type: ignore[arg-type]


def palpation() -> Array:
    """A press within 0.4 s, a hold, a slide with 20 mm/s, and the way back: positions (n, 3) of the sphere [m]."""

    def ease(seconds: float) -> Array:
        s = np.linspace(0.0, 1.0, round(seconds / TICK))
        return s * s * (3.0 - 2.0 * s)

    down, hold, slide = ease(0.4), round(0.2 / TICK), ease(0.5)
    depth = np.concatenate([down, np.ones(hold + len(slide) + hold), 1.0 - down])
    x = np.concatenate([np.zeros(len(down) + hold), slide, np.ones(hold + len(down))]) * 0.01
    return np.stack([x, np.zeros_like(x), RADIUS + 5e-4 - (DEPTH + 5e-4) * depth], axis=1)


def oscillation(rate: float, seconds: float = 1.5) -> Array:
    """A sphere that presses 1 to 5 mm deep and slides, at a rate [Hz]: positions (n, 3) [m]."""
    w = 2.0 * np.pi * rate * np.arange(round(seconds / TICK)) * TICK
    depth = np.minimum(w / np.pi, 1.0) * (3e-3 - 2e-3 * np.cos(w))
    z = RADIUS + 2e-3 - depth - 2e-3 * np.minimum(w, 1.0)
    return np.stack([3e-3 * np.sin(0.7 * w), 2e-3 * np.sin(0.4 * w), z], axis=1)


def taken(force: Array, tips: Array) -> float:
    """Least energy that the tool has put into a surface at any time [J]. force, tips (n, 3) [N, m]."""
    work = -(0.5 * (force[1:] + force[:-1]) * np.diff(tips, axis=0)).sum(axis=1)
    return float(min(0.0, np.cumsum(work).min()))


def apart(young: float, period: float = PERIOD, rates: Sequence[float] = RATES) -> Apart:
    """Compare a body on a thread with the same body in the cycle, without viscosity, which would hide energy."""
    own, cycle = (slab(young, thread, period) for thread in ("own", "cycle"))
    tips = palpation()
    felt, true = (render(soft, tips, radius=RADIUS).force for soft in (own, cycle))
    error = np.linalg.norm(felt - true, axis=1)
    paths = [oscillation(rate) for rate in rates]
    given = [[taken(render(soft, path, radius=RADIUS).force, path) for path in paths] for soft in (own, cycle)]
    return {
        "young": young,
        "period": period,
        "rms": float(np.sqrt((error**2).mean() / (true**2).sum(axis=1).mean())),
        "peak": float(error.max() / np.linalg.norm(true, axis=1).max()),
        "taken": min(given[0]),
        "taken_in_cycle": min(given[1]),
    }


def real_time(cells: tuple[int, int, int], thread: str, seconds: float = 8.0, turns: int = 4) -> RealTime:
    """Run a press on a block with cells of 10 mm in real time, in turns with a bare loop. seconds: of each."""
    size = np.array(cells) * 0.01
    setup = rig.build(Scene.model_validate({"objects": [{"box": {"size": size.tolist()}, "stiffness": 60.0}]}))
    nodes, tets = block(cells, size)
    fixed = nodes[:, 2] == 0.0
    soft = Tissue((nodes - size / 2, tets), young=5e3, prony=PRONY, yeoh=0.5, fixed=fixed, thread=thread)
    (rigid,) = setup.snapshot.objects
    place = _core.Object(rigid.name, soft.core, rigid.X_WO, _core.Material(K=np.zeros(3)))
    loop, control = setup.simulation(), _core.BareLoop(1000.0)
    loop.set_snapshot(_core.Snapshot([place]))
    rows = []
    for _ in range(turns):
        for each in (control, loop):
            each.start()
            end = time.monotonic() + seconds / turns
            while time.monotonic() < end:
                time.sleep(0.1)
                rows.append(loop.drain())
            each.stop()
    ticks, timing = as_ticks(np.concatenate(rows)), loop.timing()
    return {
        "tets": len(tets),
        "period": soft.period,
        "ticks": len(ticks),
        "contact": int((ticks["contacts"] > 0).sum()),
        "missed": timing["missed_ticks"],
        "control_missed": control.timing()["missed_ticks"],
        "late": int((ticks["status"] & LATE != 0).sum()),
        "cycle_p50_us": timing["cycle_us"]["p50"],
        "cycle_p99_us": timing["cycle_us"]["p99"],
    }


def measure(lab: Lab, short: bool = False) -> Found:
    """Bodies on a thread beside the same in the cycle, for each modulus; slower threads for the stiffest one."""
    del lab  # each body is made twice, with a thread and without
    table = [apart(young, rates=RATES[-1:] if short else RATES) for young in (YOUNG[1:2] if short else YOUNG)]
    slower = [apart(YOUNG[-1], period, RATES[-1:]) for period in (SLOWER[-1:] if short else SLOWER)]
    on = f"on a thread of {1e3 * PERIOD:g} ms"
    rows = (
        at_most(f"force {on}, rms difference", 100 * max(row["rms"] for row in table), 1.5),
        at_most(f"force {on}, largest difference", 100 * max(row["peak"] for row in table), 10.0),
        at_least(f"energy {on}, least balance", 1e3 * min(row["taken"] for row in table), -0.5, "mJ"),
    )
    return Found(rows, {"threads": [*table, *slower]})


def measure_real_time(lab: Lab, short: bool = False) -> Found:
    """Ticks that loops in real time miss, with a body in the cycle and on a thread, beside a bare loop in turns."""
    del lab  # the loop makes its own body
    seconds = 0.4 if short else 8.0
    bodies = [("1k", "own")] if short else [("7k", "cycle"), ("18k", "own")]
    return Found((), {"real_time": [real_time(SIZES[size], thread, seconds) for size, thread in bodies]})
