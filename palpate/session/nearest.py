"""How far is the nearest surface, and in which direction must the hand move? What is told while nothing is touched."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.record.ticks import Ticks
from palpate.scene.live_targets import object_poses
from palpate.scene.rig import Rig

_AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Nearest:
    """The surface nearest to the tool's tip."""

    name: str
    """Name of the object."""
    distance: float
    """Distance of the tip's sphere from the surface; negative inside [m]."""
    towards_L: Array
    """Direction from the tip to the surface, in the axes of the leader's base L; unit vector (3,)."""
    hand: float | None
    """Distance that the hand moves to touch it; None where the mapping has no fixed scale [m]."""

    def words(self) -> str:
        """Name, distance and direction of the hand: ``'liver' is 20.0 mm away: move the hand 40 mm along -z``."""
        far = 1e3 * self.distance
        way = "move the hand" if self.hand is None else f"move the hand {1e3 * self.hand:.0f} mm"
        return f"{self.name!r} is {far:.{1 if far < 100.0 else 0}f} mm away: {way} along {self._direction()}"

    def _direction(self) -> str:
        """The direction as an axis of the leader's base where one is within 15 degrees, otherwise its components."""
        main = int(np.argmax(np.abs(self.towards_L)))
        if abs(self.towards_L[main]) > np.cos(np.radians(15.0)):
            return f"{'-' if self.towards_L[main] < 0.0 else '+'}{_AXES[main]}"
        return "(" + ", ".join(f"{x:.2f}" for x in self.towards_L + 0.0) + ")"


def nearest(rig: Rig, tick: Ticks, sensed: Mapping[str, _core.Surface] | None = None) -> Nearest | None:
    """The surface nearest to the tool's tip at a tick; None before the first tick and without any surface to feel.

    Surfaces of soft objects count at rest.

    Args:
        rig: the rig of the scene.
        tick: a tick of its loop.
        sensed: newest surfaces, in O, of objects that are clouds of a sensor (`Sensing.surfaces`); others of them do
            not count. They reach as far from the tool as the section's `region`.
    """
    p = np.asarray(tick["p_WT"], dtype=np.float64)
    if not (np.isfinite(p).all() and np.any(tick["quat_WT"])):
        return None
    poses, found = object_poses(rig, tick), []
    for section, obj, placed in zip(rig.scene.objects, rig.snapshot.objects, rig.surfaces, strict=True):
        core = (sensed or {}).get(obj.name) if section.is_sensed else placed.body.core
        if core is None or section.presence == "real":
            continue
        X = poses[obj.name]
        d, q, n = (rows[0] for rows in core.nearest(((p - X[:3, 3]) @ X[:3, :3])[None]))
        away = X[:3, :3] @ q + X[:3, 3] - p
        size = float(np.linalg.norm(away))
        towards = away / size if size > 1e-9 else -X[:3, :3] @ n
        found.append((float(d) - rig.scene.contact.radius, obj.name, towards if d > 0.0 else -towards))
    if not found:
        return None
    distance, name, towards = min(found, key=lambda one: one[0])
    mapping = rig.scene.mapping
    hand = max(distance, 0.0) / mapping.scale if mapping.law in ("indexed", "scaled") else None
    return Nearest(name, distance, rig.arms.X_WL[:3, :3].T @ towards, hand)


def in_words(rig: Rig, tick: Ticks, sensed: Mapping[str, _core.Surface] | None = None) -> str:
    """What is nearest while the tool touches nothing; empty in contact, under a force, and where nothing is known.

    Arguments as those of `nearest`; a session has it as `Session.nearest`.
    """
    if float(tick["contacts"]) > 0.0 or float(np.linalg.norm(np.nan_to_num(tick["F_asked"]))) > 0.0:
        return ""
    found = nearest(rig, tick, sensed)
    return "" if found is None or found.distance < 0.0 else found.words()
