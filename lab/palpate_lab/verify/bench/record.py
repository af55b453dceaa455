"""`palpate bench record`: what a record of a long session costs to write, to keep, to read and to report.

The record repeats the ticks of one lockstep run of the scene, with its time going on, so that the hand is never idle.
Each figure is taken in a process of its own, whose peak memory the kernel knows.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypedDict

from rich.table import Table

from palpate.base.errors import PalpateError
from palpate.scene import shipped

HOURS = 0.02
MINUTE = 1.0 / 60.0

_RUN = """
import json, resource, sys, time
from palpate.scene import Scene
from palpate.session import Session
scene, folder = Scene.load(sys.argv[1]), sys.argv[2]
figures = {}
for name, out in (("bare", None), ("recorded", folder)):
    session = Session(scene, out=out)
    session.step(1000)
    began = time.perf_counter()
    summary = session.run(float(sys.argv[3]))
    figures[name] = float(sys.argv[3]) / (time.perf_counter() - began)
from palpate.report import write_report
write_report(summary.record)
figures |= {"record": summary.record, "rss_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}
print(json.dumps(figures))
"""

_WRITE = """
import json, sys, time
import numpy as np
from palpate.record import Record, Recorder
source, out, seconds = Record.open(sys.argv[1]), sys.argv[2], float(sys.argv[3])
ticks, rate = source.ticks.copy(), source.rate
t, spent, rounds = ticks["t"].copy(), 0.0, max(1, round(seconds * rate / len(ticks)))
with Recorder(out, source.scene, 0, rate, True) as recorder:
    for k in range(rounds):
        ticks["t"] = t + k * len(t) / rate
        began = time.process_time()
        for start in range(0, len(ticks), 100):
            recorder.append(ticks[start : start + 100])
        spent += time.process_time() - began
print(json.dumps({"writer_core": spent / (rounds * len(ticks) / rate)}))
"""

_REPORT = """
import json, resource, sys
from palpate.report import write_report
write_report(sys.argv[1])
used = resource.getrusage(resource.RUSAGE_SELF)
print(json.dumps({"rss_mb": used.ru_maxrss / 1024, "cpu_s": used.ru_utime + used.ru_stime}))
"""

_READ = """
import json, sys, time
from palpate.record import Record
began = time.process_time()
record = Record.open(sys.argv[1])
opened = time.process_time()
record["F_H_L"], record["q"]
read, at = time.process_time(), time.perf_counter()
record["F_T_W"]
took, waited = time.process_time() - read, time.perf_counter() - at
jumps = []
try:
    from palpate.viewer.gauges import HISTORY, POINTS, WINDOW
    from palpate.viewer.played import Played
except ImportError:
    Played = None
if Played is not None:
    played = Played(record)
    for k in range(50):  # moments all over the record, in no order: each is far from the one before
        left = time.process_time()
        number = played.number(played.span[0] + (0.618034 * (k + 1) % 1.0) * record.duration)
        played.tick(number), played.window(HISTORY, number, WINDOW, POINTS)
        jumps.append(time.process_time() - left)
print(json.dumps({"open_s": opened - began, "column_s": took, "column_wall_s": waited, "ticks": len(record),
                  "duration_s": record.duration, "jump_s": max(jumps, default=None)}))
"""


class Figures(TypedDict):
    """Result of the benchmark. The keys are the documented contract of ``--json``."""

    hours: float
    scene: str
    mb_per_s: float
    writer_core: float
    lockstep_x: float
    lockstep_bare_x: float
    run_rss_mb: float
    report_rss_mb: float
    report_rss_minute_mb: float
    report_cpu_s: float
    open_s: float
    column_s: float
    column_wall_s: float
    jump_s: float | None


def run(
    hours: float = HOURS,
    scene: Path | None = None,
    seconds: float = 20.0,
    on_progress: Callable[[str], None] = lambda _: None,
) -> Figures:
    """Measure; the result has the keys of `palpate bench record` in docs/json.md.

    Args:
        hours: length of the record [h].
        scene: scene file of one pair; the shipped palpation scene when left out.
        seconds: simulated time of the lockstep runs [s].
        on_progress: called before each measurement.
    """
    scene = scene or shipped.file("palpation")
    with tempfile.TemporaryDirectory(prefix="palpate-bench-") as folder:
        on_progress(f"running {scene.stem} for {seconds:g} s in lockstep, without and with a record")
        ran = _child(_RUN, str(scene), folder, str(seconds))
        long, minute = Path(folder) / "long" / "record.mcap", Path(folder) / "minute" / "record.mcap"
        for path, length in ((minute, MINUTE), (long, hours)):
            path.parent.mkdir()
            on_progress(f"writing a record of {60 * length:.3g} min")
            written = _child(_WRITE, ran["record"], str(path), str(3600.0 * length))
        on_progress("reading columns of the long one")
        read = _child(_READ, str(long))
        on_progress("reporting on both")
        reported = {path: _child(_REPORT, str(path)) for path in (minute, long)}
        size = long.stat().st_size
    return Figures(
        hours=hours,
        scene=str(scene),
        mb_per_s=1e-6 * size / read["duration_s"],
        writer_core=written["writer_core"],
        lockstep_x=ran["recorded"],
        lockstep_bare_x=ran["bare"],
        run_rss_mb=ran["rss_mb"],
        report_rss_mb=reported[long]["rss_mb"],
        report_rss_minute_mb=reported[minute]["rss_mb"],
        report_cpu_s=reported[long]["cpu_s"],
        open_s=read["open_s"],
        column_s=read["column_s"],
        column_wall_s=read["column_wall_s"],
        jump_s=read["jump_s"],
    )


def table(figures: Figures) -> Table:
    """The figures as a table for the terminal."""
    f = figures
    rows = [
        ("size", f"{f['mb_per_s']:.2f} MB/s", "of the record, while the hand palpates all the time"),
        ("writer", f"{100 * f['writer_core']:.1f} %", "of a core at the scene's rate"),
        ("lockstep", f"{f['lockstep_x']:.0f} x", f"real time with the record; {f['lockstep_bare_x']:.0f} x without"),
        ("end of a run", f"{f['run_rss_mb']:.0f} MB", "peak memory of the run and its report"),
        ("report", f"{f['report_rss_mb']:.0f} MB", f"peak memory; {f['report_rss_minute_mb']:.0f} MB for a minute"),
        ("report", f"{f['report_cpu_s']:.1f} s", "computing time"),
        ("open", f"{f['open_s']:.3f} s", "computing time until the record is open"),
        (
            "column",
            f"{f['column_s']:.2f} s",
            f"computing time to read F_T_W, by two threads in {f['column_wall_s']:.2f} s",
        ),
    ]
    if f["jump_s"] is not None:
        rows.append(
            ("jump", f"{f['jump_s']:.3f} s", "longest computing time of a replay to read what it shows elsewhere")
        )
    found = Table(title=f"a record of {f['hours']:g} h", title_justify="left", box=None, show_header=False)
    for _ in range(3):
        found.add_column("")
    for row in rows:
        found.add_row(*row)
    return found


def _child(code: str, *args: str) -> dict[str, Any]:
    """The figures that a process of its own prints."""
    done = subprocess.run([sys.executable, "-c", code, *args], capture_output=True, text=True, check=False)
    if done.returncode:
        raise PalpateError("a measurement failed", why=done.stderr.strip()[-300:])
    return dict(json.loads(done.stdout.splitlines()[-1]))
