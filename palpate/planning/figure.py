"""A picture of a plan: the motion from two sides, and the clearance over time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from palpate.base.arrays import Array
from palpate.base.plotting import style
from palpate.base.plotting.style import CAP, FORCE, INK, MUTED, SURFACE, TOOL, Canvas
from palpate.planning.problem import Problem
from palpate.planning.result import Plan

_SHADES = ("#e3b7a5", "#cfc57e", "#b9c7a3", "#c9b3d6", "#b7c9d6")
_POSES = 7  # instruments drawn along the motion
_SHOWN = 0.16  # length of the shaft that is drawn, from its tip [m]
_SIDES = (((0, 1), "seen from above"), ((0, 2), "seen from the feet"), ((1, 2), "seen from the side"))


def draw(file: Path, problem: Problem, plan: Plan) -> None:
    """Write the picture of a successful plan as PNG.

    Raises:
        OutputError: the file cannot be written.
    """
    style.png(lambda canvas: _figure(canvas, problem, plan), file)


def _figure(canvas: Canvas, problem: Problem, plan: Plan) -> Figure:
    figure = Figure(figsize=(canvas.width, 0.62 * canvas.width), layout="constrained")
    grid = figure.add_gridspec(2, 3, height_ratios=[2.0, 1.0])
    rows = plan.trajectory.at(np.linspace(0.0, plan.duration_s, 200))[0]
    tips = np.array([problem.robot.X_WB @ problem.robot.arm.fk(q) for q in rows])[:, :3, 3]
    picks = rows[np.linspace(0, len(rows) - 1, _POSES).astype(int)]
    for k, (axes_of, title) in enumerate(_SIDES):
        axes = figure.add_subplot(grid[0, k])
        _view(axes, problem, tips, picks, list(axes_of), title)
        if plan.clearance is not None and np.isfinite(plan.clearance.p_W).all():
            p = 1e3 * plan.clearance.p_W[list(axes_of)]
            axes.plot(*p, "o", color=FORCE, ms=5, zorder=6, label="smallest clearance" if k == 0 else None)
        if k == 0:
            axes.legend(loc="upper left", fontsize=6.5)
    _clearance(figure.add_subplot(grid[1, :]), plan)
    return figure


def _view(axes: Axes, problem: Problem, tips: Array, picks: Array, pair: list[int], title: str) -> None:
    shade = 0
    for obstacle in problem.world.obstacles:
        owner, slash, part = obstacle.name.partition("/")
        if slash and part.partition(".")[0] not in ("shaft", "wrist", "tool", "jaw_1", "jaw_2", "tip"):
            continue
        points = _outline(obstacle.solid.coal, obstacle.solid.bounds) @ obstacle.X_WO[:3, :3].T + obstacle.X_WO[:3, 3]
        colour = MUTED if slash else _SHADES[shade % len(_SHADES)]
        shade += not slash
        label = None if slash else owner
        _hull(axes, 1e3 * points[:, pair], colour, label)
    for n, ends in enumerate(problem.robot.placed(picks).ends_W):
        for body, (a, b) in zip(problem.robot.bodies, ends, strict=True):
            if body.link not in ("shaft", "wrist", "tool", "jaw_1", "jaw_2"):
                continue
            length = float(np.linalg.norm(b - a))
            a = b + (a - b) * min(1.0, _SHOWN / max(length, 1e-9))
            axes.plot(*(1e3 * np.stack([a, b])[:, pair].T), color=TOOL, lw=1.6, alpha=0.25 + 0.6 * n / _POSES, zorder=4,
                      solid_capstyle="round")  # fmt: skip
    axes.plot(*(1e3 * tips[:, pair].T), color=INK, lw=1.2, zorder=5)
    low, high = 1e3 * tips[:, pair].min(axis=0) - 75.0, 1e3 * tips[:, pair].max(axis=0) + 75.0
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", title=title,
             xlabel=f"{'xyz'[pair[0]]} [mm]", ylabel=f"{'xyz'[pair[1]]} [mm]")  # fmt: skip


def _outline(shape: object, bounds: Array) -> Array:
    if hasattr(shape, "vertices"):
        return np.asarray(shape.vertices(), dtype=float)
    low, high = np.maximum(bounds[0], -0.3), np.minimum(bounds[1], 0.3)
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])


def _hull(axes: Axes, points: Array, colour: str, label: str | None) -> None:
    """A mesh as its points, which shows its form from any side; other solids as the hull of their box."""
    from scipy.spatial import ConvexHull

    if len(points) > 100:
        axes.plot(
            *points[:: max(1, len(points) // 6000)].T, ".", ms=1.2, color=colour, alpha=0.5, zorder=1, label=label
        )
        return
    hull = ConvexHull(points)
    axes.fill(*points[hull.vertices].T, color=colour, alpha=0.55, zorder=2, lw=0, label=label)


def _clearance(axes: Axes, plan: Plan) -> None:
    found = plan.clearance
    assert found is not None
    order = np.argsort(found.t)
    t, d = found.t[order], 1e3 * found.distance[order]
    axes.plot(t, d, color=TOOL, marker=".", ms=3)
    axes.fill_between(t, 0.0, d, color=SURFACE, alpha=0.25)
    axes.axhline(1e3 * plan.clearance_asked, color=CAP, lw=1.0, ls="--")
    asked = 1e3 * plan.clearance_asked
    axes.annotate(f"asked: {asked:g} mm", (t[-1], asked), color=CAP, fontsize=7, ha="right", va="bottom")
    axes.plot(found.at_t, 1e3 * found.minimum, "o", color=FORCE)
    text = f"{1e3 * found.minimum:.2f} mm: {found.nearest[0]}, {found.nearest[1]}"
    place = (found.at_t, 1e3 * found.minimum)
    axes.annotate(text, place, xytext=(6, 8), textcoords="offset points", fontsize=7, color=FORCE)
    axes.set(xlabel="time [s]", ylabel="clearance [mm]", xlim=(t[0], t[-1]), ylim=(0.0, None))
