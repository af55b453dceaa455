"""Time from a depth camera's frame to the force, and the force on a moving surface (`palpate bench cloud`)."""

from __future__ import annotations

import time
from typing import Any, TypedDict

import numpy as np
from rich.table import Table

from palpate.record.ticks import as_ticks
from palpate.scene.scene import Scene
from palpate.sensing.source import CloudFrame
from palpate.session import Session
from palpate_lab.verify.bench import cloud_cases, cloud_organ
from palpate_lab.verify.bench.cloud_cases import CASES, CaseFigures, MovingSurface

POINTS = 300_000
"""Points of a frame."""
ORGAN_NOISES = (0.0, 3e-4, 1e-3)
"""Noise of the clouds of the organ [m]."""
_SIDE = 0.4  # of the square field of view [m]
_TURNS = 2  # with frames and without, so that both meet the same load of the machine
_SETTLED = 1.0  # time after which the force is judged [s]


class OrganFigures(TypedDict):
    """Force on a cloud of the organ with some noise, to that on its mesh."""

    noise_m: float  #: standard deviation of each coordinate
    difference_rms: float  #: relative to the rms force [-]
    difference_deg: float  #: rms angle between the two forces


class Figures(TypedDict):
    """Result of the benchmark."""

    points: int
    frames: int  #: frames that became a surface
    frame_to_force_ms: dict[str, float]  #: p50, p99: from the arrival of a frame to the tick that renders it
    frame_cpu_ms: float  #: processor time of the sensing thread for a frame, the median
    missed: int  #: ticks that missed their deadline while frames arrived
    control_missed: int  #: the same of the same scene without frames
    ticks: int
    force_error_rms: float  #: rms error of the spring force against the true moving surface, relative to its rms [-]
    cases: dict[str, CaseFigures]  #: surfaces that move under a resting tool, in simulated time
    organ_difference_rms: float  #: force on a cloud of the organ to that on its mesh, relative to its rms [-]
    organ_difference_deg: float  #: rms angle between the two forces [deg]
    organ: list[OrganFigures]  #: the same by the noise of the cloud; the two keys above are of the largest


class Camera(MovingSurface):
    """A moving surface whose frames arrive in real time."""

    arrival = 0.0  #: steady clock at the arrival of the newest frame [s]

    def latest(self, now: float) -> CloudFrame | None:
        """The newest frame, once its time has come."""
        frame = super().latest(now)
        self.arrival = time.perf_counter()
        return frame


class Still:
    """A source that never sends a frame: the control."""

    arrival = 0.0

    def latest(self, now: float) -> CloudFrame | None:
        """No frame."""
        return None

    def close(self) -> None:
        """Nothing is open."""


def run(seconds: float = 10.0, points: int = POINTS) -> Figures:
    """Run the scene in real time for some seconds [s] with frames, and as long without, in turns; then the cases."""
    breathing = CASES["breathing"]
    missed, control, latencies, used, turns = 0, 0, [], [], []
    for _ in range(_TURNS):
        control += _live(Still(), seconds / _TURNS)[0]
        one = _live(Camera(breathing.height, points, side=_SIDE), seconds / _TURNS)
        missed += one[0]
        latencies += one[1]
        used += one[2]
        turns.append(one[3])
    rows = np.concatenate(turns)
    organ = _organ()
    p50, p99 = np.percentile(1e3 * np.array(latencies), [50, 99]) if latencies else (np.nan, np.nan)
    return {
        "points": points,
        "frames": len(latencies),
        "frame_to_force_ms": {"p50": round(float(p50), 2), "p99": round(float(p99), 2)},
        "frame_cpu_ms": round(1e3 * float(np.median(used)), 2) if used else float("nan"),
        "missed": missed,
        "control_missed": control,
        "ticks": len(rows),
        "force_error_rms": cloud_cases.force_error(rows[rows["t"] > _SETTLED], breathing.height),
        "cases": cloud_cases.run(),
        "organ_difference_rms": organ[-1]["difference_rms"],
        "organ_difference_deg": organ[-1]["difference_deg"],
        "organ": organ,
    }


def _organ() -> list[OrganFigures]:
    rows: list[OrganFigures] = []
    for noise in ORGAN_NOISES:
        difference, angle = cloud_organ.difference(noise=noise)
        rows.append({"noise_m": noise, "difference_rms": round(difference, 4), "difference_deg": round(angle, 2)})
    return rows


def _live(source: Camera | Still, seconds: float) -> tuple[int, list[float], list[float], Any]:
    """Missed ticks, times from a frame's arrival to its first tick [s], processor times [s], and the rows."""
    session = Session(Scene.parse(cloud_cases.SCENE), clouds={"camera": source})
    assert session.sensing is not None
    latencies, used, rows = [], [], []
    session._loop.start()
    try:
        end = time.perf_counter() + seconds
        while time.perf_counter() < end:
            busy = time.thread_time()
            if session.sensing.step(float(session.latest()["t"])):
                used.append(time.thread_time() - busy)
                t = float(session.latest()["t"])
                while float(session.latest()["t"]) <= t:
                    time.sleep(1e-4)
                latencies.append(time.perf_counter() - source.arrival)
            rows.append(session._loop.drain())
            time.sleep(1e-3)
        missed = int(session.timing["missed_ticks"])
    finally:
        session._loop.stop()
    return missed, latencies, used, as_ticks(np.concatenate(rows))


def table(figures: Figures) -> Table:
    """The figures with what is asked."""
    out = Table("figure", "measured", "asked")
    late = figures["frame_to_force_ms"]
    out.add_row("frame to force, p50 and p99, ms", f"{late['p50']:g} / {late['p99']:g}", "40 / 60")
    out.add_row("processor time of a frame, ms", f"{figures['frame_cpu_ms']:g}", "")
    out.add_row("missed ticks, and of the control", f"{figures['missed']} / {figures['control_missed']}", "not more")
    out.add_row("rms error of the force, in real time", f"{100 * figures['force_error_rms']:.1f} %", "5 %")
    for name, found in figures["cases"].items():
        rms = f"{100 * found['force_error_rms']:.1f} %, without velocity {100 * found['resting_error_rms']:.1f} %"
        out.add_row(f"{name}: rms error of the force", rms, "5 %")
        out.add_row(f"{name}: least force N, largest rate N/s", f"{found['least_N']} / {found['rate_N_s']}", "")
    for row in figures["organ"]:
        organ = f"{100 * row['difference_rms']:.1f} %, {row['difference_deg']} deg"
        out.add_row(f"cloud of the organ, noise {1e3 * row['noise_m']:g} mm, to its mesh at 2 mm depth", organ, "")
    return out
