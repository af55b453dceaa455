"""Penetration of the tool in the full simulation: into hard regions under violent motion, into soft walls by K."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, TypedDict

import numpy as np
from scipy.spatial.transform import Rotation

from palpate import _core, _guidance
from palpate.base.arrays import Array
from palpate.devices.certificate import certify_all
from palpate.devices.certificate.entry import entries, stiffness
from palpate.devices.certificate.guidance import entry as depth
from palpate.record.ticks import as_ticks
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate_lab.verify.conformance.specimens import BALL, SPECIMENS, TUBE

MAX_ENTRY = 0.1
"""Largest accepted penetration of a hard region [mm]."""
WITHIN = 0.05
"""Accepted relative error of the certified penetration, and of the certified stiffness [-]."""
GOES_IN = 3.0
"""Smallest penetration of the control runs, which have the same hand but no fixture [mm]."""
SEEDS, SECONDS = 8, 3.0  # hands per region, duration of a run [s]
HEIGHT = 0.02  # initial height of the tool above the region [m]
GAP = 0.004  # initial height of the tool above the soft wall [m]
BREATH, PERIOD = np.array([0.001, 0.0, 0.003]), 1.5  # amplitude and period of a breathing region [m], [s]
K, B = 400.0, 2.0  # stiffness and damping of the soft wall [N/m, N s/m]


@dataclass(frozen=True)
class Region:
    """A region that a hard fixture keeps the tool out of, or in."""

    specimen: str
    margin: float = 0.0
    """Width of the forbidden margin around the specimen [m]."""
    keep_in: bool = False
    """True if the tool must stay inside; it starts in the middle."""
    breathes: bool = False
    tilted: bool = False
    """Random orientation for every hand; the tool starts 5 mm above the region."""
    hands: int = SEEDS
    """Number of simulated hands."""

    def outside(self, p: Array) -> Array:
        """Signed distance (n,) [m] of points (n, 3) in the region's frame to the boundary, negative if forbidden."""
        d = SPECIMENS[self.specimen].distance(p)
        return -d if self.keep_in else d - self.margin

    def pose(self, start: Array, rng: np.random.Generator) -> Array:
        """Rest pose X_WG (4, 4) of the region for a tool that starts at ``start`` (3,) in W [m]."""
        X_WG, lift = np.eye(4), np.array([0.0, 0.0, 0.0 if self.keep_in else HEIGHT + self._top()])
        if self.tilted:
            X_WG[:3, :3] = Rotation.random(random_state=rng).as_matrix()
            lift = 0.005 * X_WG[:3, 2]
        X_WG[:3, 3] = start - lift
        return X_WG

    def shift(self, t: Array) -> Array:
        """Breathing displacement (n, 3) [m] at times t (n,) [s]."""
        return np.sin(2.0 * np.pi * t / PERIOD)[:, None] * (BREATH if self.breathes else np.zeros(3))

    def fixture(self, X_WG: Array, on: bool) -> _guidance.Fixture:
        """The core's hard fixture of this region at X_WG (4, 4)."""
        policy, role = _core.Policy(), _core.GuidanceRoleOptions()
        policy.hard, role.margin = True, self.margin
        waves = [_core.Wave(shift=BREATH, period=PERIOD)] if self.breathes else []
        frame = _core.MotionFrame(np.eye(4), _core.Motion(waves=waves))
        geometry = _guidance.PlacedGeometry(SPECIMENS[self.specimen].make(), X_WG, frame)
        return _guidance.Fixture(
            "region", geometry, "keep-in" if self.keep_in else "forbid", role, policy=policy, on=on
        )

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
    """Deepest penetration of a hard region over all ticks, from the region's own distance function [mm].

    A stiff hand jumps to another point every 60 to 200 ms, often inside the region. `held_share` is the fraction of
    time in which the fixture shifts its goal by more than 1 mm. A run without the fixture is the control.
    """
    rig, tested = _rig(), REGIONS[region]
    start = (rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0))[:3, 3]
    rng = np.random.default_rng([sum(map(ord, region)), seed])
    X_WG = tested.pose(start, rng)
    ticks = _aggressive_hand(rig, tested.fixture(X_WG, fixture), start, rng)
    deepest = -float(tested.outside((ticks["p_WT"] - tested.shift(ticks["t"]) - X_WG[:3, 3]) @ X_WG[:3, :3]).min())
    corrected = float((np.linalg.norm(ticks["p_correction_W"], axis=1) > 1e-3).mean())
    return {"entry_mm": 1e3 * max(deepest, 0.0), "held_share": corrected}


