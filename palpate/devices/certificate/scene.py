"""The certificate of a scene: several poses along its path, several contact directions, its hand and the presets."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from threadpoolctl import threadpool_limits

from palpate import _core
from palpate.arm.hands import PRESETS
from palpate.base.arrays import Array
from palpate.base.errors import PalpateError, PalpateWarning
from palpate.devices.certificate import classical, words
from palpate.devices.certificate.arms import HeldLeader, felt, whole_servo_periods
from palpate.devices.certificate.certificate import SURE, Case, Certificate, Loop, advice, judge
from palpate.devices.certificate.coupled import CoupledLoop
from palpate.devices.certificate.guidance import entry_summary, total_stiffness
from palpate.devices.certificate.spheres import PlaneContact, plane_contacts, postures
from palpate.devices.certificate.touched import PATH_FRACTIONS, Touched, touched
from palpate.record.ticks import as_ticks
from palpate.scene import fixtures
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene

_SETTLE = 1.0  # simulated time for the gimbal to settle [s]
_TILTS = (0.4, 0.2)  # tilt angles of the search around the worst direction so far [rad]
_REPEATED = 4  # searches for the spheres that touch at the limit
#: The axes of the leader's base and the bisectors between them; opposite directions are equivalent.
_DIRECTIONS = [
    np.array(n) / np.linalg.norm(n)
    for n in ((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1), (0, 1, 1), (0, 1, -1))
]


def warn_outside(rig: Rig) -> None:
    """Warn once per object, region or fixture that is not certified as stable.

    No warning is raised if the analysis does not cover the scene's control law or force source.
    """
    try:
        found = certificates(rig.scene, None, None, rig)
    except PalpateError:
        return
    for surface, certificate in zip(touched(rig), found, strict=True):
        if certificate.verdict != "stable":
            where = rig.scene.where(*(("objects", surface.index) if surface.index >= 0 else ("guidance",)))
            warnings.warn(PalpateWarning(f"{certificate.name}: {certificate.reason}", where=where), stacklevel=2)


def worst_of(certificates: Sequence[Certificate]) -> Certificate:
    """The certificate with the smallest ratio of limit to stiffness."""
    return min(certificates, key=lambda c: 0.0 if c.k_max <= 0.0 else c.k_max / c.K if c.K else np.inf)


def certificates(scene: Scene, K: float | None, B: float | None, rig: Rig | None) -> list[Certificate]:
    """Implementation of `palpate.devices.certificate.certify_all`."""
    with threadpool_limits(1):  # the matrices are small, so threads cost more time than they save
        return _certificates(scene, K, B, rig)


def _certificates(scene: Scene, K: float | None, B: float | None, rig: Rig | None) -> list[Certificate]:
    _require_known(scene)
    rig = rig or build(scene)
    objects = _Arms(rig)
    through_fixtures = objects.variant(fixture=True)
    objects = objects.variant(parallel_stiffness=total_stiffness(fixtures.each(rig.fixtures)))
    found = []
    for surface in touched(rig):
        arms = objects if surface.index >= 0 else through_fixtures
        dampings = {surface.B, surface.B_most} if B is None else {B}
        each = [arms.certificate(surface, surface.K if K is None else K, b) for b in sorted(dampings)]
        found.append(min(each, key=lambda certificate: certificate.k_max))
    return found


def _require_known(scene: Scene) -> None:
    shaped = scene.torque.law == "impedance" and scene.torque.shape_inertia
    if scene.torque.law == "admittance" or shaped:
        raise PalpateError(
            f"there is no certificate for torque.law {scene.torque.law}{' with shape_inertia' if shaped else ''}",
            where=scene.where("torque"),
            why="its loop contains the load cell, which the analysis does not model",
            mend="use law stiffness or impedance, or try the scene with a simulated hand",
        )
    if scene.force.source != "contact":
        raise PalpateError(
            f"there is no certificate for force.source {scene.force.source}",
            where=scene.where("force"),
            why="its loop contains the follower's drives and force observer, which the analysis does not model",
            mend="use source contact, or try the scene with a simulated hand",
        )


@dataclass(frozen=True)
class _Press:
    """A leader whose tool presses a wall along n."""

    held: HeldLeader
    loop: Callable[[HeldLeader], Loop]
    """The loop of this press for this or a modified leader."""
    n: Array
    """(3,) in the leader's base."""
    description: str
    """Pose, and spheres, in words."""
    contacts: int = 1
    """Number of spheres."""


