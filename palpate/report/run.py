"""A record with the data that the report derives from it: settings, phases of the touch, surfaces."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from palpate.arrays.plain import Content
from palpate.arrays.yaml_loader import load
from palpate.record.reader import Record
from palpate.record.ticks import Ticks

_GAP = 0.05  # contacts with a shorter break count as one touch [s]
_SLIDING = 0.004  # speed along the surface above which the tool slides [m/s]


@dataclass(frozen=True)
class Phase:
    """An interval of a touch."""

    name: str
    """approach, press, slide or leave."""
    start: float
    """Start time [s]."""
    end: float
    """End time [s]."""


class Run:
    """A record with its touches, phases and surfaces."""

    def __init__(self, record: Record) -> None:
        self.record = record
        self.ticks: Ticks = record.ticks
        self.t: NDArray[np.float64] = record.ticks["t"]
        self.scene: Content = _mapping(record.scene)

    def setting(self, *place: str) -> Any:
        """A value of the scene, e.g. ``setting("stability", "force_cap")``; None when the scene does not set it."""
        value: Any = self.scene
        for key in place:
            value = value.get(key) if isinstance(value, dict) else None
        return value

    @property
    def title(self) -> str:
        """Name of the scene, or else of the run's folder without its date."""
        folder = re.sub(r"-\d{8}-\d{6}(-\d+)?$", "", self.record.path.resolve().parent.name)
        return str(self.setting("name") or folder or "a run")

    @cached_property
    def sphere_names(self) -> list[str]:
        """Names of the tool's spheres, the one at the tip first; only ["tip"] if the scene cannot be rebuilt."""
        from palpate.arm import Arm
        from palpate.errors import PalpateError

        try:
            from palpate.scene.tool import tool_spheres
            from palpate.session.recorded import recorded_scene

            scene = recorded_scene(self.record)
            follower = Arm.model(scene.arms.follower.model)
            listed = tool_spheres(follower, scene.contact.spheres, scene.contact.whole_tool)
        except (ImportError, PalpateError, OSError, ValueError):
            return ["tip"]
        carried = () if scene.graspable is None else scene.graspable.spheres()
        return ["tip", *(sphere.name for sphere in listed), *(name for name, _ in carried)]

    @property
    def object_names(self) -> list[str]:
        """Names of the scene's objects, in the scene's order."""
        objects = self.setting("objects")
        return [str(o.get("name")) for o in objects if isinstance(o, dict)] if isinstance(objects, list) else []

    @property
    def tracked_frames(self) -> list[str]:
        """Names of the frames that a tracker moved, in the scene's order."""
        frames = self.setting("frames")
        found = [f for f in frames if isinstance(f, dict) and f.get("tracker")] if isinstance(frames, list) else []
        return [str(f.get("child")) for f in found]

    @cached_property
    def touches(self) -> list[tuple[int, int]]:
        """Intervals in contact: (first tick, tick after the last)."""
        touching = np.concatenate([[False], self.ticks["contacts"] > 0, [False]])
        starts, ends = (
            np.flatnonzero(np.diff(touching.astype(int)) == 1),
            np.flatnonzero(np.diff(touching.astype(int)) == -1),
        )
        gap = _GAP * self.record.rate
        merged: list[tuple[int, int]] = []
        for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
            if merged and start - merged[-1][1] < gap:
                merged[-1] = (merged[-1][0], end)
            else:
                merged.append((start, end))
        return merged

    @cached_property
    def phases(self) -> list[Phase]:
        """The phases approach, press, slide and leave, found from the motion."""
        found: list[Phase] = []
        n, sliding = len(self.t), self._sliding
        for k, (start, end) in enumerate(self.touches):
            before = self.touches[k - 1][1] if k else 0
            after = self.touches[k + 1][0] if k + 1 < len(self.touches) else n
            free = (before + start) // 2 if k else 0
            inside = np.flatnonzero(sliding[start:end])
            first, last = (start + inside[0], start + inside[-1]) if len(inside) else (end, end)
            gone = (end + after) // 2 if after < n else n
            marks = [("approach", free, start), ("press", start, first), ("slide", first, last), ("leave", last, gone)]
            found += [Phase(name, self._time(a), self._time(b)) for name, a, b in marks if b > a]
        return found

    @cached_property
    def _sliding(self) -> NDArray[np.bool_]:
        """True while the tool moves along the surface (n,)."""
        v = np.gradient(self.ticks["p_WT"], axis=0) * self.record.rate if len(self.t) > 1 else np.zeros((1, 3))
        n = self.ticks["normal"]
        along = v - np.einsum("ij,ij->i", v, n)[:, None] * n
        along[self.ticks["contacts"] == 0] = 0.0
        width = max(1, min(len(self.t), round(0.1 * self.record.rate)))
        smooth = np.stack([np.convolve(column, np.ones(width) / width, "same") for column in along.T], axis=1)
        return np.asarray(np.linalg.norm(smooth, axis=1) > _SLIDING)

    @cached_property
    def stiffness(self) -> float | None:
        """Slope of the spring force over the penetration, both on the tool [N/m]; None without contact."""
        depth = self.ticks["depth"]
        force = np.einsum("ij,ij->i", self.ticks["F_spring_W"], self.ticks["normal"])
        touching = depth > 0
        if touching.sum() < 10:
            return None
        return float(depth[touching] @ force[touching] / (depth[touching] @ depth[touching]))

    @cached_property
    def surface(self) -> list[tuple[NDArray[np.float64], NDArray[np.int32]]]:
        """Touched surfaces in W: vertices (n, 3) [m] and triangles (m, 3). Empty if they cannot be rebuilt."""
        from palpate.errors import PalpateError

        try:
            from palpate.mesh import quiet
            from palpate.scene.surface import placed
            from palpate.session.recorded import recorded_scene

            with quiet():  # the run has warned of defects in the meshes
                surfaces = placed(recorded_scene(self.record))
        except (ImportError, PalpateError, OSError, ValueError):
            return []  # the mesh was moved, or the record comes from another machine
        return [(s.body.vertices @ s.X_WO[:3, :3].T + s.X_WO[:3, 3], s.body.triangles) for s in surfaces]

    def _time(self, tick: int) -> float:
        return float(self.t[min(tick, len(self.t) - 1)])


def _mapping(text: str) -> Content:
    try:
        value = load(text)
    except yaml.YAMLError:
        return {}
    return value if isinstance(value, dict) else {}
