"""A tool that rests on a surface which moves, seen by a camera: the force against that of the true surface."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypedDict

import numpy as np

from palpate.base.arrays import Array
from palpate.devices.loop import DeviceLoop, device_scene
from palpate.record.ticks import Ticks, as_ticks
from palpate.scene.scene import Scene
from palpate.sensing.sensing import Sensing
from palpate.sensing.source import CloudFrame

RATE, SIGMA = 30.0, 1e-3
"""Frames per second [Hz]; noise of each coordinate [m]."""
STIFFNESS, RADIUS = 1000.0, 0.003
"""Of the surface [N/m]; of the tool's tip [m]."""
_DELAY = 0.03  # from the stamp of a frame to its arrival, in the cases [s]
_START = 0.3  # time after which a case is judged [s]
_CURVE = 0.12  # z = height - (x^2 + y^2) / _CURVE [m]
SCENE = f"""
objects:
  - name: organ
    cloud: {{sensor: camera}}
    stiffness: {STIFFNESS}
contact: {{radius: {RADIUS}}}
arms: {{follower: {{start: {{xyz: [0, 0, 0], rpy_deg: [180, 0, 0]}}}}}}
operator: {{path: [{{t: 0, xyz: [0, 0, 0]}}, {{t: 1, xyz: [0, 0, 0]}}]}}
"""
Height = Callable[[Any], Any]


@dataclass(frozen=True)
class Case:
    """A motion of the surface."""

    height: Height  #: of the top at the times t [s] [m]
    seconds: float  #: duration [s]
    seen: Callable[[Any], Any]  #: whether frames can have shown the motion at the times t [s]


class CaseFigures(TypedDict):
    """What a tool at rest felt."""

    force_error_rms: float  #: rms error of the spring force once frames have shown the motion, relative to its rms [-]
    resting_error_rms: float  #: the same if the surface rests between two frames
    whole_error_rms: float  #: the first one over the whole case, with what no frame has shown yet
    least_N: float  #: least spring force outwards while the tool is 2 mm or more inside the true surface [N]
    rate_N_s: float  #: largest rate of the force on the hand [N/s]


def _ramp(low: float, speed: float, begin: float, end: float) -> Height:
    return lambda t: low + speed * np.clip(np.asarray(t) - begin, 0.0, end - begin)


def _press_and_retreat(t: Any) -> Any:
    return _ramp(-0.01, 0.05, 0.3, 0.82)(t) + _ramp(0.0, -0.1, 1.0, 1.25)(t)


def _breath(t: Any) -> Any:
    return 0.001 + 0.002 * (1.0 - np.cos(0.5 * np.pi * np.asarray(t)))