class _Arms:
    """The leader of a scene in several poses, with the worst pose and direction found so far by damping and surface."""

    def __init__(self, rig: Rig) -> None:
        self.rig, self.o = rig, rig.options()
        self.leaders = {pose: HeldLeader(rig.arms.leader, q, self.o, self.o.hand) for pose, q in _poses(rig)}
        self.tools = cache(lambda: postures(rig, PATH_FRACTIONS))  # variants share them; most scenes need none
        self._worst_cases: dict[tuple[float, int | None], tuple[str, Array]] = {}
        self.fixture = False

    def variant(self, fixture: bool = False, parallel_stiffness: float = 0.0) -> _Arms:
        """The same arms and poses, with the force rendered by a fixture, or by a surface with parallel fixtures."""
        other = copy(self)
        other.leaders = {
            pose: replace(leader, fixture=fixture, parallel_stiffness=parallel_stiffness)
            for pose, leader in self.leaders.items()
        }
        other._worst_cases, other.fixture = {}, fixture
        return other

    def certificate(self, surface: Touched, K: float, B: float) -> Certificate:
        press = self._several(surface, K, B) if surface.several else self._single(surface, B)
        along = _along(self.rig.arms.X_WL[:3, :3] @ press.n)
        case = Case(f"pressing {along} {press.description}", press.loop(press.held))
        k_max, w = case.loop.K_max(B)
        verdict, margin = judge(K, k_max, k_max)
        servo = 0.0 if self.fixture else _servo_lag(self.o)
        facts = words.LoopFacts(whole_servo_periods(self.o), self.o.rate, B, w / (2 * np.pi), case.description,
                                f", {1e3 * servo:.3g} ms of the follower's servo" if servo > 0.0 else "")  # fmt: skip
        reason = words.reason(
            K, k_max, verdict, facts, [*advice((case,), B), self._faster(press, B)] if verdict != "stable" else []
        )
        if verdict != "stable" and self.rig.scene.stability.passivity != "off":
            reason += f"; the passivity layer ({self.rig.scene.stability.passivity}) will take force to hold it"
        if verdict != "stable" and self.fixture and 0.0 < k_max < np.inf:
            reason += f"; softly it can hold so much: {entry_summary(SURE * k_max, self.o.mapping.force_scale)}"
            reason += "; with hard: true the tool stays out"
        hand = self.rig.options().hand
        hand.damping *= words.LESS
        k_less = min(k_max, press.loop(replace(press.held, hand=hand)).K_max(B)[0])
        reason += "; " + words.hands_covered([self.o.hand.damping], k_less)
        gain = press.contacts * felt(self.o)
        passive = classical.colgate_brown(self.o.hand.damping, gain * B, 1 / self.o.rate, facts.delay + servo)
        bounds = {"colgate_brown_with_hand": passive / gain if gain > 0.0 else np.inf}
        return Certificate(B, k_max, k_max, w / (2 * np.pi), case.description, K, verdict, margin, reason, bounds,
                           self._hands(press, B), (self.o.hand.damping,) * 2, k_less, (case,),
                           surface.name)  # fmt: skip

    def _single(self, surface: Touched, B: float) -> _Press:
        """The press with the smallest stable stiffness, by the tip alone."""
        pose, n = self._worst(surface, B)
        return _Press(self.leaders[pose], lambda held: held.loop(n), n, pose)

    def _several(self, surface: Touched, K: float, B: float) -> _Press:
        """The press with the smallest stable stiffness, by several spheres on a plane.

        More spheres touch a softer surface before the force reaches its cap. Where K is not stable, the spheres are
        therefore those that touch at the limit.
        """
        press = self._least(self._contacts(surface, K), B)
        for _ in range(_REPEATED):
            limit = press.loop(press.held).K_max(B)[0]
            if not 0.0 < limit < K:
                break
            K, press = limit, self._least(self._contacts(surface, limit), B)
        return press

    def _least(self, contacts: list[PlaneContact], B: float) -> _Press:
        """The press with the smallest stable stiffness."""
        R_LW = self.rig.arms.X_WL[:3, :3].T
        turn, poses = np.kron(np.eye(2), R_LW), list(self.leaders)

        def loop(one: PlaneContact, held: HeldLeader) -> CoupledLoop:
            return held.coupled(turn @ one.springs @ turn.T, turn @ one.dampers @ turn.T)

        pairs = [(one, self.leaders[poses[one.posture]]) for one in contacts]
        one, held = min(pairs, key=lambda pair: loop(*pair).K_max(B)[0])
        return _Press(held, lambda other: loop(one, other), R_LW @ one.normal,
                      f"{poses[one.posture]} with {one.count} of its spheres", one.count)  # fmt: skip

    def _contacts(self, surface: Touched, K: float) -> list[PlaneContact]:
        slope = self.o.mapping.force_scale * K
        depth = self.o.stability.force_cap / slope if slope > 0.0 else np.inf
        return plane_contacts(self.tools(), depth, self._normal(surface))

    def _normal(self, surface: Touched) -> Array | None:
        """The normal (3,) in W of a surface that is one plane; otherwise None."""
        alone = surface.index >= 0 and not surface.others
        plane = alone and self.rig.scene.objects[surface.index].plane is not None
        return self.rig.surfaces[surface.index].X_WO[:3, 2] if plane else None

    def _worst(self, surface: Touched, B: float) -> tuple[str, Array]:
        """The pose, and the direction (3,) in the leader's base, with the smallest stable stiffness."""
        normal = self._normal(surface)
        key = (B, None if normal is None else surface.index)
        if key not in self._worst_cases:
            R_LW = self.rig.arms.X_WL[:3, :3].T
            only = None if normal is None else [R_LW @ normal]
            tried = [
                (held.loop(n).K_max(B)[0], pose, n)
                for pose, held in self.leaders.items()
                for n in (only or _DIRECTIONS)
            ]
            k, pose, n = min(tried, key=lambda limit: limit[0])
            self._worst_cases[key] = (pose, n if only else self._steepest(self.leaders[pose], n, k, B))
        return self._worst_cases[key]

    @staticmethod
    def _steepest(held: HeldLeader, n: Array, k: float, B: float) -> Array:
        """A direction near n (3,) with a smaller limit than k [N/m], or n itself."""
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
    def _hands(press: _Press, B: float) -> dict[str, float]:
        """Limit [N/m] with each preset of `palpate.arm.hands`, for the same pose and direction."""
        return {
            name: press.loop(replace(press.held, hand=hand.options())).K_max(B)[0] for name, hand in PRESETS.items()
        }

    def _faster(self, press: _Press, B: float) -> words.Advice:
        o = self.rig.options()
        o.follower.bandwidth *= 2.0
        loop = press.loop(replace(press.held, o=o))
        return f"a follower's servo of {o.follower.bandwidth:g} Hz", lambda: loop.K_max(B)[0]


