"""`palpate bench loop`: computing time and timing accuracy of the haptic cycle.

The benchmark measures the computing time of a cycle (from state to torque) while the hand palpates an organ, the speed
of lockstep simulation relative to real time, and the lateness of the ticks of a real-time loop. A control loop without
computation and with the same privileges runs alternately, so that both loops see the same load of the machine.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Protocol

from palpate import _core
from palpate.scene import Scene, rig

Result = dict[str, Any]
Progress = Callable[[str], None]

_TURNS = 4  # alternations of loop and control per rate
_STIFFNESS = 400.0  # stiffness of the organ [N/m]


class _Timed(Protocol):
    def start(self) -> None: ...
    def stop(self) -> None: ...
    def timing(self) -> dict[str, Any]: ...


def default_mesh() -> Path | None:
    """The liver of the test data (`PALPATE_DATA`, or `../shared/data` next to the repository); None when absent."""
    folder = Path(__file__).resolve().parents[4] / "shared" / "data"
    liver = Path(os.environ.get("PALPATE_DATA") or folder) / "meshes" / "Liver.stl"
    return liver if liver.is_file() else None


def run(
    seconds: float = 60.0,
    *,
    mesh: Path | None = None,
    rates: Iterable[float] = (1000.0, 4000.0),
    lockstep_seconds: float = 20.0,
    on_progress: Progress = lambda _: None,
) -> Result:
    """Measure; takes 2 * seconds per rate, and a few seconds for lockstep.

    Args:
        seconds: real time measured per rate, for loop and control each [s].
        mesh: STL file in millimetres to palpate; default: the liver of the test data, or the shipped organ.
        rates: rates of the haptic cycle in real-time mode [Hz].
        lockstep_seconds: simulated time of the lockstep run [s].
        on_progress: called with the name of each measurement.

    Returns:
        The documented JSON of `palpate bench loop`: lockstep figures at 1 kHz (`cycle_*_us`, `realtime_factor`),
        real-time figures at 1 kHz (`missed_ticks`, `lateness_*_us`, `control_*`), and all real-time rows in `realtime`.
    """
    mesh = mesh or default_mesh()
    result: Result = {"surface": mesh.name if mesh else "shipped organ", "rate_hz": 1000.0}
    on_progress(f"lockstep at 1000 Hz on {result['surface']}, {lockstep_seconds:g} s simulated")
    result |= _lockstep(_setup(mesh, 1000.0), lockstep_seconds)

    rows = []
    for rate in rates:
        on_progress(f"real time at {rate:g} Hz, {seconds:g} s, and as long a bare loop, in turns")
        rows.append(_real_time(_setup(mesh, rate).simulation(), rate, seconds))
    first = next((row for row in rows if row["rate_hz"] == 1000.0), rows[0] if rows else {})
    keys = ("missed_ticks", "lateness_p99_us", "control_missed_ticks", "control_lateness_p99_us")
    return result | {key: first[key] for key in keys if key in first} | {"realtime": rows}


def table(result: Result) -> str:
    """The result as text, one line per figure, units named."""
    lines = [
        f"haptic cycle on {result['surface']} ({result['triangles']} triangles), 1000 Hz, lockstep",
        f"  compute time  p50 {result['cycle_p50_us']:.2f} us   p99 {result['cycle_p99_us']:.2f} us   "
        f"p99.9 {result['cycle_p999_us']:.2f} us   max {result['cycle_max_us']:.1f} us",
        f"  simulation    {result['realtime_factor']:.1f} x real time, plant at {result['plant_rate_hz']:g} Hz, "
        f"in contact {100 * result['contact_share']:.0f} % of the time",
        "",
        "real time              missed    lateness p50 / p99 / p99.9 us       cycle p50 / p99 us",
    ]
    for row in result["realtime"]:
        lines += [
            f"  {row['rate_hz']:5g} Hz loop      {row['missed_ticks']:8d}    {row['lateness_p50_us']:8.2f} / "
            f"{row['lateness_p99_us']:7.2f} / {row['lateness_p999_us']:8.2f}     "
            f"{row['cycle_p50_us']:6.2f} / {row['cycle_p99_us']:.2f}",
            f"  {row['rate_hz']:5g} Hz control   {row['control_missed_ticks']:8d}    "
            f"{row['control_lateness_p50_us']:8.2f} / {row['control_lateness_p99_us']:7.2f} / "
            f"{row['control_lateness_p999_us']:8.2f}",
        ]
    lines += [f"  scheduler: {row['scheduler']}" for row in result["realtime"][:1]]
    return "\n".join(lines)


def _setup(mesh: Path | None, rate: float) -> rig.Rig:
    organ: dict[str, Any] = {"mesh": str(mesh), "unit": "mm"} if mesh else {"shape": "organ"}
    organ["stiffness"] = _STIFFNESS
    return rig.build(Scene.model_validate({"objects": [organ], "rates": {"haptic": rate}}))


def _lockstep(setup: rig.Rig, seconds: float) -> Result:
    simulation = setup.simulation()
    ticks = round(seconds * 1000.0)
    begin = time.perf_counter()
    rows = simulation.run(ticks)
    spent = time.perf_counter() - begin
    contacts = {row[0]: row[1] // 8 for row in _core.signals()}["contacts"]
    cycle = simulation.timing()["cycle_us"]
    return {
        "triangles": sum(len(s.body.triangles) for s in setup.surfaces),
        "cycle_p50_us": cycle["p50"],
        "cycle_p99_us": cycle["p99"],
        "cycle_p999_us": cycle["p999"],
        "cycle_max_us": cycle["max"],
        "realtime_factor": seconds / spent,
        "plant_rate_hz": setup.scene.rates.plant,
        "contact_share": float((rows[:, contacts] > 0).mean()),
    }


def _real_time(simulation: _core.Simulation, rate: float, seconds: float) -> Result:
    control = _core.BareLoop(rate)
    for _ in range(_TURNS):
        _let_run(control, seconds / _TURNS, lambda: None)
        _let_run(simulation, seconds / _TURNS, simulation.drain)
    row: Result = {"rate_hz": rate, "seconds": seconds}
    for prefix, timing in (("", simulation.timing()), ("control_", control.timing())):
        row[prefix + "missed_ticks"] = timing["missed_ticks"]
        for p in ("p50", "p99", "p999"):
            row[f"{prefix}lateness_{p}_us"] = timing["lateness_us"][p]
    timing = simulation.timing()
    return row | {
        "cycle_p50_us": timing["cycle_us"]["p50"],
        "cycle_p99_us": timing["cycle_us"]["p99"],
        "slack_p01_us": timing["slack_us"]["p01"],
        "scheduler": timing["scheduler"],
    }


def _let_run(loop: _Timed, seconds: float, look: Callable[[], object]) -> None:
    """Run a loop for ``seconds`` [s] and call ``look`` about every 0.2 s, as a recorder does."""
    end = time.monotonic() + seconds
    loop.start()
    while (left := end - time.monotonic()) > 0:
        time.sleep(min(0.2, left))
        look()
    loop.stop()
