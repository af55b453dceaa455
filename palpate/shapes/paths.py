"""Prescribed tool paths over shapes with a closed form: approach, press, slide, leave."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.arrays import Array
from palpate.shapes.analytic import Shape

RATE = 1000.0  # [Hz]
APPROACH, PRESS, SLIDE, LEAVE = 2000, 1000, 14_000, 3000  # samples
CLEARANCE = 20e-3  # where the path begins and ends, above the first and last touched point [m]
SETTLE = 50  # samples at either end of the slide that are not steady


@dataclass(frozen=True)
class ToolPath:
    """A tool tip over a shape, sampled at ``RATE``."""

    tips: Array  #: (n, 3) [m]
    steady: slice  #: rows of the steady slide


def tool_path(shape: Shape, offset: float, speed: float, radius: float) -> ToolPath:
    """20,000 samples: come down on the shape, press, slide at constant speed, go.

    Args:
        shape: what to slide on, along its ``curve``.
        offset: signed distance of the tip during the slide; -2 mm is deep [m].
        speed: along the slide [m/s].
        radius: of the proxy sphere: pressing begins where it touches [m].
    """
    slide = _at_speed(shape, offset, speed)
    out = shape.distance(slide[[0, -1]])[1]
    approach = slide[0] + out[0] * np.linspace(CLEARANCE, radius - offset, APPROACH)[:, None]
    press = slide[0] + out[0] * np.linspace(radius - offset, 0.0, PRESS + 1)[:-1, None]
    leave = slide[-1] + out[1] * np.linspace(0.0, CLEARANCE, LEAVE)[:, None]
    start = APPROACH + PRESS
    return ToolPath(np.concatenate([approach, press, slide, leave]), slice(start + SETTLE, start + SLIDE - SETTLE))


def _at_speed(shape: Shape, offset: float, speed: float) -> Array:
    """The curve at equal distances of ``speed / RATE``."""
    way = speed / RATE * np.arange(SLIDE)
    turns = 1.0
    while True:  # as many turns as the way needs, finely sampled
        s = np.linspace(0.0, turns, int(20_000 * turns) + 1)
        length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(shape.curve(s, offset), axis=0), axis=1))])
        if length[-1] > way[-1]:
            return shape.curve(np.interp(way, length, s), offset)
        turns *= 2.0
