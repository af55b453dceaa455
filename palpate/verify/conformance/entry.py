"""How far the tool gets in, in the whole simulation: into hard regions whatever the hand does, into soft ones by K."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, TypedDict

import numpy as np
from scipy.spatial.transform import Rotation

from palpate import _core
from palpate.arrays import Array
from palpate.certificate import certify_all
from palpate.certificate.entry import entries, stiffness
from palpate.certificate.guidance import entry as depth
from palpate.record.ticks import as_ticks
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate.verify.conformance.specimens import BALL, SPECIMENS, TUBE

MOST = 0.1
"""Into a hard forbidden region [mm]."""
WITHIN = 0.05
"""Of the certified entry into a soft one; and of the certified stiffness from the one that was asked for."""
GOES_IN = 3.0
"""What a region's control has to get in at least: the same hands without the fixture [mm]."""
SEEDS, SECONDS = 8, 3.0
HEIGHT = 0.02  # of the tool above the region's top at the start [m]
GAP = 0.004  # of the tool above the soft wall at the start [m]
BREATH, PERIOD = np.array([0.001, 0.0, 0.003]), 1.5  # shift of what breathes [m], [s]
K, B = 400.0, 2.0  # of the soft wall [N/m, N s/m]


@dataclass(frozen=True)
class Region:
    """What hard fixtures keep the tool out of, or in."""

    specimen: str
    margin: float = 0.0
    """forbidden around it [m]."""
    keep_in: bool = False
    """the tool begins in its middle."""
    breathes: bool = False
    tilted: bool = False
    """any way, another for every hand; the tool begins 5 mm above it."""
    hands: int = SEEDS

    def outside(self, p: Array) -> Array:
        """How far places (n, 3) in its frame are from where the tool must not be, below zero there (n,) [m]."""
        d = SPECIMENS[self.specimen].distance(p)
        return -d if self.keep_in else d - self.margin

    def pose(self, start: Array, rng: np.random.Generator) -> Array:
        """(4, 4) where it is at rest, for a tool that begins at start (3,) in W [m]."""
        X_WG, lift = np.eye(4), np.array([0.0, 0.0, 0.0 if self.keep_in else HEIGHT + self._top()])
        if self.tilted:
            X_WG[:3, :3] = Rotation.random(random_state=rng).as_matrix()
            lift = 0.005 * X_WG[:3, 2]
        X_WG[:3, 3] = start - lift
        return X_WG

    def shift(self, t: Array) -> Array:
        """(n, 3) by which it has breathed at times (n,) [m]."""
        return np.sin(2.0 * np.pi * t / PERIOD)[:, None] * (BREATH if self.breathes else np.zeros(3))

    def fixture(self, X_WG: Array, on: bool) -> _core.Fixture:
        """For the core, hard."""
        policy, role = _core.Policy(), _core.GuidanceRoleOptions()
        policy.hard, role.margin = True, self.margin
        waves = [_core.Wave(shift=BREATH, period=PERIOD)] if self.breathes else []
        frame = _core.MotionFrame(np.eye(4), _core.Motion(waves=waves))
        geometry = _core.PlacedGeometry(SPECIMENS[self.specimen].make(), X_WG, frame)
        return _core.Fixture("region", geometry, "keep-in" if self.keep_in else "forbid", role, policy=policy, on=on)

    def _top(self) -> float:
        z = np.linspace(0.0, 0.05, 2001)
        over = self.outside(np.column_stack([0.0 * z, 0.0 * z, z]))
        return float(z[np.flatnonzero(over <= 0.0)[-1]]) if (over <= 0.0).any() else 0.0


#: By name.
REGIONS: dict[str, Region] = {
    "floor": Region("plane"),
    "floor that breathes": Region("plane", breathes=True),
    "planes of any tilt": Region("plane", tilted=True, hands=48),
    f"{1e3 * TUBE:g} mm around a line": Region("line without end", TUBE),
    f"{1e3 * TUBE:g} mm around a line, breathing": Region("line without end", TUBE, breathes=True),
    f"inside of a sphere of {1e2 * BALL:g} cm": Region("sphere", keep_in=True),
    **{name: Region(name) for name in ("sphere", "cylinder", "box", "tube", "mesh", "distance grid")},
}


def hard(region: str, seed: int, fixture: bool = True) -> dict[str, float]:
    """The deepest that a tool got where it must not be, judged by the region's own formula [mm], at every tick.

    A stiff hand goes to another place every 60 to 200 ms, many of them within the region; `held_share` of the time its
    goal is kept back by more than a millimetre. Without the fixture the same hand is the control: it goes in.
    """
    rig, asked = _rig(), REGIONS[region]
    start = (rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0))[:3, 3]
    rng = np.random.default_rng([sum(map(ord, region)), seed])
    X_WG = asked.pose(start, rng)
    ticks = _violent(rig, asked.fixture(X_WG, fixture), start, rng)
    deepest = -float(asked.outside((ticks["p_WT"] - asked.shift(ticks["t"]) - X_WG[:3, 3]) @ X_WG[:3, :3]).min())
    held = float((np.linalg.norm(ticks["p_correction_W"], axis=1) > 1e-3).mean())
    return {"entry_mm": 1e3 * max(deepest, 0.0), "held_share": held}


