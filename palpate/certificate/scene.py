"""The certificate of a scene: its arms in the poses of its path, every direction of touch, its hand and others."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from palpate import _core
from palpate.arrays import Array
from palpate.certificate import classical, words
from palpate.certificate.arms import Held, felt, whole_servo_periods
from palpate.certificate.certificate import SURE, Case, Certificate, advice, judge
from palpate.certificate.guidance import NO_OBJECT, at_once, pulled, reach
from palpate.errors import PalpateError, PalpateWarning
from palpate.hands import PRESETS
from palpate.record.ticks import as_ticks
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene

_SHARES = (0.3, 0.6)  # of the operator's path, where the leader is looked at beside the start
_SETTLE = 1.0  # [s]
_TILTS = (0.4, 0.2)  # about the worst direction so far [rad]
#: Axes, and the middles between them, in the leader's base; a direction and its opposite are the same.
_DIRECTIONS = [
    np.array(n) / np.linalg.norm(n)
    for n in ((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1), (0, 1, 1), (0, 1, -1))
]


@dataclass(frozen=True)
class Touched:
    """Something of a scene that can be touched, with one stiffness."""

    name: str
    index: int
    """Of the object; of a fixture below zero."""
    K: float
    """Along its stiffest axis [N/m]."""
    B: float
    """Along its least damped axis [N s/m]."""
    B_most: float
    """Along its most damped axis, which may be too much [N s/m]."""


def touched(rig: Rig) -> list[Touched]:
    """Objects, the regions in them that feel otherwise, and fixtures of guidance: what each certificate is of."""
    scene, found = rig.scene, []
    for i, thing in enumerate(scene.objects):
        found.append(Touched(thing.name, i, max(thing.stiffness), min(thing.damping), max(thing.damping)))
        for region in thing.regions:
            K, B = region.stiffness or thing.stiffness, region.damping or thing.damping
            found.append(Touched(f"{thing.name}, {region.name}", i, max(K), min(B), max(B)))
    return found + [Touched(f.name, NO_OBJECT, f.K, f.B, f.B) for f in pulled(rig.fixtures.list())]


def warn_outside(rig: Rig) -> None:
    """One warning per object (or region) of a scene that is not certified to be stable; none where there is no
    certificate for its control law or its source of the force."""
    try:
        found = certificates(rig.scene, None, None, rig)
    except PalpateError:
        return
    for thing, one in zip(touched(rig), found, strict=True):
        if one.verdict != "stable":
            where = rig.scene.where(*(("objects", thing.index) if thing.index >= 0 else ("guidance",)))
            warnings.warn(PalpateWarning(f"{one.name}: {one.reason}", where=where), stacklevel=2)


def worst_of(certificates: Sequence[Certificate]) -> Certificate:
    """The one nearest to its limit, or furthest beyond it."""
    return min(certificates, key=lambda c: 0.0 if c.k_max <= 0.0 else c.k_max / c.K if c.K else np.inf)


def certificates(scene: Scene, K: float | None, B: float | None, rig: Rig | None) -> list[Certificate]:
    """As `palpate.certificate.certify_all`."""
    with threadpool_limits(1):  # the matrices are small: threads would only wait for each other
        return _certificates(scene, K, B, rig)


def _certificates(scene: Scene, K: float | None, B: float | None, rig: Rig | None) -> list[Certificate]:
    _require_known(scene)
    rig = rig or build(scene)
    objects = _Arms(rig)
    fixtures = objects.asking(fixture=True)
    objects = objects.asking(beside=at_once(rig.fixtures.list()))
    found = []
    for thing in touched(rig):
        arms = objects if thing.index >= 0 else fixtures
        dampings = {thing.B, thing.B_most} if B is None else {B}
        each = [arms.certificate(thing, thing.K if K is None else K, b) for b in sorted(dampings)]
        found.append(min(each, key=lambda one: one.k_max))
    return found


def _require_known(scene: Scene) -> None:
    shaped = scene.torque.law == "impedance" and scene.torque.shape_inertia
    if scene.torque.law == "admittance" or shaped:
        raise PalpateError(
            f"there is no certificate for torque.law {scene.torque.law}{' with shape_inertia' if shaped else ''}",
            where=scene.where("torque"),
            why="its loop goes through the load cell, which the analysis does not know",
            mend="use law stiffness or impedance, or try the scene with a simulated hand",
        )
    if scene.force.source != "contact":
        raise PalpateError(
            f"there is no certificate for force.source {scene.force.source}",
            where=scene.where("force"),
            why="its loop goes through the follower's drives and its observer, which the analysis does not know",
            mend="use source contact, or try the scene with a simulated hand",
        )


class _Arms:
    """The leader of a scene in its poses, and what was found for a damping and a kind of surface."""

    def __init__(self, rig: Rig) -> None:
        self.rig, self.o = rig, rig.options()
        self.held = {told: Held(rig.arms.leader, q, self.o, self.o.hand) for told, q in _poses(rig)}
        self._known: dict[tuple[float, int | None], tuple[str, Array]] = {}
        self.fixture = False

    def asking(self, fixture: bool = False, beside: float = 0.0) -> _Arms:
        """The same arms and poses, pushed by a fixture of guidance, or by a surface with fixtures beside it."""
        other = copy(self)
        other.held = {told: replace(held, fixture=fixture, beside=beside) for told, held in self.held.items()}
        other._known, other.fixture = {}, fixture
        return other

    def certificate(self, thing: Touched, K: float, B: float) -> Certificate:
        pose, n = self._worst(thing, B)
        held = self.held[pose]
        case = Case(f"pressing {_along(self.rig.arms.X_WL[:3, :3] @ n)} {pose}", held.loop(n))
        k_max, w = case.loop.K_max(B)
        verdict, margin = judge(K, k_max, k_max)
        servo = 0.0 if self.fixture else _servo_lag(self.o)
        facts = words.LoopFacts(whole_servo_periods(self.o), self.o.rate, B, w / (2 * np.pi), case.told,
                                f", {1e3 * servo:.3g} ms of the follower's servo" if servo > 0.0 else "")  # fmt: skip
        told = words.reason(
            K, k_max, verdict, facts, [*advice((case,), B), *self._faster(held, n, B)] if verdict != "stable" else []
        )
        if verdict != "stable" and self.rig.scene.stability.passivity != "off":
            told += f"; the passivity layer ({self.rig.scene.stability.passivity}) will take force to hold it"
        if verdict != "stable" and self.fixture and 0.0 < k_max < np.inf:
            told += f"; softly it can hold so much: {reach(SURE * k_max, self.o.mapping.force_scale)}"
            told += "; with hard: true the tool stays out"
        gain = felt(self.o)
        passive = classical.colgate_brown(self.o.hand.damping, gain * B, 1 / self.o.rate, facts.delay + servo)
        bounds = {"colgate_brown_with_hand": passive / gain if gain > 0.0 else np.inf}
        return Certificate(B, k_max, k_max, w / (2 * np.pi), case.told, K, verdict, margin, told, bounds,
                           self._hands(held, n, B), (case,), thing.name)  # fmt: skip

    def _worst(self, thing: Touched, B: float) -> tuple[str, Array]:
        """Pose and direction, in the leader's base, in which the least stiffness is stable."""
        plane = thing.index >= 0 and self.rig.scene.objects[thing.index].plane is not None
        key = (B, thing.index if plane else None)
        if key not in self._known:
            R_LW = self.rig.arms.X_WL[:3, :3].T
            only = [R_LW @ self.rig.scene.objects[thing.index].pose.matrix()[:3, 2]] if plane else None
            tried = [
                (held.loop(n).K_max(B)[0], i, pose, n)
                for i, (pose, held) in enumerate(self.held.items())
                for n in (only or _DIRECTIONS)
            ]
            k, _, pose, n = min(tried, key=lambda one: one[:2])
            self._known[key] = (pose, n if only else self._steepest(self.held[pose], n, k, B))
        return self._known[key]

    @staticmethod
    def _steepest(held: Held, n: Array, k: float, B: float) -> Array:
        """A direction near n that is worse still."""
        for tilt in _TILTS:
            u = np.cross(n, np.eye(3)[int(np.argmin(np.abs(n)))])
            u /= np.linalg.norm(u)
            around = [np.cos(a) * u + np.sin(a) * np.cross(n, u) for a in np.linspace(0, 2 * np.pi, 6, endpoint=False)]
            for m in [np.cos(tilt) * n + np.sin(tilt) * side for side in around]:
                k_m = held.loop(m).K_max(B)[0]
                if k_m < k:
                    k, n = k_m, m
        return n

    @staticmethod
    def _hands(held: Held, n: Array, B: float) -> dict[str, float]:
        """Limit with each preset of `palpate.hands`, in the same pose and direction."""
        return {name: replace(held, hand=hand.options()).loop(n).K_max(B)[0] for name, hand in PRESETS.items()}

    def _faster(self, held: Held, n: Array, B: float) -> list[words.Advice]:
        if self.o.follower.bandwidth == 0.0 or self.fixture:
            return []
        o = self.rig.options()
        o.follower.bandwidth *= 2.0
        loop = replace(held, o=o).loop(n)
        return [(f"a follower's servo of {o.follower.bandwidth:g} Hz", lambda: loop.K_max(B)[0])]


