"""Penetration of a hand into a soft fixture: simulated with a scene's arms, servo and hand, and predicted from K."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.devices.certificate.guidance import FORCES, entry
from palpate.record.ticks import as_ticks
from palpate.scene.rig import Rig

if TYPE_CHECKING:
    from palpate import _guidance

_GAP = 0.004  # between the tool at the start and the wall [m]
_REST = 0.5  # averaging time at the end [s]
_TIMES = np.array([0.0, 0.4, 1.4, 3.0])  # times of start, contact, full press and end [s]


@dataclass(frozen=True)
class Entry:
    """Result of one press."""

    force_N: float
    """Commanded force of the hand."""
    certified_mm: float
    """Predicted depth F / (force_scale K)."""
    measured_mm: float
    """Simulated depth of the tool, scaled linearly from the rendered force to ``force_N``."""
    cell_N: float
    """Mean force on the load cell in the simulated hand."""
    found_mm: float
    """Mean simulated depth of the tool, unscaled."""


def entries(rig: Rig, K: float, B: float, at: Array | None = None) -> list[Entry]:
    """Press the tool straight down into a soft wall with each of FORCES.

    The force cap is raised above the pressing force and the arm's dry friction is left out, as in the certificate, so
    that the result depends on the stiffness alone.

    Args:
        rig: arms, servo and hand.
        K, B: stiffness [N/m] and damping [N s/m] of the wall on the tool's side.
        at: point in W (3,) [m] on a horizontal boundary of the rig's own fixtures, below the tool's start. The rig's
            fixtures are then pressed. Without it, they are replaced by a horizontal plane below the tool.
    """
    return [_press(rig, K, B, force, at) for force in FORCES]


def stiffness(pressed: Sequence[Entry], force_scale: float) -> float:
    """Measured stiffness on the tool's side [N/m]: slope of the load cell's force over the tool's depth.

    The slope of a least-squares line does not depend on the residual gravity force, which is the same in each press.
    """
    depth = [1e-3 * press.found_mm for press in pressed]
    return float(np.polyfit(depth, [press.cell_N for press in pressed], 1)[0]) / force_scale


def _press(rig: Rig, K: float, B: float, force: float, at: Array | None) -> Entry:
    from palpate import _guidance

    o, arms = rig.options(), rig.arms
    start = (arms.X_WB @ arms.follower.fk(arms.q_follower0))[:3, 3]
    wall = start - [0.0, 0.0, _GAP] if at is None else at
    # The force also stretches the hand's own spring; its extension is multiplied by `scale` on the tool's side.
    down = entry(force, K, o.mapping.force_scale) + o.mapping.scale * force / o.hand.stiffness
    positions = [start, wall, wall - [0.0, 0.0, down], wall - [0.0, 0.0, down]]
    stability = o.stability
    stability.force_cap = 2.0 * force
    o.stability, o.tremor = stability, 0.0
    o.leader.coulomb = np.zeros(arms.leader.n)
    leader = arms.leader
    path = _core.HandPath(_TIMES.tolist(), np.array(positions))
    simulation = _core.Simulation(o, leader, leader, arms.follower, _core.Snapshot([]), path)
    simulation.set_fixtures(_guidance.Fixtures([_wall(wall, K, B)]) if at is None else rig.fixtures)
    ticks = as_ticks(simulation.run(round(_TIMES[-1] * o.rate)))[-round(_REST * o.rate) :]
    rendered = float(np.linalg.norm(ticks["F_H_L"].mean(axis=0)))
    depth = float((wall[2] - ticks["p_WT"][:, 2]).mean())
    cell = float(np.linalg.norm(ticks["F_cell_L"].mean(axis=0)))
    return Entry(force, 1e3 * entry(force, K, o.mapping.force_scale), 1e3 * depth * force / rendered, cell, 1e3 * depth)


def _wall(at: Array, K: float, B: float) -> _guidance.Fixture:
    """A horizontal plane through the point ``at`` (3,) in W [m]."""
    from palpate import _guidance

    X_WG = np.eye(4)
    X_WG[:3, 3] = at
    plane = _guidance.PlacedGeometry(_guidance.SurfaceGeometry(_core.Plane()), X_WG)
    law = _core.GuidanceLawOptions()
    law.K, law.B = K, B
    return _guidance.Fixture("wall", plane, "forbid", law="spring", law_options=law)