def _servo_lag(o: _core.SimulationOptions) -> float:
    """Lag of the follower's joints behind a slowly moving goal [s]."""
    return o.follower.damping_ratio / (np.pi * o.follower.bandwidth) if o.follower.bandwidth > 0.0 else 0.0


def _along(n: Array) -> str:
    """A direction in W, in words."""
    n = n * np.sign(n[np.argmax(np.abs(n))])
    return next((f"along {axis}" for axis, e in zip("xyz", np.eye(3), strict=True) if n @ e > 0.999),
                "along ({:.2f}, {:.2f}, {:.2f})".format(*np.round(n, 2) + 0.0))  # fmt: skip


def _poses(rig: Rig) -> Iterator[tuple[str, Array]]:
    """Description and joint positions (n,) of the leader at the start and along the operator's path."""
    arms, path = rig.arms, rig.path
    yield "at the start", arms.q_leader0
    q0 = _settled(rig)
    X_LH, X_WT = arms.leader.fk(arms.q_leader0), arms.X_WB @ arms.follower.fk(arms.q_follower0)
    handle0 = X_LH[:3, 3].copy()
    last = path.period if path.period else float(path.times[-1])
    for fraction in PATH_FRACTIONS:
        i = int(np.argmin(np.abs(path.times - fraction * last)))
        X_LH[:3, 3] = handle0 + arms.X_WL[:3, :3].T @ (path.positions_W[i] - X_WT[:3, 3]) / rig.scene.mapping.scale
        q, _ = arms.leader.ik_nearest(X_LH, q0, restarts=0)
        yield f"at {path.times[i]:.2g} s of the path", q


def _settled(rig: Rig) -> Array:
    """Joint positions (n,) at the start after an MTM's joint-4 controller has settled, without dry friction."""
    o, arms = rig.options(), rig.arms
    if o.torque.platform_gain == 0.0 or str(o.torque.mode).endswith("paper"):
        return arms.q_leader0
    o.leader.coulomb = np.zeros(arms.leader.n)
    model = arms.leader.with_scaled_masses(np.ones(arms.leader.n))
    rests = _core.HandPath([0.0], rig.path.positions_W[:1])
    simulation = _core.Simulation(o, arms.leader, model, arms.follower, rig.snapshot, rests)
    return np.asarray(as_ticks(simulation.run(round(_SETTLE * o.rate)))["q"][-1][: arms.leader.n])
