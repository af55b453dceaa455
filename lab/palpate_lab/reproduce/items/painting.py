"""Paints a moment of a run by software, for machines without a browser or without the viewer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import trimesh
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from palpate.base.arrays import Array
from palpate.base.plotting.style import SURFACE, TOOL, Canvas
from palpate.scene.rig import Rig
from palpate_lab.studies.figure12.figures import Solid, arm_solids, paint, view

_EYE = np.array([0.45, -1.0, 0.75])  # direction from which the scene is seen
_TISSUE = (*to_rgb(SURFACE), 1.0)
_BALL = (0.12, 0.44, 0.55, 1.0)
_MARGIN = 1.06  # half width of the picture over that of the scene [-]
_POINTS = 4000  # of a cloud

Moment = tuple[Rig, Any]
"""A pair as it was built, and one of its ticks, with the values of its signals by name."""


def painted(moments: Sequence[Moment], cloud_W: Array | None, canvas: Canvas) -> Figure:
    """Arms, tools and objects of all pairs at their moments; cloud_W: points (n, 3) of a camera [m]."""
    solids = [solid for rig, tick in moments for solid in (*_arms(rig, tick), _ball(rig, tick))]
    seen = [c.reshape(-1, 3) for c, _ in solids]
    solids += _organs(moments[0][0])
    corners = np.concatenate(seen)
    low, high = corners.min(axis=0), corners.max(axis=0)
    centre, R = 0.5 * (low + high), view(_EYE)
    reach = _MARGIN * float(np.abs((corners - centre) @ R[:2].T).max())
    figure = Figure(figsize=(min(canvas.width, 6.0),) * 2, layout="constrained")
    axes = figure.subplots()
    paint(axes, solids, centre, R, reach)
    if cloud_W is not None:
        shown = cloud_W[:: max(1, len(cloud_W) // _POINTS)]
        axes.plot(*((shown - centre) @ R[:2].T).T, ".", ms=0.8, color=TOOL, zorder=4)
    return figure


def _arms(rig: Rig, tick: Any) -> list[Solid]:
    arms = rig.arms
    found = arm_solids(arms.leader, arms.X_WL, tick["q"], 0.3)
    found += arm_solids(arms.follower, arms.X_WB, tick["q_follower"], float(tick["jaw"]))
    if rig.ecm is not None:
        found += arm_solids(rig.ecm.ecm.arm, rig.ecm.X_WB, rig.ecm.q0, 0.0)
    return found


def _ball(rig: Rig, tick: Any) -> Solid:
    sphere = trimesh.creation.icosphere(2, rig.scene.contact.radius)
    return (np.asarray(sphere.vertices) + tick["p_WT"])[sphere.faces], _BALL


def _organs(rig: Rig) -> list[Solid]:
    """The objects of a scene at rest, without those that are clouds of a sensor."""
    found: list[Solid] = []
    for section, placed in zip(rig.scene.objects, rig.surfaces, strict=True):
        if section.cloud is None:
            corners = (placed.body.vertices @ placed.X_WO[:3, :3].T + placed.X_WO[:3, 3])[placed.body.triangles]
            found.append((corners, _TISSUE))
    return found
