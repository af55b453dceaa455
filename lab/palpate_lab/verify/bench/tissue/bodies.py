"""The bodies that the figures press, and how they press them.

Each figure takes a `Lab`. A test replaces its parts by wrong ones, for example a modulus 1.1 times as large, and shows
that the figure's judgement fails then.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.scene.contact import Rendered, render
from palpate.world.tissue import Tissue
from palpate.world.tissue.blocks import block

YOUNG, POISSON = 5000.0, 0.45
TICK = 1e-3  # [s]
RESTLESS = 5e-3
"""Peak to peak of a force above which a contact at rest chatters [N]."""
PRONY = ((0.3, 0.02), (0.2, 0.2), (0.1, 2.0))


@dataclass(frozen=True)
class Lab:
    """What makes the bodies and what touches them."""

    make: Callable[..., Tissue] = Tissue
    touch: Callable[..., Rendered] = render

    def layer(self, thickness: float, cell: float, half: float, **material: Any) -> Tissue:
        """A layer between z = -thickness and 0, bonded to the ground and free at its sides [m]."""
        nodes, tets = layer_mesh(thickness, cell, half)
        material = {"young": YOUNG, "poisson": POISSON, **material}
        return self.make((nodes, tets), fixed=nodes[:, 2] < -thickness + 1e-9, **material)

    def force(self, soft: Tissue, radius: float, tips: Array, **how: Any) -> Array:
        """Normal force (n,) on a sphere whose centre follows ``tips`` (n, 3) [N]."""
        force: Array = self.touch(soft, tips, radius=radius, **how).force[:, 2]
        return force

    def steady(self, soft: Tissue, radius: float, depth: float, at: Sequence[float] = (0.0, 0.0)) -> float:
        """Force on a sphere at rest at ``depth`` [N]; NaN, which meets no limit, if the force does not come to rest."""
        last = self.force(soft, radius, pressed(radius, depth, at))[-60:]
        force = float(last[-20:].mean())
        return force if chatter(last[:, None]) <= min(RESTLESS, 0.02 * abs(force)) else math.nan


def chatter(force: Array) -> float:
    """Largest peak to peak of the components of a force (n, 3) at rest [N], without a drift up to the third order."""
    t = np.linspace(-1.0, 1.0, len(force))
    drift = np.polynomial.polynomial.polyvander(t, 3)
    rest = force - drift @ np.linalg.lstsq(drift, force, rcond=None)[0]
    return float(np.ptp(rest, axis=0).max())


def layer_mesh(thickness: float, cell: float, half: float) -> tuple[Array, npt.NDArray[np.int32]]:
    """Nodes and tetrahedra of a layer around the origin, with its top at z = 0 [m]."""
    across, down = max(2, round(2 * half / cell)), max(2, round(thickness / cell))
    nodes, tets = block((across, across, down), (across * cell, across * cell, thickness))
    return nodes - [across * cell / 2, across * cell / 2, thickness], tets


def pressed(radius: float, depth: float, at: Sequence[float], down: float = 0.3, hold: float = 0.2) -> Array:
    """Positions (n, 3) of a sphere's centre that is pressed into the plane z = 0 and rests there [m]."""
    s = np.linspace(0.0, 1.0, round(down / TICK))
    rise = np.concatenate([s * s * (3.0 - 2.0 * s), np.ones(round(hold / TICK))])
    return placed(at, radius + 0.5e-3 - (depth + 0.5e-3) * rise)


def placed(at: Sequence[float], z: Array) -> Array:
    """Positions (n, 3) above a point (x, y), at heights (n,) [m]."""
    return np.stack([np.full_like(z, at[0]), np.full_like(z, at[1]), z], axis=1)
