"""How far the tool gets in, in the whole simulation: into hard regions whatever the hand does, into soft ones by K."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate import _core
from palpate.certificate import certify_all
from palpate.conformance.specimens import SPECIMENS
from palpate.record.ticks import as_ticks
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene

Array = NDArray[np.float64]

MOST = 0.1
"""Into a hard forbidden region [mm]."""
WITHIN = 0.05
"""Of the certified entry into a soft one."""
GOES_IN = 3.0
"""What a region's control has to get in at least: the same hands without the fixture [mm]."""
REGIONS = ("plane", "sphere", "cylinder", "box", "tube", "mesh", "distance grid")
SEEDS, SECONDS = 8, 3.0
FORCES = (1.0, 2.0, 3.0)
"""With which a hand presses into a soft region [N]."""
HEIGHT = 0.02  # of the tool above the region's top at the start [m]
GAP = 0.004  # of the tool above the soft wall at the start [m]


def hard(region: str, seed: int, fixture: bool = True) -> dict[str, float]:
    """The deepest that a tool got into a forbidden region, judged by the region's own formula [mm], at every tick.

    A stiff hand goes to another place every 60 to 200 ms, many of them within the region; `held_share` of the time its
    goal is kept back by more than a millimetre. Without the fixture the same hand is the control: it goes in.
    """
    rig, specimen = _rig(), SPECIMENS[region]
    X_WT = rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0)
    X_WG = np.eye(4)
    X_WG[:3, 3] = X_WT[:3, 3] - [0.0, 0.0, HEIGHT + _top(region)]
    policy = _core.Policy()
    policy.hard = True
    geometry = _core.PlacedGeometry(specimen.make(), X_WG)
    forbids = _core.Fixture(region, geometry, "forbid", law="spring", policy=policy, on=fixture)
    ticks = _violent(rig, forbids, X_WT[:3, 3], np.random.default_rng([sum(map(ord, region)), seed]))
    deepest = max(-float(specimen.distance(ticks["p_WT"] - X_WG[:3, 3]).min()), 0.0)
    held = float((np.linalg.norm(ticks["p_correction_W"], axis=1) > 1e-3).mean())
    return {"entry_mm": 1e3 * deepest, "held_share": held}


def hard_rows(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """A row per region, of rows with `region`, `fixture` and what `hard` told: the worst of all hands."""
    out = []
    for region in REGIONS:
        on, off = ([r for r in rows if r["region"] == region and bool(r["fixture"]) == kind] for kind in (True, False))
        out.append({
            "geometry": region,
            "hands": len(on),
            "entry_mm": max(r["entry_mm"] for r in on),
            "held_share": float(np.mean([r["held_share"] for r in on])),
            "entry_without_mm": max(r["entry_mm"] for r in off),
        })  # fmt: skip
    return out


def soft(force: float, K: float = 400.0, B: float = 2.0) -> dict[str, float]:
    """Entry of the tool when a hand presses with a force, and what the stiffness that `certify` vouches for says [mm].

    The hand's own force is imposed: it wants to be far below, and its grip gives way at this force.
    """
    scene = _pressed(K, B)
    rig = build(scene)
    o, arms = rig.options(), rig.arms
    certified = next(one for one in certify_all(scene, rig=rig) if one.name == "fixture wall")
    hand, stability = o.hand, o.stability
    hand.grip_force_max = force
    stability.force_cap = 2.0 * force  # it is the stiffness that is measured, not the cap
    o.hand, o.stability, o.tremor = hand, stability, 0.0
    start = (arms.X_WB @ arms.follower.fk(arms.q_follower0))[:3, 3]
    wall = start - [0.0, 0.0, GAP]
    below = wall - [0.0, 0.0, 0.05 + o.mapping.scale * 2.0 * force / hand.stiffness]
    path = _core.HandPath([0.0, 0.4, 2.0, 4.0], np.array([start, wall, below, below]))
    sim = _core.Simulation(o, arms.leader, arms.leader, arms.follower, _core.Snapshot([]), path)
    sim.set_fixtures(rig.fixtures)
    ticks = as_ticks(sim.run(round(4.0 * o.rate)))[-round(0.5 * o.rate) :]
    return {
        "force_N": force,
        "stable_below_N_per_m": certified.k_max,
        "certified_mm": 1e3 * force / (o.mapping.force_scale * K) if certified.verdict == "stable" else np.nan,
        "measured_mm": 1e3 * float((wall[2] - ticks["p_WT"][:, 2]).mean()),
    }


def passed(hard_rows: list[dict[str, Any]], soft_rows: list[dict[str, float]]) -> bool:
    """Both as asked, and without the fixture the hand did go in."""
    return all(
        row["entry_mm"] <= MOST and row["held_share"] > 0.02 and row["entry_without_mm"] >= GOES_IN for row in hard_rows
    ) and all(abs(row["measured_mm"] / row["certified_mm"] - 1.0) <= WITHIN for row in soft_rows)


def _top(region: str) -> float:
    z = np.linspace(0.0, 0.05, 2001)
    over = SPECIMENS[region].distance(np.column_stack([0.0 * z, 0.0 * z, z]))
    return float(z[np.flatnonzero(over <= 0.0)[-1]]) if (over <= 0.0).any() else 0.0


def _scene(**more: Any) -> Scene:
    beside = {"sphere": {"radius": 0.01}, "pose": {"xyz": [0.0, 0.0, -0.05]}}
    return Scene.model_validate(
        {"objects": [beside], "operator": {"path": [{"t": 0.0, "xyz": [0.0, 0.0, 0.0]}]}} | more
    )


def _rig() -> Rig:
    return build(_scene())


def _pressed(K: float, B: float) -> Scene:
    """A soft wall GAP below the tool at the start, as a user writes it."""
    arms = _rig().arms
    at = (arms.X_WB @ arms.follower.fk(arms.q_follower0))[:3, 3] - [0.0, 0.0, GAP]
    wall = {
        "name": "wall",
        "role": "forbid",
        "geometry": {"plane": {}},
        "frame": {"pose": {"xyz": [float(v) for v in at]}},
        "law": {"stiffness": K, "damping": B},
    }
    return _scene(guidance=[wall])


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
    return as_ticks(sim.run(round(SECONDS * o.rate)))
