"""Prescribed tool paths over shapes in closed form: approach, press, slide, leave."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.world.shapes.analytic import Shape

RATE = 1000.0  # [Hz]
APPROACH, PRESS, SLIDE, LEAVE = 2000, 1000, 14_000, 3000  # samples
CLEARANCE = 20e-3  # height of the start and the end of the path above the surface [m]
SETTLE = 50  # samples at either end of the slide that do not count as steady


@dataclass(frozen=True)
class ToolPath:
    """A tool tip over a shape, sampled at ``RATE``."""

    tips: Array  #: (n, 3) [m]
    steady: slice  #: rows of the steady part of the slide


def tool_path(shape: Shape, offset: float, speed: float, radius: float) -> ToolPath:
    """Path of 20,000 samples: approach the shape, press, slide at constant speed, leave.

    Args:
        shape: the tool slides along its ``curve``.
        offset: signed distance of the tip during the slide; -2 mm is deep [m].
        speed: speed along the slide [m/s].
        radius: radius of the proxy sphere, which touches the shape when pressing begins [m].
    """
    slide = _at_speed(shape, offset, speed)
    normal = shape.distance(slide[[0, -1]])[1]
    approach = slide[0] + normal[0] * np.linspace(CLEARANCE, radius - offset, APPROACH)[:, None]
    press = slide[0] + normal[0] * np.linspace(radius - offset, 0.0, PRESS + 1)[:-1, None]
    leave = slide[-1] + normal[1] * np.linspace(0.0, CLEARANCE, LEAVE)[:, None]
    start = APPROACH + PRESS
    return ToolPath(np.concatenate([approach, press, slide, leave]), slice(start + SETTLE, start + SLIDE - SETTLE))


def _at_speed(shape: Shape, offset: float, speed: float) -> Array:
    """Points of the curve at equal arc lengths of ``speed / RATE``."""
    arc = speed / RATE * np.arange(SLIDE)
    turns = 1.0
    while True:  # double the number of turns until the curve is long enough
        s = np.linspace(0.0, turns, int(20_000 * turns) + 1)
        length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(shape.curve(s, offset), axis=0), axis=1))])
        if length[-1] > arc[-1]:
            return shape.curve(np.interp(arc, length, s), offset)
        turns *= 2.0
