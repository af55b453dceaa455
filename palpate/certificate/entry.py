"""How far a hand gets into a soft fixture: measured with a scene's arms, servo and hand, beside what K says."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate import _core
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


def entries(rig: Rig, K: float, B: float) -> list[Entry]:
    """A hand presses the tool straight down into a soft wall of K [N/m], B [N s/m], with each of FORCES.

    The force cap is lifted above what is pressed with: it is the stiffness that is measured.
    """
    return [_press(rig, K, B, force) for force in FORCES]


def _press(rig: Rig, K: float, B: float, force: float) -> Entry:
    o, arms = rig.options(), rig.arms
    start = (arms.X_WB @ arms.follower.fk(arms.q_follower0))[:3, 3]
    wall = start - [0.0, 0.0, _GAP]
    # The hand's own spring is stretched by the force; on the tool's side that is `scale` times as far.
    down = entry(force, K, o.mapping.force_scale) + o.mapping.scale * force / o.hand.stiffness
    way = [start, wall, wall - [0.0, 0.0, down], wall - [0.0, 0.0, down]]
    stability = o.stability
    stability.force_cap = 2.0 * force
    o.stability, o.tremor = stability, 0.0
    leader = arms.leader
    path = _core.HandPath(_TIMES.tolist(), np.array(way))
    simulation = _core.Simulation(o, leader, leader, arms.follower, _core.Snapshot([]), path)
    simulation.set_fixtures(_core.Fixtures([_wall(wall, K, B)]))
    ticks = as_ticks(simulation.run(round(_TIMES[-1] * o.rate)))[-round(_REST * o.rate) :]
    felt = float(np.linalg.norm(ticks["F_H_L"].mean(axis=0)))
    found = float((wall[2] - ticks["p_WT"][:, 2]).mean())
    return Entry(force, 1e3 * entry(force, K, o.mapping.force_scale), 1e3 * found * force / felt)


def _wall(at: np.typing.NDArray[np.float64], K: float, B: float) -> _core.Fixture:
    X_WG = np.eye(4)
    X_WG[:3, 3] = at
    plane = _core.PlacedGeometry(_core.SurfaceGeometry(_core.Plane()), X_WG)
    law = _core.GuidanceLawOptions()
    law.K, law.B = K, B
    return _core.Fixture("wall", plane, "forbid", law="spring", law_options=law)
