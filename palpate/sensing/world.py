"""What a simulated camera sees of a running scene: its real objects and the follower's instrument."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import numpy.typing as npt

from palpate.arm.shapes import Visual
from palpate.base.arrays import Array
from palpate.base.arrays.rigid import transform
from palpate.record import live
from palpate.record.ticks import Ticks
from palpate.scene.rig import Rig
from palpate.sensing.depth_camera import Body
from palpate.world import surfaces
from palpate.world.shapes import analytic

TISSUE = ((140, 40, 32), (196, 120, 92), (120, 140, 70), (190, 150, 110))
"""Colours of the objects, red, green, blue."""


class SeenWorld:
    """Bodies of a rig, and their poses at the newest tick.

    Objects that a camera renders from its clouds are not seen: they are not there.

    Args:
        rig: the rig.
        latest: the newest tick of the loop.
        instrument: True: the follower is seen too.
    """

    def __init__(self, rig: Rig, latest: Callable[[], Ticks], instrument: bool = True) -> None:
        self._rig, self._latest = rig, latest
        self._seen = [i for i, obj in enumerate(rig.scene.objects) if obj.presence != "virtual" and not obj.is_sensed]
        self.bodies = [self._object(i) for i in self._seen]
        self._arm = rig.scene.arm("follower") if instrument else None
        self._links: list[str] = []
        if self._arm is not None:
            self._links = list(dict.fromkeys(visual.link for visual in self._arm.visuals))
            self.bodies += [_link(link, self._arm.visuals) for link in self._links]

    def poses(self) -> list[Array]:
        """Poses (4, 4) of all bodies in W, as `bodies` lists them [m]."""
        tick, objects = self._latest(), self._rig.snapshot.objects
        t, found = float(np.nan_to_num(tick["t"])), []
        for i in self._seen:
            slot = sum(obj.is_live for obj in objects[:i])
            X_WO = live.object_pose(tick, slot) if objects[i].is_live else None
            found.append(objects[i].pose(t) if X_WO is None else X_WO)
        if self._arm is not None:
            q = np.array(tick["q_follower"][: self._arm.n])
            q = q if np.isfinite(q).all() and q.any() else self._rig.arms.q_follower0
            links = self._arm.link_poses(q, float(np.nan_to_num(tick["jaw"])))
            found += [self._rig.arms.X_WB @ links[link] for link in self._links]
        return found

    def _object(self, index: int) -> Body:
        body = self._rig.surfaces[index].body
        section = self._rig.scene.objects[index]
        return Body(section.name, body.vertices, body.triangles, section.color or TISSUE[index % len(TISSUE)])


def _link(name: str, visuals: Iterable[Visual]) -> Body:
    """The primitives of one link of an arm as one body."""
    vertices, triangles, count = [], [], 0
    color = (160, 165, 175)
    for visual in (v for v in visuals if v.link == name):
        p, corners = _primitive(visual)
        vertices.append(transform(visual.X_link_visual, p))
        triangles.append(corners + count)
        count += len(p)
        r, g, b = (round(255 * c) for c in visual.colour[:3])
        color = (r, g, b)
    return Body(name, np.concatenate(vertices), np.concatenate(triangles).astype(np.int32), color)


def _primitive(visual: Visual) -> tuple[Array, npt.NDArray[np.int32]]:
    """Vertices and triangles of a primitive around the origin, coarse enough to be drawn 30 times a second."""
    if visual.shape == "sphere":
        return analytic.Sphere(visual.size[0]).mesh(320)
    made = surfaces.Box(visual.size) if visual.shape == "box" else surfaces.Cylinder(*visual.size)
    return made.vertices, made.triangles
