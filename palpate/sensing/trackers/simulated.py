"""A simulated optical tracker: rigid markers of four spheres, with noise, dropouts, occlusion and confusions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from palpate.base.arrays import Array
from palpate.sensing.trackers.tracker import Sighting

_MOST_FRAMES = 1000  # frames that one poll returns at most

#: Spheres (4, 3) of a marker in the tool's frame, with six different distances [m].
SPHERES = np.array([[0.0, 0.0, 0.0], [0.055, 0.0, 0.0], [-0.01, 0.075, 0.0], [-0.035, -0.03, 0.01]])


@dataclass(frozen=True)
class Fault:
    """A fault of the tracker in the interval [start, end) [s]; of every tool if `tool` is empty."""

    kind: Literal["occluded", "swapped-spheres", "swapped-tools", "stopped"]
    start: float
    end: float = math.inf
    tool: str = ""

    def hits(self, kind: str, tool: str, t: float) -> bool:
        """True if this fault of this kind applies to a tool at a time."""
        return self.kind == kind and self.start <= t < self.end and self.tool in ("", tool)


class SimulatedTracker:
    """A tracker whose frames are a pure function of time and seed.

    Args:
        tools: true pose X_tracker_tool (4, 4) [m] as a function of time [s], by name.
        rate: frames per second [Hz].
        noise: standard deviation of a sphere's position on each axis [m].
        dropout: fraction of the sightings that are lost [-].
        faults: faults by time.
        seed: seed of noise and dropouts.
        delay: time from a frame to its arrival [s].
    """

    def __init__(
        self,
        tools: Mapping[str, Callable[[float], Array]],
        rate: float = 60.0,
        noise: float = 0.25e-3,
        dropout: float = 0.0,
        faults: Sequence[Fault] = (),
        seed: int = 0,
        delay: float = 0.0,
    ) -> None:
        self._delay = delay
        self._tools, self._rate, self._noise = dict(tools), rate, noise
        self._dropout, self._faults, self._seed = dropout, tuple(faults), seed
        self._next = 0

    def poll(self, now: float) -> list[Sighting]:
        """Sightings of the frames that arrived since the last call, up to the time `now` [s]."""
        last = math.floor((now - self._delay) * self._rate + 1e-9)
        frames = range(max(self._next, last - _MOST_FRAMES), last + 1)
        self._next = max(self._next, last + 1)
        return [seen for k in frames for seen in self.frame(k)]

    def close(self) -> None:
        """Do nothing: there is no connection."""

    def frame(self, k: int) -> list[Sighting]:
        """Sightings of the frame `k`, taken at the time ``k / rate``."""
        t, names = k / self._rate, list(self._tools)
        found = []
        for i, name in enumerate(names):
            rng = np.random.default_rng([self._seed, k, i])
            lost = rng.random() < self._dropout
            noise = self._noise * rng.normal(size=(4, 3))
            if lost or self._hit("occluded", name, t) or self._hit("stopped", "", t):
                continue
            seen_as = names[(i + 1) % len(names)] if self._hit("swapped-tools", name, t) else name
            X = self._tools[seen_as](t)
            spheres = SPHERES[[1, 0, 2, 3]] if self._hit("swapped-spheres", name, t) else SPHERES
            fitted, error = fit(spheres @ X[:3, :3].T + X[:3, 3] + noise)
            found.append(Sighting(name, fitted, t, error))
        return found

    def _hit(self, kind: str, tool: str, t: float) -> bool:
        return any(fault.hits(kind, tool, t) for fault in self._faults)


def fit(spheres: Array) -> tuple[Array, float]:
    """Pose (4, 4) [m] of a marker from its measured spheres (4, 3) [m], and the rms residual [m]."""
    from scipy.spatial.transform import Rotation

    body, seen = SPHERES.mean(axis=0), spheres.mean(axis=0)
    R = Rotation.align_vectors(spheres - seen, SPHERES - body)[0].as_matrix()
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = R, seen - R @ body
    off = SPHERES @ R.T + X[:3, 3] - spheres
    return X, float(np.sqrt(np.mean(np.sum(off**2, axis=1))))
