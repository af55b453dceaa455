"""Time from a depth camera's frame to the force, and the force on a moving surface (`palpate bench cloud`)."""

from __future__ import annotations

import time
from typing import Any, TypedDict

import numpy as np
from rich.table import Table

from palpate.arrays import Array
from palpate.scene.scene import Scene
from palpate.sensing.source import CloudFrame
from palpate.session import Session

POINTS, RATE, SIGMA = 300_000, 30.0, 1e-3  # of a frame; [Hz]; noise of each coordinate [m]
_STIFFNESS, _RADIUS, _SIDE = 1000.0, 0.003, 0.4  # [N/m], [m], side of the square field of view [m]
_BREATH, _PERIOD = 0.004, 4.0  # amplitude [m] and period [s] of the surface
_SCENE = f"""
objects:
  - name: organ
    cloud: {{sensor: camera}}
    stiffness: {_STIFFNESS}
contact: {{radius: {_RADIUS}}}
arms: {{follower: {{start: {{xyz: [0, 0, 0], rpy_deg: [180, 0, 0]}}}}}}
operator: {{path: [{{t: 0, xyz: [0, 0, 0]}}, {{t: 1, xyz: [0, 0, 0]}}]}}
"""


class Figures(TypedDict):
    """Result of the benchmark."""

    points: int
    frames: int  #: frames that became a surface
    frame_to_force_ms: dict[str, float]  #: p50, p99: from the arrival of a frame to the tick that renders it
    missed: int  #: ticks that missed their deadline while frames arrived
    control_missed: int  #: the same of the same scene without frames
    ticks: int
    force_error_rms: float  #: rms error of the spring force against the true moving surface, relative to its rms [-]


class BreathingSurface:
    """A paraboloid with its top at (0, 0, z(t)), seen by a camera 0.5 m above it, made before the run."""

    def __init__(self, points: int = POINTS, frames: int = 4) -> None:
        rng = np.random.default_rng(0)
        self.X_WC = np.eye(4)
        self.X_WC[:3, :3], self.X_WC[2, 3] = np.diag([1.0, -1.0, -1.0]), 0.5
        xy = rng.uniform(-_SIDE / 2, _SIDE / 2, (points, 2))
        flat = np.c_[xy, -(xy**2).sum(axis=1) / 0.12]
        self._frames = [flat + SIGMA * rng.normal(size=flat.shape) for _ in range(frames)]
        self._next = 0
        self.arrived: list[tuple[float, float]] = []  #: session time and steady clock of each frame's arrival [s]

    @staticmethod
    def height(t: Array | float) -> Any:
        """Height of the top at the time t [s] in W [m]."""
        return 0.001 + 0.5 * _BREATH * (1.0 - np.cos(2.0 * np.pi * np.asarray(t) / _PERIOD))

    def latest(self, now: float) -> CloudFrame | None:
        """The newest frame, once its time has come."""
        k = int(now * RATE)
        if k < self._next:
            return None
        self._next = k + 1
        t = k / RATE
        p_W = self._frames[k % len(self._frames)] + [0.0, 0.0, float(self.height(t))]
        self.arrived.append((now, time.perf_counter()))
        return CloudFrame((p_W - self.X_WC[:3, 3]) @ self.X_WC[:3, :3], t, self.X_WC)

    def close(self) -> None:
        """Nothing is open."""


class Still:
    """A source that never sends a frame: the control."""

    def latest(self, now: float) -> CloudFrame | None:
        """No frame."""
        return None

    def close(self) -> None:
        """Nothing is open."""


def run(seconds: float = 10.0, points: int = POINTS) -> Figures:
    """Run the scene in real time for some seconds [s] with frames, and as long without."""
    control, _, _ = _live(Still(), seconds)
    source = BreathingSurface(points)
    missed, latencies, rows = _live(source, seconds)
    settled = rows["t"] > 1.0
    exact = _STIFFNESS * np.maximum(0.0, _RADIUS + BreathingSurface.height(rows["t"]) - rows["p_WT"][:, 2])[settled]
    felt = rows["F_spring_W"][settled, 2]
    p50, p99 = np.percentile(1e3 * np.array(latencies), [50, 99]) if latencies else (np.nan, np.nan)
    return {
        "points": points,
        "frames": len(latencies),
        "frame_to_force_ms": {"p50": round(float(p50), 2), "p99": round(float(p99), 2)},
        "missed": missed,
        "control_missed": control,
        "ticks": len(rows),
        "force_error_rms": round(float(np.sqrt(np.mean((felt - exact) ** 2) / np.mean(exact**2))), 4),
    }


def _live(source: Any, seconds: float) -> tuple[int, list[float], Any]:
    """Missed ticks, latencies from a frame's arrival to the first tick after its hand-over [s], and the rows."""
    session = Session(Scene.parse(_SCENE), clouds={"camera": source})
    assert session.sensing is not None
    latencies, rows, end = [], [], time.perf_counter() + seconds
    session._loop.start()
    try:
        while time.perf_counter() < end:
            began = time.perf_counter()
            if session.sensing.step(float(session.latest()["t"])):
                t = float(session.latest()["t"])
                while float(session.latest()["t"]) <= t:
                    time.sleep(1e-4)
                latencies.append(time.perf_counter() - began)
            rows.append(session._loop.drain())
            time.sleep(1e-3)
        missed = int(session.timing["missed_ticks"])
    finally:
        session._loop.stop()
    from palpate.record.ticks import as_ticks

    return missed, latencies, as_ticks(np.concatenate(rows))


def table(figures: Figures) -> Table:
    """The figures with what is asked."""
    out = Table("figure", "measured", "asked")
    late = figures["frame_to_force_ms"]
    out.add_row("frame to force, p50 / p99 [ms]", f"{late['p50']:g} / {late['p99']:g}", "40 / 60")
    out.add_row("missed ticks / of the control", f"{figures['missed']} / {figures['control_missed']}", "not more")
    out.add_row("rms error of the force", f"{100 * figures['force_error_rms']:.1f} %", "5 %")
    return out