def _jumps(t: Any) -> Any:
    return np.where((np.asarray(t) // 0.5) % 2 == 0, 0.0005, 0.0055)


def _between(begin: float, end: float) -> Callable[[Any], Any]:
    return lambda t: (t > begin) & (t < end)


CASES = {
    "rising at 0.1 m/s": Case(_ramp(-0.016, 0.1, 0.3, 0.55), 0.8, _between(0.3, 0.55)),
    "retreating at 0.1 m/s": Case(_press_and_retreat, 1.5, _between(1.1, 1.19)),
    "breathing": Case(_breath, 4.5, _between(_START, 4.5)),
    "jumps of 5 mm": Case(_jumps, 2.0, lambda t: (t > _START) & (t % 0.5 > 1.0 / RATE + _DELAY + 0.005)),
}
"""Surfaces that move under a resting tool."""


class MovingSurface:
    """A source of a paraboloid with its top at (0, 0, height(t)), seen by a camera 0.5 m above it.

    Args:
        height: height of the top at the time t [s] [m].
        points: points of a frame.
        side: side of the square field of view [m].
        delay: from the stamp of a frame to its arrival [s].
        frames: frames with different noise, which take turns.
    """

    def __init__(
        self, height: Height, points: int = 6000, side: float = 0.1, delay: float = 0.0, frames: int = 8
    ) -> None:
        rng = np.random.default_rng(0)
        self._height, self._delay, self._next = height, delay, 0
        self.X_WC = np.eye(4)
        self.X_WC[:3, :3], self.X_WC[2, 3] = np.diag([1.0, -1.0, -1.0]), 0.5
        self._frames = []
        for _ in range(frames):
            xy = rng.uniform(-side / 2, side / 2, (points, 2))
            p_W = np.c_[xy, -(xy**2).sum(axis=1) / _CURVE] + SIGMA * rng.normal(size=(points, 3))
            self._frames.append(((p_W - self.X_WC[:3, 3]) @ self.X_WC[:3, :3]).astype(np.float32))
        self._depths = [points_C[:, 2].copy() for points_C in self._frames]

    def latest(self, now: float) -> CloudFrame | None:
        """The newest frame, once its time has come."""
        k = int((now - self._delay) * RATE + 1e-9)
        if k < self._next or now < self._delay:
            return None
        self._next = k + 1
        t, i = k / RATE, k % len(self._frames)
        np.subtract(self._depths[i], np.float32(self._height(t)), out=self._frames[i][:, 2])
        return CloudFrame(self._frames[i], t, self.X_WC)

    def close(self) -> None:
        """Nothing is open."""


def true_force(rows: Ticks, height: Height) -> Array:
    """Spring force (n,) along z [N] of the true surface at the measured poses of the tool, which is above its top."""
    p = np.asarray(rows["p_WT"])
    depth = RADIUS + height(rows["t"]) - p[:, 2] - (p[:, :2] ** 2).sum(axis=1) / _CURVE
    return np.asarray(STIFFNESS * np.maximum(0.0, depth), dtype=np.float64)


def relative_error(felt: Array, exact: Array) -> float:
    """Rms difference of two forces (n,), relative to the rms of the exact one [-]."""
    return round(float(np.sqrt(np.mean((felt - exact) ** 2) / np.mean(exact**2))), 4)


def force_error(rows: Ticks, height: Height) -> float:
    """Rms error of the recorded spring force, relative to its rms [-]."""
    return relative_error(np.asarray(rows["F_spring_W"])[:, 2], true_force(rows, height))


def felt(height: Height, seconds: float, extrapolate: bool = True) -> Ticks:
    """Ticks of a tool at rest at the origin, in simulated time. Frames become surfaces when they arrive."""
    loop = DeviceLoop(device_scene(Scene.parse(SCENE), "loop"))
    sensing = Sensing(loop.rig, loop, {"camera": MovingSurface(height, delay=_DELAY)}, extrapolate=extrapolate)
    rows = []
    for k in range(round(1000 * seconds)):
        loop.step(1e-3 * k, np.eye(4), None, 0.0, 0)
        rows.append(np.array(loop.latest()).reshape(1, -1))
        sensing.step(1e-3 * k)
    ticks: Ticks = as_ticks(np.concatenate(rows))
    return ticks


def measure(case: Case) -> CaseFigures:
    """The figures of one case."""
    moving, resting = (felt(case.height, case.seconds, extrapolate) for extrapolate in (True, False))
    judged = moving[moving["t"] > _START]
    inside = true_force(judged, case.height) > 2e-3 * STIFFNESS
    F = np.asarray(moving["F_H_L"])
    return {
        "force_error_rms": force_error(moving[case.seen(moving["t"])], case.height),
        "resting_error_rms": force_error(resting[case.seen(resting["t"])], case.height),
        "whole_error_rms": force_error(judged, case.height),
        "least_N": round(float(np.asarray(judged["F_spring_W"])[inside, 2].min()), 3),
        "rate_N_s": round(float(1e3 * np.linalg.norm(np.diff(F, axis=0), axis=1).max()), 1),
    }


def run() -> dict[str, CaseFigures]:
    """The figures of all cases."""
    return {name: measure(case) for name, case in CASES.items()}
