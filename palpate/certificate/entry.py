"""How far a hand gets into a soft fixture: measured with a scene's arms, servo and hand, beside what K says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from palpate import _core
from palpate.arrays import Array
from palpate.certificate.guidance import FORCES, entry
from palpate.record.ticks import as_ticks
from palpate.scene.rig import Rig

_GAP = 0.004  # between the tool at the start and the wall [m]
_REST = 0.5  # [s] at the end, over which the mean is taken
_TIMES = np.array([0.0, 0.4, 1.4, 3.0])  # start, touch, pressed, end [s]


@dataclass(frozen=True)
class Entry:
    """One press."""

    force_N: float
    certified_mm: float
    """F / (force_scale K)."""
    measured_mm: float
    """At the tool, simulated; scaled from the force that was felt to this one."""
    cell_N: float
    """What the load cell in the simulated hand read."""
    found_mm: float
    """The tool's depth meanwhile."""


def entries(rig: Rig, K: float, B: float, at: Array | None = None) -> list[Entry]:
    """A hand presses the tool straight down into a soft wall of K [N/m], B [N s/m], with each of FORCES.

    The force cap is lifted above what is pressed with, and the arm's dry friction left out, as the certificate does: it
    is the stiffness that is measured.

    Args:
        rig: arms, servo and hand.
        K, B: of the wall, on the tool's side.
        at: (3,) place in W [m] on a level border of the rig's own fixtures, below the tool at the start: they are
            pressed themselves, as they are in the scene. Left out, a plane is put there in their stead.
    """
    return [_press(rig, K, B, force, at) for force in FORCES]


def stiffness(pressed: Sequence[Entry], force_scale: float) -> float:
    """What presses measured, on the tool's side [N/m]: how steeply the load cell's force rises with the tool's depth.

    The straight line of least squares: what gravity leaves is the same in each press, and does not count.
    """
    depth = [1e-3 * one.found_mm for one in pressed]
    return float(np.polyfit(depth, [one.cell_N for one in pressed], 1)[0]) / force_scale


def _press(rig: Rig, K: float, B: float, force: float, at: Array | None) -> Entry:
    o, arms = rig.options(), rig.arms
    start = (arms.X_WB @ arms.follower.fk(arms.q_follower0))[:3, 3]
    wall = start - [0.0, 0.0, _GAP] if at is None else at
    # The hand's own spring is stretched by the force; on the tool's side that is `scale` times as far.
    down = entry(force, K, o.mapping.force_scale) + o.mapping.scale * force / o.hand.stiffness
    way = [start, wall, wall - [0.0, 0.0, down], wall - [0.0, 0.0, down]]
    stability = o.stability
    stability.force_cap = 2.0 * force
    o.stability, o.tremor = stability, 0.0
    o.leader.coulomb = np.zeros(arms.leader.n)
    leader = arms.leader
    path = _core.HandPath(_TIMES.tolist(), np.array(way))
    simulation = _core.Simulation(o, leader, leader, arms.follower, _core.Snapshot([]), path)
    simulation.set_fixtures(_core.Fixtures([_wall(wall, K, B)]) if at is None else rig.fixtures)
    ticks = as_ticks(simulation.run(round(_TIMES[-1] * o.rate)))[-round(_REST * o.rate) :]
    felt = float(np.linalg.norm(ticks["F_H_L"].mean(axis=0)))
    found = float((wall[2] - ticks["p_WT"][:, 2]).mean())
    cell = float(np.linalg.norm(ticks["F_cell_L"].mean(axis=0)))
    return Entry(force, 1e3 * entry(force, K, o.mapping.force_scale), 1e3 * found * force / felt, cell, 1e3 * found)


def _wall(at: Array, K: float, B: float) -> _core.Fixture:
    X_WG = np.eye(4)
    X_WG[:3, 3] = at
    plane = _core.PlacedGeometry(_core.SurfaceGeometry(_core.Plane()), X_WG)
    law = _core.GuidanceLawOptions()
    law.K, law.B = K, B
    return _core.Fixture("wall", plane, "forbid", law="spring", law_options=law)