class Gone(TypedDict):
    """One hand at one region, with the fixture (1) or without (0)."""

    region: str
    hand: int
    fixture: int
    entry_mm: float
    held_share: float


class Hard(TypedDict):
    """The worst of all hands at one hard region."""

    region: str
    hands: int
    entry_mm: float
    held_share: float
    entry_without_mm: float


def hard_rows(rows: list[Gone]) -> list[Hard]:
    """A row per region, of rows with `region`, `fixture` and what `hard` told: the worst of all hands."""
    out: list[Hard] = []
    for region in REGIONS:
        on, off = ([r for r in rows if r["region"] == region and bool(r["fixture"]) == kind] for kind in (True, False))
        out.append({
            "region": region,
            "hands": len(on),
            "entry_mm": max(r["entry_mm"] for r in on),
            "held_share": float(np.mean([r["held_share"] for r in on])),
            "entry_without_mm": max(r["entry_mm"] for r in off),
        })  # fmt: skip
    return out


def soft(force: float) -> dict[str, float]:
    """How far a hand that presses with a force gets into a soft wall, and what the certificate says of it [mm].

    Two ways to one number. Here the force is imposed: the hand wants to be far below, and its grip gives way at this
    force. The certificate's hand goes to places and feels what it feels (`palpate.certificate.entry`): the slope of
    that over the depth is the stiffness of this fixture in this scene, as it was measured.
    """
    rig, wall = _pressed()
    o, arms = rig.options(), rig.arms
    stable_below, certified = _certified()
    hand, stability = o.hand, o.stability
    hand.grip_force_max = force
    stability.force_cap = 2.0 * force  # it is the stiffness that is measured, not the cap
    o.hand, o.stability, o.tremor = hand, stability, 0.0
    below = wall - [0.0, 0.0, 0.05 + o.mapping.scale * 2.0 * force / hand.stiffness]
    path = _core.HandPath([0.0, 0.4, 2.0, 4.0], np.array([wall - [0.0, 0.0, -GAP], wall, below, below]))
    sim = _core.Simulation(o, arms.leader, arms.leader, arms.follower, _core.Snapshot([]), path)
    sim.set_fixtures(rig.fixtures)
    ticks = as_ticks(sim.run(round(4.0 * o.rate)))[-round(0.5 * o.rate) :]
    return {
        "force_N": force,
        "K_N_per_m": K,
        "stable_below_N_per_m": stable_below,
        "certified_N_per_m": certified,
        "certified_mm": 1e3 * depth(force, certified, o.mapping.force_scale),
        "measured_mm": 1e3 * float((wall[2] - ticks["p_WT"][:, 2]).mean()),
    }


def passed(hard_rows: list[Hard], soft_rows: list[dict[str, float]]) -> bool:
    """Both as asked, and without the fixture the hand did go in."""
    return all(
        row["entry_mm"] <= MOST and row["held_share"] > 0.02 and row["entry_without_mm"] >= GOES_IN for row in hard_rows
    ) and all(
        abs(row["measured_mm"] / row["certified_mm"] - 1.0) <= WITHIN
        and abs(row["certified_N_per_m"] / row["K_N_per_m"] - 1.0) <= WITHIN
        for row in soft_rows
    )


def _scene(**more: Any) -> Scene:
    beside = {"sphere": {"radius": 0.01}, "pose": {"xyz": [0.0, 0.0, -0.05]}}
    return Scene.model_validate(
        {"objects": [beside], "operator": {"path": [{"t": 0.0, "xyz": [0.0, 0.0, 0.0]}]}} | more
    )


def _rig() -> Rig:
    return build(_scene())


@cache
def _pressed() -> tuple[Rig, Array]:
    """A soft wall GAP below the tool at the start, as a user writes it, and where it is (3,) [m]."""
    arms = _rig().arms
    at = (arms.X_WB @ arms.follower.fk(arms.q_follower0))[:3, 3] - [0.0, 0.0, GAP]
    wall = {
        "name": "wall",
        "role": "forbid",
        "geometry": {"plane": {}},
        "frame": {"pose": {"xyz": [float(v) for v in at]}},
        "law": {"stiffness": K, "damping": B},
    }
    return build(_scene(guidance=[wall])), at


@cache
def _certified() -> tuple[float, float]:
    """Of that wall: the largest stable stiffness, and the one that the certificate measures, if it is stable [N/m]."""
    rig, wall = _pressed()
    one = next(one for one in certify_all(rig.scene, rig=rig) if one.name == "fixture wall")
    measured = stiffness(entries(rig, K, B, wall), rig.options().mapping.force_scale)
    return one.k_max, measured if one.verdict == "stable" else np.nan


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
