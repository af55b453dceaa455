"""The picture of ``palpate study figure12``: solids in parallel projection, far triangles first."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from palpate.arm import Arm
from palpate.arm.shapes import Visual
from palpate.base.arrays import Array
from palpate.base.plotting.style import INK, SURFACE, Canvas, png
from palpate_lab.studies.figure12.work import DeepestTick

Solid = tuple[Array, tuple[float, float, float, float]]  # corners (n, 3, 3) in W [m], colour

RED, GREEN = "#d3222a", "#2a9d46"  # body and spatial, as in the paper
REACH = 0.07  # half width of a view of the instrument [m]
ARM_REACH = 0.17  # half width of a view of the master arm [m]
NEWTON = 0.06  # length of a force arrow [m/N]
DEFLECTION = 6.0  # magnification of the deflection arrow [-]
_LETTERS = "ABCDEFGH"
_SHORTEST = 5e-4  # shorter arrows would be all head [m]
_LIGHT = np.array([-0.4, 0.5, 0.77])
FROM_THE_SIDE = np.array([0.5, -0.75, 0.42])
"""Direction from which the instrument is seen."""


def save(moments: list[DeepestTick], folder: Path) -> list[Path]:
    """Draw the picture into ``folder``; returns the file."""
    file = folder / "figure12.png"
    png(lambda canvas: draw(moments, canvas), file)
    return [file]


def draw(moments: list[DeepestTick], canvas: Canvas) -> Figure:
    """Two rows of two pairs: the instrument in the mesh, and the master arm with the force on the hand."""
    rows = -(-len(moments) // 2)
    figure = Figure(figsize=(canvas.width, 2.75 * rows + 0.3), layout="constrained")
    panels = np.atleast_2d(figure.subplots(rows, 4))
    for i, (moment, (left, right)) in enumerate(zip(moments, panels.reshape(-1, 2), strict=False)):
        instrument(moment, left)
        _master(moment, right)
        for axes, letter in ((left, _LETTERS[2 * i]), (right, _LETTERS[2 * i + 1])):
            axes.set_title(f"{letter}  {axes.get_title(loc='left')}", loc="left", fontsize=8.5, color=INK)
    right.plot([], [], color=GREEN, lw=2.5, label="force on the hand in the master's base axes (spatial)")
    right.plot(
        [],
        [],
        color=RED,
        lw=2.5,
        label=f"the same in the handle's axes (body); on the tool: deflection, {DEFLECTION:g} times",
    )
    figure.legend(*right.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def instrument(moment: DeepestTick, axes: Axes, eye: Array = FROM_THE_SIDE) -> None:
    """Draw the instrument, its sphere and the deflection arrow at a tick, seen from the direction ``eye`` (3,)."""
    tick, setup = moment.tick, moment.setup
    p_WT = tick["p_WT"]
    solids = [(s.body.vertices @ s.X_WO[:3, :3].T + s.X_WO[:3, 3])[s.body.triangles] for s in setup.surfaces]
    sphere = trimesh.creation.icosphere(3, setup.scene.contact.radius)
    ball = (np.asarray(sphere.vertices) + p_WT)[sphere.faces]
    r, g, b = (int(SURFACE[i : i + 2], 16) / 255 for i in (1, 3, 5))
    shown: list[Solid] = [(s, (r, g, b, 1.0)) for s in solids]
    shown += arm_solids(setup.arms.follower, setup.arms.X_WB, tick["q_follower"], float(tick["jaw"]))
    R = view(eye)
    paint(axes, shown, p_WT, R, REACH)
    paint(axes, [(ball, (0.12, 0.44, 0.55, 0.28))], p_WT, R, REACH)
    _arrow(axes, np.zeros(3), DEFLECTION * (tick["p_WP"] - p_WT), R, RED)
    axes.set_title(f"{moment.mesh}, {tick['depth'] * 1e3:.1f} mm deep", loc="left", fontsize=8.5, color=INK)


def _master(moment: DeepestTick, axes: Axes) -> None:
    tick, setup = moment.tick, moment.setup
    X_WL, leader = setup.arms.X_WL, setup.arms.leader
    X_WH = X_WL @ leader.fk(tick["q"])
    R = view(X_WL[:3, :3] @ np.array([0.75, 0.6, 0.3]))
    paint(axes, arm_solids(leader, X_WL, tick["q"], 0.3), X_WH[:3, 3], R, ARM_REACH)
    for force, color in ((tick["F_H_L"], GREEN), (tick["F_H_H"], RED)):
        _arrow(axes, np.zeros(3), NEWTON * X_WL[:3, :3] @ force, R, color)
    axes.set_title(f"{np.linalg.norm(tick['F_H_L']):.2f} N", loc="left", fontsize=8.5, color=INK)


def view(eye: Array) -> Array:
    """Rotation (3, 3) with the rows right, up and towards the eye."""
    eye = eye / np.linalg.norm(eye)
    right = np.cross([0.0, 0.0, 1.0], eye)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(eye, right), eye])


def arm_solids(arm: Arm, X_WA: Array, q: Array, jaw: float) -> list[Solid]:
    """The links of an arm at joints q (n,) [rad, m] and a jaw angle [rad], with its base at X_WA (4, 4) [m]."""
    poses = arm.link_poses(q[: arm.n], jaw)  # a tick stores more joints than the arm has
    return [(_corners(v, X_WA @ poses[v.link] @ v.X_link_visual), v.colour) for v in arm.visuals]


def _corners(visual: Visual, X: Array) -> Array:
    if visual.shape == "box":
        solid = trimesh.creation.box(visual.size)
    elif visual.shape == "cylinder":
        solid = trimesh.creation.cylinder(visual.size[0], visual.size[1], sections=24)
    else:
        solid = trimesh.creation.icosphere(2, visual.size[0])
    return np.asarray((np.asarray(solid.vertices) @ X[:3, :3].T + X[:3, 3])[solid.faces])


def paint(axes: Axes, solids: list[Solid], centre: Array, R: Array, reach: float) -> None:
    """Paint triangles in parallel projection along the third row of R (3, 3), within `reach` [m] of `centre` (3,)."""
    corners = np.concatenate([(c - centre) @ R.T for c, _ in solids])
    colors = np.concatenate([np.tile(color, (len(c), 1)) for c, color in solids])
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    seen = (normal[:, 2] > 0) & (length > 0) & (np.abs(corners[..., :2]).min(axis=1) < reach).all(axis=1)
    corners, colors, normal = corners[seen], colors[seen], normal[seen] / length[seen][:, None]
    order = np.argsort(corners[..., 2].mean(axis=1))
    colors[:, :3] *= (0.72 + 0.28 * np.clip(normal @ _LIGHT, -1.0, 1.0))[:, None]
    edges = colors[order] if colors[:, 3].min() == 1.0 else "none"
    patch = PolyCollection(corners[order, :, :2], facecolors=colors[order], edgecolors=edges, lw=0.2)
    patch.set_rasterized(True)
    axes.add_collection(patch)
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), xticks=[], yticks=[], aspect="equal")
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _arrow(axes: Axes, start: Array, vector: Array, R: Array, color: str) -> None:
    a, b = (R @ start)[:2], (R @ (start + vector))[:2]
    if np.linalg.norm(b - a) < _SHORTEST:
        return
    style = {"arrowstyle": "-|>,head_width=0.28,head_length=0.5", "color": color, "lw": 2.5, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", tuple(b), tuple(a), arrowprops=style, zorder=5)
