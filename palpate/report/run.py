"""A record with the data that the report derives from it: settings, numbers, phases of the touch, surfaces."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from palpate.base.arrays.plain import Content
from palpate.base.arrays.yaml_loader import load
from palpate.record.reader import Record
from palpate.record.ticks import Ticks
from palpate.report.digest import Digest
from palpate.scene.remote import UNKNOWN

_GAP = 0.05  # contacts with a shorter break count as one touch [s]
_PART = 100_000  # ticks whose motion is looked at together
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
        self.scene: Content = _mapping(record.scene)

    @cached_property
    def digest(self) -> Digest:
        """Numbers of all ticks, and the ticks that figures draw."""
        return Digest(self.record, len(self.tracked_frames))

    @property
    def ticks(self) -> Ticks:
        """The ticks that figures draw (n,): all, or in a long run those that keep every peak."""
        return self.digest.ticks

    @property
    def t(self) -> NDArray[np.float64]:
        """Times of `ticks` (n,) [s]."""
        return np.asarray(self.ticks["t"])

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
        from palpate.base.errors import PalpateError

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
        """Names of the scene's objects, in the scene's order, and of the plane that is felt beside them."""
        objects = self.setting("objects")
        names = [str(o.get("name")) for o in objects if isinstance(o, dict)] if isinstance(objects, list) else []
        return [*names, UNKNOWN]

    @property
    def tracked_frames(self) -> list[str]:
        """Names of the recorded frames that a tracker moved, in the scene's order."""
        frames = self.setting("frames")
        recorded = isinstance(frames, list) and "tracked_p" in self.record.signals
        found = [f for f in frames if isinstance(f, dict) and f.get("tracker")] if recorded else []
        return [str(f.get("child")) for f in found]

    @cached_property
    def touches(self) -> list[tuple[int, int]]:
        """Intervals in contact: (first tick, tick after the last), by the number of the tick in the record."""
        gap = _GAP * self.record.rate
        merged: list[tuple[int, int]] = []
        for start, end in self.digest.touches:
            if merged and start - merged[-1][1] < gap:
                merged[-1] = (merged[-1][0], end)
            else:
                merged.append((start, end))
        return merged

    @cached_property
    def phases(self) -> list[Phase]:
        """The phases approach, press, slide and leave, found from the motion."""
        found: list[Phase] = []
        n = len(self.record)
        for k, (start, end) in enumerate(self.touches):
            before = self.touches[k - 1][1] if k else 0
            after = self.touches[k + 1][0] if k + 1 < len(self.touches) else n
            free = (before + start) // 2 if k else 0
            first, last = self._slide(start, end)
            gone = (end + after) // 2 if after < n else n
            marks = [("approach", free, start), ("press", start, first), ("slide", first, last), ("leave", last, gone)]
            found += [Phase(name, self._time(a), self._time(b)) for name, a, b in marks if b > a]
        return found

    def _slide(self, start: int, end: int) -> tuple[int, int]:
        """First and last tick of a touch at which the tool moves along the surface; its end twice without any."""
        first = last = end
        for a in range(start, end, _PART):
            inside = np.flatnonzero(self._sliding(a, min(a + _PART, end)))
            if len(inside):
                first = a + int(inside[0]) if first == end else first
                last = a + int(inside[-1])
        return first, last

    def _sliding(self, start: int, stop: int) -> NDArray[np.bool_]:
        """True while the tool moves along the surface, at the ticks from `start` up to `stop`."""
        n = len(self.record)
        width = max(1, min(n, round(0.1 * self.record.rate)))
        a, b = max(0, start - width - 1), min(n, stop + width + 1)
        ticks = self.record.read(["p_WT", "normal", "contacts"], a, b)
        v = np.gradient(ticks["p_WT"], axis=0) * self.record.rate if len(ticks) > 1 else np.zeros((1, 3))
        n_W = ticks["normal"]
        along = v - np.einsum("ij,ij->i", v, n_W)[:, None] * n_W
        along[ticks["contacts"] == 0] = 0.0
        padded = np.pad(along, ((width, width), (0, 0)))  # at the ends of the run as if the tool were at rest
        smooth = np.stack([np.convolve(column, np.ones(width) / width, "same") for column in padded.T], axis=1)
        inside = smooth[width + start - a : width + stop - a]
        return np.asarray(np.linalg.norm(inside, axis=1) > _SLIDING)

    @property
    def stiffness(self) -> float | None:
        """Slope of the spring force over the penetration, both on the tool [N/m]; None without contact."""
        return self.digest.stiffness

    @cached_property
    def surface(self) -> list[tuple[NDArray[np.float64], NDArray[np.int32]]]:
        """Touched surfaces in W, to draw: vertices (n, 3) [m] and triangles (m, 3). Empty if they cannot be rebuilt."""
        from palpate.base.errors import PalpateError

        try:
            from palpate.scene.surface import placed
            from palpate.session.recorded import recorded_scene
            from palpate.world.mesh import quiet
            from palpate.world.mesh.coarse import MOST_TRIANGLES

            with quiet():  # the run has warned of defects in the meshes
                surfaces = placed(recorded_scene(self.record))
        except (ImportError, PalpateError, OSError, ValueError):
            return []  # the mesh was moved, or the record comes from another machine
        drawn = [(one.X_WO, *one.drawable(MOST_TRIANGLES)) for one in surfaces]
        return [(vertices @ X_WO[:3, :3].T + X_WO[:3, 3], triangles) for X_WO, vertices, triangles in drawn]

    def _time(self, tick: int) -> float:
        return self.digest.time(min(tick, len(self.record) - 1))


def _mapping(text: str) -> Content:
    try:
        value = load(text)
    except yaml.YAMLError:
        return {}
    return value if isinstance(value, dict) else {}
