"""Drawing elements of ``palpate study geometry``: ground, springs, arrows and outlines."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from palpate.base.arrays import Array
from palpate.base.plotting.style import SURFACE


def outline(half: Array, exponents: tuple[int, int, int], n: int = 200) -> Array:
    """The section y = 0 of an implicit surface, (n, 2) in x and z [m]."""
    t = np.linspace(0, 2 * np.pi, n)
    direction = np.stack([np.cos(t), np.sin(t)], axis=1)
    low, high = np.zeros(n), np.full(n, 2.0)
    for _ in range(50):
        middle = 0.5 * (low + high)
        beyond = ((middle[:, None] * direction) ** [exponents[0], exponents[2]]).sum(axis=1) > 1.0
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    return np.asarray(low[:, None] * direction * half[[0, 2]])


def ground(axes: Axes, line: Any) -> None:
    """Fill the solid on the right side of a polyline of faces, beyond the visible area."""
    line = np.asarray(line, dtype=float)
    far, first, last = 300.0, line[1] - line[0], line[-1] - line[-2]
    start, end = line[0] - far * first / np.linalg.norm(first), line[-1] + far * last / np.linalg.norm(last)
    right = end + far * np.array([last[1], -last[0]]) / np.linalg.norm(last)
    corners = np.vstack([start, line, end, right, [far, -far], [start[0], -far]])
    axes.add_patch(Polygon(corners, facecolor=SURFACE, alpha=0.45, edgecolor="none"))
    axes.plot(line[:, 0], line[:, 1], color="#b07a63", lw=1.4)


def spring(axes: Axes, start: Array, out: Array, length: float, color: str) -> None:
    """Draw a zigzag with a constant number of turns."""
    s = np.linspace(0, 1, 2 * 7 + 2)
    aside = np.where(np.arange(len(s)) % 2 == 1, 0.8, -0.8)
    aside[[0, 1, -2, -1]] = 0.0
    points = start + np.outer(s * length, out) + np.outer(aside, [-out[1], out[0]])
    axes.plot(points[:, 0], points[:, 1], color=color, lw=0.9)


def arrow(axes: Axes, start: Array, vector: Array, color: str, width: float = 1.4) -> None:
    """Draw an arrow from a point (2,) along a vector (2,)."""
    style = {
        "arrowstyle": "-|>",
        "color": color,
        "lw": width,
        "shrinkA": 0,
        "shrinkB": 0,
        "mutation_scale": 6 + 2 * width,
    }
    axes.annotate("", xy=tuple(np.asarray(start) + vector), xytext=tuple(start), arrowprops=style)


def plain(axes: Axes, xlim: tuple[float, float], ylim: tuple[float, float]) -> None:
    """Remove frame and ticks and set equal scales."""
    axes.set(xlim=xlim, ylim=ylim, aspect="equal", xticks=[], yticks=[])
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)
