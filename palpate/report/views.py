"""The tool's path over the touched surface: in perspective, from above and from the side."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.base.arrays.so3 import unit
from palpate.base.plotting.style import INK, MUTED, PROXY, SURFACE, TOOL, Canvas
from palpate.report.run import Run

_LIGHT = np.array([-0.4, -0.5, 0.77])


def path(run: Run, canvas: Canvas) -> Figure:
    """Tool (blue) and proxy (red) in the world frame; deflections as thin red lines."""
    tall = canvas.narrow
    figure = Figure(figsize=(canvas.width, 10.0 if tall else 3.3), layout="constrained")
    panels = figure.subplots(3, 1) if tall else figure.subplots(1, 3)
    centre, reach = _window(run)
    across = _slide_direction(run)
    up = np.array([0.0, 0.0, 1.0])
    side = np.cross(up, across)
    oblique = unit(0.45 * across - 0.8 * side + 0.55 * up)  # direction from the middle to the eye
    right = unit(np.cross(up, oblique))
    views = [
        ("from the side, obliquely", right, np.cross(oblique, right), oblique, False),
        ("from above", np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), up, True),
        ("from the side, along the slide", across, up, -side, True),
    ]
    for axes, (title, x, y, eye, measured) in zip(panels, views, strict=True):
        _draw(run, axes, centre, reach, np.stack([x, y, eye]))
        axes.set_title(title, loc="left", fontsize=8.5, color=INK)
        axes.set_aspect("equal")
        axes.set(xlim=(-reach, reach), ylim=(-0.8 * reach, 0.8 * reach))
        axes.grid(False)
        axes.tick_params(length=2)
        if measured:
            names = ("x [mm]", "y [mm]") if title == "from above" else ("along the slide [mm]", "z [mm]")
            axes.set(xlabel=names[0], ylabel=names[1])
        else:
            _scale_bar(axes, reach)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2 if tall else 4, handlelength=1.4)
    return figure


def _draw(run: Run, axes: Axes, centre: Array, reach: float, R: Array) -> None:
    """Draw one view; the rows of R are the directions right, up and towards the eye."""
    for vertices, triangles in run.surface:
        _draw_surface(axes, 1e3 * (vertices - centre) @ R.T, triangles, reach)
    step = max(1, len(run.t) // 3000)
    tool = 1e3 * (run.ticks["p_WT"][::step] - centre) @ R.T
    proxy = 1e3 * (run.ticks["p_WP"][::step] - centre) @ R.T
    touching = run.ticks["contacts"][::step] > 0
    axes.plot(tool[:, 0], tool[:, 1], color=TOOL, lw=0.9, label="tool tip x")
    axes.plot(tool[:1, 0], tool[:1, 1], "o", color=TOOL, ms=3.5, label="start")
    rows = np.flatnonzero(touching)
    on = np.where(touching[:, None], proxy, np.nan)
    axes.plot(on[:, 0], on[:, 1], color=PROXY, lw=1.1, label="proxy $x_d$ on the surface")
    few = rows[:: max(1, len(rows) // 40)]
    lines = np.full((3 * len(few), 2), np.nan)
    lines[0::3], lines[1::3] = tool[few, :2], proxy[few, :2]
    axes.plot(lines[:, 0], lines[:, 1], color=PROXY, lw=0.6, alpha=0.6, label="deflection $δx = x_d − x$")


def _draw_surface(axes: Axes, points: Array, triangles: NDArray[np.int32], reach: float) -> None:
    """Draw the triangles in the window that face the eye, far ones first, shaded by their slope."""
    corners = points[triangles]
    near = (np.abs(corners[..., :2]).min(axis=1) < 1.05 * reach).all(axis=1)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1)
    seen = near & (normals[:, 2] > 0) & (length > 0)
    corners, normals = corners[seen], normals[seen] / length[seen][:, None]
    order = np.argsort(corners[..., 2].mean(axis=1))
    light = 0.86 + 0.24 * np.clip(normals @ _LIGHT, -0.8, 1.0)
    colors = np.clip(light[:, None] * np.array(to_rgb(SURFACE)), 0, 1)
    patch = PolyCollection(corners[order, :, :2], facecolors=colors[order], edgecolors=colors[order], lw=0.15)
    patch.set_rasterized(True)
    axes.add_collection(patch)


def _window(run: Run) -> tuple[Array, float]:
    """Centre [m] and half-width [mm] of the views: the part of the path in contact, with a margin."""
    touched = run.ticks["p_WT"][run.ticks["contacts"] > 0]
    points = touched if len(touched) else run.ticks["p_WT"]
    low, high = points.min(axis=0), points.max(axis=0)
    return 0.5 * (low + high), max(8.0, 1e3 * 0.5 * float(np.linalg.norm(high - low)) * 1.25)


def _slide_direction(run: Run) -> Array:
    """Horizontal unit vector (3,) along which the contact path extends most."""
    touched = run.ticks["p_WT"][run.ticks["contacts"] > 0][:, :2]
    if len(touched) < 3:
        return np.array([1.0, 0.0, 0.0])
    _, _, axes = np.linalg.svd(touched - touched.mean(axis=0), full_matrices=False)
    direction = np.array([axes[0, 0], axes[0, 1], 0.0])
    return unit(direction if direction[0] >= 0 else -direction)


def _scale_bar(axes: Axes, reach: float) -> None:
    length = max((b for b in (1, 2, 5, 10, 20, 50, 100, 200) if b < 0.6 * reach), default=1)
    x, y = -0.92 * reach, -0.72 * reach
    axes.plot([x, x + length], [y, y], color=INK, lw=1.6, solid_capstyle="butt")
    axes.annotate(
        f"{length} mm", (x + 0.5 * length, y), xytext=(0, 3), textcoords="offset points", ha="center", fontsize=7
    )
    axes.set(xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.title.set_color(MUTED)
