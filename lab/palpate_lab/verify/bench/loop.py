"""`palpate bench loop`: computing time and timing accuracy of the haptic cycle.

The benchmark answers four questions in one session. How long does a cycle take (state in, torque out) while the hand
palpates an organ, in all and per stage, next to Pinocchio's `computeAllTerms` of the same two arms? How many times
faster than real time is the lockstep simulation? How late does a real-time loop start its ticks? How many ticks do
several arms miss when they share the machine? The last two alternate with bare loops that only keep time with the same
privileges, so that both see the same load.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Protocol, TypedDict

import numpy as np

from palpate import _core, _reference
from palpate.record.ticks import TICK, Ticks, Timing
from palpate.scene import Scene, rig
from palpate.scene.together import capsules, join_instruments
from palpate_lab import places

Progress = Callable[[str], None]

_TURNS = 4  # of loop and control per rate
_CHUNK = 250  # lockstep ticks between two runs of their control
_FAST = 10000.0  # rate of the single fast arm that follows several slower ones [Hz]
_STIFFNESS = 400.0  # of the organ [N/m]


class _Timed(Protocol):
    def start(self) -> None: ...
    def stop(self) -> None: ...
    def timing(self) -> Timing: ...


class StageTime(TypedDict):
    """Computing time of one stage of the cycle."""

    p50_us: float
    p99_us: float


class Lockstep(TypedDict):
    """Figures of the lockstep run."""

    triangles: int
    cycle_p50_us: float
    cycle_p99_us: float
    cycle_p999_us: float
    cycle_max_us: float
    control_us: dict[str, float]
    stages: dict[str, StageTime]
    realtime_factor: float
    plant_rate_hz: float
    contact_share: float


class RealTime(TypedDict):
    """Figures of a real-time loop and of the bare loop that alternates with it."""

    rate_hz: float
    seconds: float
    missed_ticks: int
    lateness_p50_us: float
    lateness_p99_us: float
    lateness_p999_us: float
    control_missed_ticks: int
    control_lateness_p50_us: float
    control_lateness_p99_us: float
    control_lateness_p999_us: float
    cycle_p50_us: float
    cycle_p99_us: float
    stages: dict[str, StageTime]
    slack_p01_us: float
    scheduler: str


class OneArm(TypedDict):
    """Figures of one of several arms that share the machine."""

    arm: int
    rate_hz: float
    seconds: float
    missed: int
    control_missed: int
    lateness_p99_us: float
    control_lateness_p99_us: float
    cycle_p50_us: float
    cycle_p99_us: float


class Result(Lockstep):
    """Result of the benchmark. The keys are the documented contract of ``--json``.

    Keys outside of `realtime` and `arms` are figures of lockstep and of real time at 1 kHz.
    """

    surface: str
    rate_hz: float
    missed_ticks: int
    lateness_p99_us: float
    control_missed_ticks: int
    control_lateness_p99_us: float
    realtime: list[RealTime]
    arms: list[OneArm]


def default_mesh() -> Path | None:
    """The liver of the test data (`PALPATE_DATA`, or `../shared/data` next to the repository); None when absent."""
    liver = places.data() / "meshes" / "Liver.stl"
    return liver if liver.is_file() else None


def run(
    seconds: float = 60.0,
    *,
    mesh: Path | None = None,
    rates: Iterable[float] = (1000.0, 4000.0),
    lockstep_seconds: float = 20.0,
    arms: int = 0,
    on_progress: Progress = lambda _: None,
) -> Result:
    """Measure; takes 2 * seconds per rate, as long for several arms and for the fast one, and a moment for lockstep.

    Args:
        seconds: real time measured per rate, for loop and control each [s].
        mesh: STL file in millimetres to palpate; default: the liver of the test data, or the shipped organ.
        rates: rates of the haptic cycle in real-time mode, at least one [Hz].
        lockstep_seconds: simulated time of the lockstep run [s].
        arms: simulations that run in real time at 1 kHz at once, and then one at 10 kHz; 0 leaves both out.
        on_progress: called with a description before each measurement.
    """
    mesh = mesh or default_mesh()
    surface = mesh.name if mesh else "shipped organ"
    on_progress(f"lockstep at 1000 Hz on {surface}, {lockstep_seconds:g} s simulated")
    lockstep = _lockstep(_setup(mesh, 1000.0), lockstep_seconds)
    rows = []
    for rate in rates:
        on_progress(f"real time at {rate:g} Hz, {seconds:g} s, and as long a bare loop, in turns")
        rows.append(_real_time(_setup(mesh, rate).simulation(), rate, seconds))
    several: list[OneArm] = []
    for count, rate in ((arms, 1000.0), (1, _FAST)) if arms > 0 else ():
        on_progress(f"{count} at {rate:g} Hz in real time, {seconds:g} s, and as many bare loops, in turns")
        several += _several(_setup(mesh, rate), count, rate, seconds)
    first = next((row for row in rows if row["rate_hz"] == 1000.0), rows[0])
    return {
        "surface": surface,
        "rate_hz": 1000.0,
        **lockstep,
        "missed_ticks": first["missed_ticks"],
        "lateness_p99_us": first["lateness_p99_us"],
        "control_missed_ticks": first["control_missed_ticks"],
        "control_lateness_p99_us": first["control_lateness_p99_us"],
        "realtime": rows,
        "arms": several,
    }


def table(result: Result) -> str:
    """The result as text, one line per figure, units named."""
    lines = [
        f"haptic cycle on {result['surface']} ({result['triangles']} triangles), 1000 Hz, lockstep",
        f"  compute time  p50 {result['cycle_p50_us']:.2f} us   p99 {result['cycle_p99_us']:.2f} us   "
        f"p99.9 {result['cycle_p999_us']:.2f} us   max {result['cycle_max_us']:.1f} us",
        f"  control       p50 {result['control_us']['p50']:.2f} us   p99 {result['control_us']['p99']:.2f} us   "
        "Pinocchio's computeAllTerms of both arms",
        f"  simulation    {result['realtime_factor']:.1f} x real time, plant at {result['plant_rate_hz']:g} Hz, "
        f"in contact {100 * result['contact_share']:.0f} % of the time",
        "",
        "real time              missed    lateness p50 / p99 / p99.9 us       cycle p50 / p99 us",
    ]
    rows = result["realtime"]
    for row in rows:
        lines += [
            f"  {row['rate_hz']:5g} Hz loop      {row['missed_ticks']:8d}    {row['lateness_p50_us']:8.2f} / "
            f"{row['lateness_p99_us']:7.2f} / {row['lateness_p999_us']:8.2f}     "
            f"{row['cycle_p50_us']:6.2f} / {row['cycle_p99_us']:.2f}",
            f"  {row['rate_hz']:5g} Hz control   {row['control_missed_ticks']:8d}    "
            f"{row['control_lateness_p50_us']:8.2f} / {row['control_lateness_p99_us']:7.2f} / "
            f"{row['control_lateness_p999_us']:8.2f}",
        ]
    lines += [f"  scheduler: {row['scheduler']}" for row in result["realtime"][:1]]
    lines += ["", "stage             lockstep p50 / p99 us" + "".join(f"   {row['rate_hz']:5g} Hz" for row in rows)]
    for name in result["stages"]:
        places = (result["stages"], *(row["stages"] for row in rows))
        times = (f"{place[name]['p50_us']:7.2f} / {place[name]['p99_us']:6.2f}" for place in places)
        lines += [f"  {name:16s}" + "   ".join(times)]
    if result["arms"]:
        lines += ["", "arms at once     rate    missed   by a bare loop   cycle p50 / p99 us"]
    for arm in result["arms"]:
        lines += [
            f"  arm {arm['arm']}       {arm['rate_hz']:7g} {arm['missed']:9d} {arm['control_missed']:16d}   "
            f"{arm['cycle_p50_us']:9.2f} / {arm['cycle_p99_us']:.2f}"
        ]
    return "\n".join(lines)


def _setup(mesh: Path | None, rate: float) -> rig.Rig:
    organ = {"mesh": str(mesh), "unit": "mm"} if mesh else {"shape": "organ"}
    objects = [{**organ, "stiffness": _STIFFNESS}]
    return rig.build(Scene.model_validate({"objects": objects, "rates": {"haptic": rate}}))


def _lockstep(setup: rig.Rig, seconds: float) -> Lockstep:
    """The control runs at the joints of the ticks before it, every quarter of a simulated second."""
    simulation, timed = setup.simulation(), setup.simulation()
    timed.watch_stages()
    leader, follower = (_reference.AllTerms(arm.urdf, *arm.frames) for arm in (setup.arms.leader, setup.arms.follower))
    control = _reference.BareDynamics(leader, follower)
    spent, touching = 0.0, 0
    chunks = max(1, round(seconds * 1000.0 / _CHUNK))
    for _ in range(chunks):
        begin = time.perf_counter()
        rows = simulation.run(_CHUNK)
        spent += time.perf_counter() - begin
        ticks: Ticks = rows.view(TICK)[:, 0]
        n, m = setup.arms.leader.n, setup.arms.follower.n
        control.run(ticks["q"][:, :n].T, ticks["v"][:, :n].T, ticks["q_follower"][:, :m].T)
        touching += int(np.count_nonzero(ticks["contacts"]))
        timed.run(_CHUNK)
    cycle, control_us = simulation.timing()["cycle_us"], control.timing()
    return {
        "triangles": sum(len(s.body.triangles) for s in setup.surfaces),
        "cycle_p50_us": cycle["p50"],
        "cycle_p99_us": cycle["p99"],
        "cycle_p999_us": cycle["p999"],
        "cycle_max_us": cycle["max"],
        "control_us": {p: control_us[p] for p in ("p50", "p99")},
        "stages": _stages(timed),
        "realtime_factor": chunks * _CHUNK * 1e-3 / spent,
        "plant_rate_hz": setup.scene.rates.plant,
        "contact_share": touching / (chunks * _CHUNK),
    }


def _stages(simulation: _core.Simulation) -> dict[str, StageTime]:
    times = simulation.timing()["stages"]
    return {name: {"p50_us": time["p50"], "p99_us": time["p99"]} for name, time in times.items()}


def _real_time(simulation: _core.Simulation, rate: float, seconds: float) -> RealTime:
    simulation.watch_stages()
    control = _core.BareLoop(rate)
    for _ in range(_TURNS):
        _let_run(control, seconds / _TURNS, lambda: None)
        _let_run(simulation, seconds / _TURNS, simulation.drain)
    timing, bare = simulation.timing(), control.timing()
    return {
        "rate_hz": rate,
        "seconds": seconds,
        "missed_ticks": timing["missed_ticks"],
        "lateness_p50_us": timing["lateness_us"]["p50"],
        "lateness_p99_us": timing["lateness_us"]["p99"],
        "lateness_p999_us": timing["lateness_us"]["p999"],
        "control_missed_ticks": bare["missed_ticks"],
        "control_lateness_p50_us": bare["lateness_us"]["p50"],
        "control_lateness_p99_us": bare["lateness_us"]["p99"],
        "control_lateness_p999_us": bare["lateness_us"]["p999"],
        "cycle_p50_us": timing["cycle_us"]["p50"],
        "cycle_p99_us": timing["cycle_us"]["p99"],
        "stages": _stages(simulation),
        "slack_p01_us": timing["slack_us"]["p01"],
        "scheduler": timing["scheduler"],
    }


def _several(setup: rig.Rig, count: int, rate: float, seconds: float) -> list[OneArm]:
    """`count` pairs at once in real time, in turns with as many bare loops; on any core, and nobody spins.

    All pairs share the scene, publish their instrument and read those of the others, which push with zero stiffness.
    """
    options, shared = setup.options(), _core.RealTimeOptions()
    shared.allow_affinity, shared.spin_us = False, 0.0
    options.realtime = shared
    simulations = [setup.simulation(options=options) for _ in range(count)]
    join_instruments(simulations, [capsules(setup)] * count, 0.0, 0.0)
    controls = [_core.BareLoop(rate, shared) for _ in range(count)]
    for _ in range(_TURNS):
        for loops in (controls, simulations):
            for loop in loops:
                loop.start()
            end = time.monotonic() + seconds / _TURNS
            while (left := end - time.monotonic()) > 0:
                time.sleep(min(0.2, left))
                for simulation in simulations:
                    simulation.drain()
            for loop in loops:
                loop.stop()
    rows: list[OneArm] = []
    for i, (simulation, control) in enumerate(zip(simulations, controls, strict=True)):
        timing, bare = simulation.timing(), control.timing()
        rows.append(
            {
                "arm": i,
                "rate_hz": rate,
                "seconds": seconds,
                "missed": timing["missed_ticks"],
                "control_missed": bare["missed_ticks"],
                "lateness_p99_us": timing["lateness_us"]["p99"],
                "control_lateness_p99_us": bare["lateness_us"]["p99"],
                "cycle_p50_us": timing["cycle_us"]["p50"],
                "cycle_p99_us": timing["cycle_us"]["p99"],
            }
        )
    return rows


def _let_run(loop: _Timed, seconds: float, look: Callable[[], object]) -> None:
    """Run a loop for ``seconds`` [s] and call ``look`` about every 0.2 s, as a recorder does."""
    end = time.monotonic() + seconds
    loop.start()
    while (left := end - time.monotonic()) > 0:
        time.sleep(min(0.2, left))
        look()
    loop.stop()
