"""The picture of ``palpate study collisions``: Fig 5 of the paper, drawn from computed contacts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from palpate.base.arrays import Array
from palpate.base.plotting.style import FORCE, SURFACE, TOOL, Canvas, png
from palpate.planning.robot import Robot
from palpate.planning.world import World
from palpate_lab.studies.collisions.work import Contact, motion

_BONE = "#cfc8b8"
_VIEWS = (((0, 2), "seen from the feet"), ((0, 1), "seen from above"))
_POSES = 5


def draw(folder: Path, robot: Robot, world: World, found: list[Contact], steps: int) -> list[Path]:
    """Write the picture; returns its file."""
    file = folder / "collisions.png"
    png(lambda canvas: figure(canvas, robot, world, found, steps), file)
    return [file]


def figure(canvas: Canvas, robot: Robot, world: World, found: list[Contact], steps: int) -> Figure:
    """Both views of the moving instrument, with its contact points."""
    drawn = Figure(figsize=(canvas.width, 0.45 * canvas.width), layout="constrained")
    touching = sorted({c.step for c in found}) or [0]
    picks = [touching[int(k)] for k in np.linspace(0, len(touching) - 1, _POSES)]
    rows = motion(robot, steps)[picks]
    for axes, (pair, title) in zip(drawn.subplots(1, 2), _VIEWS, strict=True):
        for obstacle, colour in zip(world.obstacles, (SURFACE, _BONE), strict=True):
            v = np.asarray(obstacle.solid.coal.vertices()) @ obstacle.X_WO[:3, :3].T + obstacle.X_WO[:3, 3]
            axes.plot(*(1e3 * v[:: max(1, len(v) // 9000)][:, pair].T), ".", ms=1.0, color=colour, label=obstacle.name)
        _instruments(axes, robot, rows, list(pair))
        points = np.concatenate([c.points_W for c in found if c.step in picks] or [np.zeros((0, 3))])
        axes.plot(*(1e3 * points[:, pair].T), "o", ms=2.2, color=FORCE, label="contact points", zorder=5)
        axes.set(aspect="equal", title=title, xlabel=f"{'xyz'[pair[0]]} [mm]", ylabel=f"{'xyz'[pair[1]]} [mm]",
                 xlim=(-150, 150), ylim=(-120, 120))  # fmt: skip
        axes.legend(loc="upper right", fontsize=6.5, markerscale=3)
    return drawn


def _instruments(axes: Axes, robot: Robot, rows: Array, pair: list[int]) -> None:
    for ends in robot.placed(rows).ends_W:
        for body, (a, b) in zip(robot.bodies, ends, strict=True):
            if body.link in ("shaft", "wrist", "tool", "jaw_1", "jaw_2"):
                axes.plot(*(1e3 * np.stack([a, b])[:, pair].T), color=TOOL, lw=2.0, alpha=0.7, zorder=4)