def _servo_lag(o: _core.SimulationOptions) -> float:
    """Of the follower's joints behind a slow goal [s]."""
    return o.follower.damping_ratio / (np.pi * o.follower.bandwidth) if o.follower.bandwidth > 0.0 else 0.0


def _along(n: Array) -> str:
    """A direction in W, in words."""
    n = n * np.sign(n[np.argmax(np.abs(n))])
    return next((f"along {axis}" for axis, e in zip("xyz", np.eye(3), strict=True) if n @ e > 0.999),
                "along ({:.2f}, {:.2f}, {:.2f})".format(*n))  # fmt: skip


def _poses(rig: Rig) -> Iterator[tuple[str, Array]]:
    """Where the leader is at the start, and along the operator's path, in words and joints."""
    arms, path = rig.arms, rig.path
    yield "at the start", arms.q_leader0
    q0 = _settled(rig)
    X_LH, X_WT = arms.leader.fk(arms.q_leader0), arms.X_WB @ arms.follower.fk(arms.q_follower0)
    handle0 = X_LH[:3, 3].copy()
    last = path.period if path.period else float(path.times[-1])
    for share in _SHARES:
        i = int(np.argmin(np.abs(path.times - share * last)))
        X_LH[:3, 3] = handle0 + arms.X_WL[:3, :3].T @ (path.positions_W[i] - X_WT[:3, 3]) / rig.scene.mapping.scale
        q, _ = arms.leader.ik_nearest(X_LH, q0, restarts=0)
        yield f"at {path.times[i]:.2g} s of the path", q


def _settled(rig: Rig) -> Array:
    """Joints at the start once an MTM's joint-4 controller has opened the gimbal, without dry friction to stop it."""
    o, arms = rig.options(), rig.arms
    if o.torque.platform_gain == 0.0 or str(o.torque.mode).endswith("paper"):
        return arms.q_leader0
    o.leader.coulomb = np.zeros(arms.leader.n)
    model = arms.leader.with_scaled_masses(np.ones(arms.leader.n))
    rests = _core.HandPath([0.0], rig.path.positions_W[:1])
    simulation = _core.Simulation(o, arms.leader, model, arms.follower, rig.snapshot, rests)
    return np.asarray(as_ticks(simulation.run(round(_SETTLE * o.rate)))["q"][-1][: arms.leader.n])