class HandRun(TypedDict):
    """Result of one hand at one region, with the fixture (1) or without (0)."""

    region: str
    hand: int
    fixture: int
    entry_mm: float
    held_share: float


class Hard(TypedDict):
    """Worst result of all hands at one hard region."""

    region: str
    hands: int
    entry_mm: float
    held_share: float
    entry_without_mm: float


def hard_rows(rows: list[HandRun]) -> list[Hard]:
    """One row per region with the worst result of all hands, from the rows of single runs."""
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
    """Measured and certified penetration of a soft wall under a given force of the hand [mm].

    The two values come from independent experiments. This one imposes the force: the hand's target is far below, and
    its grip slips at this force. The certificate (`palpate.devices.certificate.entry`) imposes positions and measures
    the stiffness as the slope of force over depth.
    """
    rig, wall = _pressed()
    o, arms = rig.options(), rig.arms
    stable_below, certified = _certified()
    hand, stability = o.hand, o.stability
    hand.grip_force_max = force
    stability.force_cap = 2.0 * force  # the cap must not limit the measured force
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
    """True if all rows are within their bounds, and every control run without a fixture enters its region."""
    return all(
        row["entry_mm"] <= MAX_ENTRY and row["held_share"] > 0.02 and row["entry_without_mm"] >= GOES_IN
        for row in hard_rows
    ) and all(
        abs(row["measured_mm"] / row["certified_mm"] - 1.0) <= WITHIN
        and abs(row["certified_N_per_m"] / row["K_N_per_m"] - 1.0) <= WITHIN
        for row in soft_rows
    )


def _scene(**more: Any) -> Scene:
    ball = {"sphere": {"radius": 0.01}, "pose": {"xyz": [0.0, 0.0, -0.05]}}
    return Scene.model_validate({"objects": [ball], "operator": {"path": [{"t": 0.0, "xyz": [0.0, 0.0, 0.0]}]}} | more)


def _rig() -> Rig:
    return build(_scene())


@cache
def _pressed() -> tuple[Rig, Array]:
    """A scene with a soft wall GAP below the tool's start, and the wall's position in W (3,) [m]."""
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
    """Largest stable stiffness of this wall, and its measured stiffness if certified as stable [N/m]."""
    rig, wall = _pressed()
    certificate = next(c for c in certify_all(rig.scene, rig=rig) if c.name == "fixture wall")
    measured = stiffness(entries(rig, K, B, wall), rig.options().mapping.force_scale)
    return certificate.k_max, measured if certificate.verdict == "stable" else np.nan


def _aggressive_hand(rig: Rig, region: _guidance.Fixture, start: Array, rng: np.random.Generator) -> Any:
    o, arms = rig.options(), rig.arms
    hand = o.hand
    hand.stiffness, hand.grip_force_max = 600.0, 60.0
    o.hand = hand
    times = np.concatenate([[0.0, 0.4], 0.4 + np.cumsum(rng.uniform(0.06, 0.2, 30))])
    places = start + rng.uniform([-0.03, -0.03, -0.06], [0.03, 0.03, 0.01], (len(times), 3))
    places[:2] = start
    path = _core.HandPath(times.tolist(), places)
    sim = _core.Simulation(o, arms.leader, arms.leader, arms.follower, _core.Snapshot([]), path)
    sim.set_fixtures(_guidance.Fixtures([region]))
    return as_ticks(sim.run(round(SECONDS * o.rate)))
