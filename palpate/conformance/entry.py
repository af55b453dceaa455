"""How far the tool gets in, in the whole simulation: into hard regions whatever the hand does, into soft ones by K."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate import _core
from palpate.certificate.entry import entries
from palpate.conformance.specimens import SPECIMENS
from palpate.record.ticks import as_ticks
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene

Array = NDArray[np.float64]

MOST = 0.1
"""Into a hard forbidden region [mm]."""
WITHIN = 0.05
"""Of the certified entry into a soft one."""
REGIONS = ("plane", "sphere", "cylinder", "box", "tube", "mesh", "distance grid")
SEEDS, SECONDS = 2, 3.0
HEIGHT = 0.02  # of the tool above the region's top at the start [m]


def hard(seed: int = 0) -> list[dict[str, Any]]:
    """The deepest that a tool got into a hard forbidden region of each kind, judged by its own formula [mm].

    A stiff hand goes to another place every 60 to 200 ms, many of them within the region; `held_share` of the time its
    goal is kept back by more than a millimetre.
    """
    rig = _rig()
    return [_worst(rig, name, seed) for name in REGIONS]


def soft(K: float = 400.0, B: float = 2.0) -> list[dict[str, float]]:
    """Entry of the tool at 1, 2, 3 N of hand force, and what the certified stiffness says [mm]."""
    told = entries(_rig(), K, B)
    return [{"force_N": e.force_N, "certified_mm": e.certified_mm, "measured_mm": e.measured_mm} for e in told]


def passed(hard_rows: list[dict[str, Any]], soft_rows: list[dict[str, float]]) -> bool:
    """Both as asked, and the hand did go in."""
    return all(row["entry_mm"] <= MOST and row["held_share"] > 0.02 for row in hard_rows) and all(
        abs(row["measured_mm"] / row["certified_mm"] - 1.0) <= WITHIN for row in soft_rows
    )


def _rig() -> Rig:
    beside = {"sphere": {"radius": 0.01}, "pose": {"xyz": [0.0, 0.0, -0.05]}}
    return build(
        Scene.model_validate({"objects": [beside], "operator": {"path": [{"t": 0.0, "xyz": [0.0, 0.0, 0.0]}]}})
    )


def _worst(rig: Rig, name: str, seed: int) -> dict[str, Any]:
    specimen = SPECIMENS[name]
    X_WT = rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0)
    z = np.linspace(0.0, 0.05, 2001)
    over = specimen.distance(np.column_stack([0.0 * z, 0.0 * z, z]))
    top = float(z[np.flatnonzero(over <= 0.0)[-1]]) if (over <= 0.0).any() else 0.0
    X_WG = np.eye(4)
    X_WG[:3, 3] = X_WT[:3, 3] - [0.0, 0.0, HEIGHT + top]
    policy = _core.Policy()
    policy.hard = True
    geometry = _core.PlacedGeometry(specimen.make(), X_WG)
    region = _core.Fixture(name, geometry, "forbid", law="spring", policy=policy)
    deepest, held = 0.0, []
    for i in range(SEEDS):
        ticks = _violent(rig, region, X_WT[:3, 3], np.random.default_rng([seed, i]))
        deepest = max(deepest, -float(specimen.distance(ticks["p_WT"] - X_WG[:3, 3]).min()))
        held.append(float((np.linalg.norm(ticks["p_correction_W"], axis=1) > 1e-3).mean()))
    return {"geometry": name, "entry_mm": 1e3 * deepest, "held_share": float(np.mean(held))}


def _violent(rig: Rig, region: _core.Fixture, start: Array, rng: np.random.Generator) -> Any:
    o, arms = rig.options(), rig.arms
    hand = o.hand
    hand.stiffness, hand.grip_force_max = 600.0, 60.0
    o.hand = hand
    times = np.concatenate([[0.0, 0.4], 0.4 + np.cumsum(rng.uniform(0.06, 0.2, 30))])
    places = start + rng.uniform([-0.03, -0.03, -0.06], [0.03, 0.03, 0.01], (len(times), 3))
    places[:2] = start
    path = _core.HandPath(times.tolist(), places)
    sim = _core.Simulation(o, arms.leader, arms.leader, arms.follower, _core.Snapshot([]), path)
    sim.set_fixtures(_core.Fixtures([region]))
    return as_ticks(sim.run(round(SECONDS * o.rate)))[::2]
