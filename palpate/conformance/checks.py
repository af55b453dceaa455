"""The six properties that every combination is held to. Each returns what is wrong in words, or nothing."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from palpate import _core
from palpate.conformance.bench import (
    DT,
    FORCE_RATE,
    MOMENT_RATE,
    RESERVE,
    RETURN_SPEED,
    Answer,
    Bench,
    Motion,
    between,
    fixture,
    still,
)
from palpate.conformance.combinations import POLICIES, REACH, Combination
from palpate.conformance.judges import (
    B_TURN,
    K_TURN,
    LAWS,
    LEVER,
    RATIO,
    ROLES,
    B,
    K,
    Probe,
    moved,
    probes,
)
from palpate.conformance.specimens import SPECIMENS

Array = NDArray[np.float64]

ENTRY = 1e-4
"""A hard fixture lets the tool in no further than this [m]; of angles, this many times 1/LEVER [rad]."""
NEAREST = 0.005
"""Radius of the tightest curve that a probe is beside, about [m]."""
SETTLE = 60
"""Ticks until a soft fixture's answer stands; a hard one mends what was wrong when it came, and needs more."""
SETTLE_HARD = 700


def _corrects(c: Combination) -> bool:
    """Its wrench comes from the goal's correction: it leads out what was wrong when it came, and needs its time."""
    return bool(POLICIES[c.policy].options.get("hard")) or c.law == "optimise"


def _settle(c: Combination) -> int:
    return SETTLE_HARD if _corrects(c) else SETTLE


def sign_and_direction(c: Combination) -> str:
    """At rest: the law's force along the gap's slope, times the policy's share; none where all is well."""
    case, hard = ROLES[c.role], POLICIES[c.policy].options.get("hard", False)
    for probe in probes(c.role, c.geometry):
        bench = Bench(fixture(c), quick=True)
        out = bench.run(still(probe.X, _settle(c)))
        wrong = _direction(c, probe, out.F[-1])
        if not wrong and hard:
            wrong = _corrected(c, probe, out.X[-1])
        if not wrong and LAWS[c.law].force is None:
            wrong = _damps(c, probe)
        if wrong:
            return f"gap {probe.gap:.4g} {'rad' if case.turns else 'm'} at {np.round(probe.X[:3, 3], 4)}: {wrong}"
    return ""


def _expected(c: Combination, probe: Probe) -> float:
    case, law, policy = ROLES[c.role], LAWS[c.law], POLICIES[c.policy]
    if law.force is None:
        return 0.0
    share = (
        policy.share(probe.gap)
        if not (case.turns and policy.ramp and policy.ramp[0] == "distance")
        else min(abs(probe.gap) / REACH, 1.0)
    )
    gap = probe.gap
    if gap > 0.0 and policy.options.get("hard"):
        gap = max(gap, 0.0)
    return share * law.force(gap, case.attracts, case.turns)


def _direction(c: Combination, probe: Probe, F: Array) -> str:
    case = ROLES[c.role]
    size = _expected(c, probe)
    part = slice(3, 6) if case.turns else slice(0, 3)
    want = probe.along * size / (np.linalg.norm(probe.along[part]) if case.turns else 1.0)
    hard = POLICIES[c.policy].options.get("hard", False)
    slack = (RESERVE * K if not case.turns else RESERVE / LEVER * K_TURN) * 1.2 if hard else 0.0
    weigh = np.r_[np.ones(3), np.full(3, 1.0 / LEVER)]
    if case.frozen and _corrects(c) and size > 0.0:  # its wish goes with the place: so does the size
        want = want * float(np.linalg.norm(F * weigh) / np.linalg.norm(want * weigh))
    off = float(np.linalg.norm((F - want) * weigh))
    allowed = (2e-3 if not _corrects(c) else 0.2 if case.frozen else 0.08) * float(
        np.linalg.norm(want * weigh)
    ) + slack / (LEVER if case.turns else 1.0)
    near = K * SPECIMENS[c.geometry].near * 4.0 + 1e-5
    if off > allowed + near:
        return f"wrench {np.round(F, 4)}, by finite differences {np.round(want, 4)}"
    return ""


def _corrected(c: Combination, probe: Probe, X: Array) -> str:
    """The goal of a hard fixture of whole authority is as wanted, and was not taken further than it had to be."""
    if POLICIES[c.policy].options.get("authority", 1.0) < 1.0:
        return ""
    case, s = ROLES[c.role], SPECIMENS[c.geometry]
    left = case.gap(s, X)
    limit = ENTRY / LEVER if case.turns else 2.0 * ENTRY if case.attracts else ENTRY
    if left < -limit - s.near:
        return f"the corrected goal is {-left:.2g} beyond the border"
    way = np.linalg.norm(X[:3, 3] - probe.X[:3, 3]) + LEVER * _angle(X, probe.X)
    need = max(-probe.gap, 0.0) * (LEVER if case.turns else 1.0)
    if way > 1.5 * need + 2.0 * RESERVE * (1 + case.turns):
        return f"the goal was taken {way:.3g} m away, {need:.3g} m was needed"
    return ""


def _angle(X: Array, Y: Array) -> float:
    return float(Rotation.from_matrix(X[:3, :3].T @ Y[:3, :3]).magnitude())


def _damps(c: Combination, probe: Probe) -> str:
    """A law of motions: takes energy out of every motion, more of one that is not wanted than of one that is."""
    case = ROLES[c.role]
    n = probe.along / np.linalg.norm(probe.along)
    worse = _power(c, probe, -0.02 * n * (1.0 if not case.turns else 10.0))
    better = _power(c, probe, 0.02 * n * (1.0 if not case.turns else 10.0))
    if worse > 1e-9 or better > 1e-9:
        return f"gives power: {worse:.3g} W against the wish, {better:.3g} W with it"
    if probe.gap < 0.0 and not worse < 0.5 * better - 1e-12:
        return f"a motion against the wish is hardly slower ({worse:.3g} W) than one with it ({better:.3g} W)"
    return ""


def _power(c: Combination, probe: Probe, V: Array) -> float:
    bench = Bench(fixture(c), quick=True)
    X, n = probe.X, 40
    bench.run(still(X, SETTLE))
    F = bench.run(Motion(np.repeat(X[None], n, axis=0), np.repeat(V[None], n, axis=0))).F[-1]
    return float(F @ V)


@lru_cache(maxsize=64)
def _ways(role: str, geometry: str) -> tuple[tuple[Motion, Motion, Motion], ...]:
    """From where all is well to where it is not and back, after a while of rest."""
    found = probes(role, geometry)
    pairs = ((found[-1].X, found[0].X), (found[1].X, found[2].X))
    return tuple((still(a, 50), between(a, b, 300), between(b, a, 300)) for a, b in pairs)


def continuity(c: Combination) -> str:
    """From where all is well to where it is not and back: no tick's wrench jumps more than motion and rates explain."""
    for rest, *ways in _ways(c.role, c.geometry):
        bench = Bench(fixture(c))
        bench.run(rest)
        for motion in ways:
            wrong = _jump(c, motion, bench.run(motion))
            if wrong:
                return wrong
    return ""


def _jump(c: Combination, motion: Motion, out: Answer) -> str:
    moves, turns = (np.linalg.norm(motion.way[:, s], axis=1) for s in (slice(0, 3), slice(3, 6)))
    dv, dw = (np.linalg.norm(np.diff(motion.V[:, s], axis=0), axis=1) for s in (slice(0, 3), slice(3, 6)))
    reach = 0.1 if c.role == "rcm" else 0.0  # lever from the tip to the trocar
    damping, damping_turn = (B / RATIO, B_TURN / RATIO) if c.law == "admittance" else (B, B_TURN)
    df = FORCE_RATE * DT + K * (moves + reach * turns) + damping * (dv + reach * dw)
    aims = moves / NEAREST if ROLES[c.role].turns else 0.0  # what is aimed at turns with the place
    dt = MOMENT_RATE * DT + K_TURN * (turns + aims) + damping_turn * dw + reach * df
    jump_f, jump_t = (np.linalg.norm(np.diff(out.F[:, s], axis=0), axis=1) for s in (slice(0, 3), slice(3, 6)))
    for jump, most, unit in ((jump_f, df, "N"), (jump_t, dt, "N m")):
        k = int(np.argmax(jump - 1.01 * most))
        if jump[k] > 1.01 * most[k] + 1e-6:
            return f"a step of {jump[k]:.3g} {unit} in one tick, {most[k]:.3g} explained"
    return ""


@lru_cache(maxsize=64)
def _loops(role: str, geometry: str) -> tuple[tuple[Motion, Motion], ...]:
    """Ways into closed loops, and the loops, at two speeds."""
    found = probes(role, geometry)
    still_place = ROLES[role].turns or ROLES[role].frozen
    loops = [(found[k].X, _loop(found[k].X, n, 0.0 if still_place else 1.5e-3)) for k, n in ((0, 600), (1, 200))]
    return tuple((between(X, loop.X[0], 200), loop) for X, loop in loops)


def energy(c: Combination) -> str:
    """Around closed loops, at two speeds: what the fixture gives to the hand it has taken before.

    Of a role that turns the tool, and of rcm, the tip stays: their wish is about the place it is at, and goes with it.
    Where rcm leads the goal, the tip moves all the same: what that costs is bounded here, and told in docs/guidance.md.
    """
    share = 0.15 if ROLES[c.role].frozen and _corrects(c) else 0.004
    for way_in, loop in _loops(c.role, c.geometry):
        bench = Bench(fixture(c))
        bench.run(way_in)
        bench.run(loop)  # once, so that it begins as it ends
        F = bench.run(loop).F
        given = np.einsum("ij,ij->i", 0.5 * (F[1:] + F[:-1]), loop.way)
        if given.sum() > 1e-7 + share * np.abs(given).sum():
            return (
                f"gives {1e3 * given.sum():.3g} mJ in a closed loop in which {1e3 * np.abs(given).sum():.3g} mJ moved"
            )
    return ""


def _loop(X: Array, n: int, radius: float, tilt: float = 0.1) -> Motion:
    """A circle with a nod, beginning and ending at the same pose with the same velocity."""
    phase = 2.0 * np.pi * np.arange(n + 1) / n
    y = np.column_stack([radius * np.cos(phase), radius * np.sin(phase), 0.6 * radius * np.sin(phase),
                         tilt * np.sin(phase), tilt * np.cos(phase), np.zeros(n + 1)])  # fmt: skip
    poses = np.stack([moved(X, row) for row in y])
    way = Motion(poses, np.zeros((n + 1, 6))).way
    V = 0.5 * (way + np.roll(way, 1, axis=0)) / DT
    return Motion(poses, np.concatenate([V, V[:1]]))


def frame_change(c: Combination) -> str:
    """Fixture and tool carried together to another place: the same answer, carried with them."""
    X_WG = np.eye(4)
    X_WG[:3, :3] = Rotation.from_rotvec([0.7, -1.1, 0.4]).as_matrix()
    X_WG[:3, 3] = [0.11, -0.07, 0.05]
    n = _settle(c)
    for probe in probes(c.role, c.geometry)[:2]:
        here = Bench(fixture(c), quick=True).run(still(probe.X, n))
        there = Bench(fixture(c, X_WG=X_WG), quick=True).run(still(X_WG @ probe.X, n))
        R = X_WG[:3, :3]
        F = np.r_[R.T @ there.F[-1, :3], R.T @ there.F[-1, 3:]]
        near = 1e-6 + K * (2.0 * RESERVE if n == SETTLE_HARD else 4.0 * SPECIMENS[c.geometry].near * 1e-2)
        if np.abs(F - here.F[-1]).max() > near:
            return f"wrench {np.round(here.F[-1], 5)} here, {np.round(F, 5)} there"
        X = np.linalg.inv(X_WG) @ there.X[-1]
        if np.abs(X - here.X[-1])[:3].max() > (2.0 * RESERVE / LEVER if n == SETTLE_HARD else 1e-9):
            return "the goal is corrected otherwise in another frame"
    return ""


AMPLITUDE, PERIOD = 0.004, 1.25


@lru_cache(maxsize=1)
def _carriage() -> tuple[_core.Frame, Array, Array]:
    """A frame that swings, its poses (n, 4, 4) and velocities (n, 6), tick by tick."""
    wave = _core.Wave(shift=np.array([AMPLITUDE, 0.0, 0.0]), period=PERIOD)
    frame = _core.MotionFrame(np.eye(4), _core.Motion(waves=[wave]))
    told = [frame.at(DT * k) for k in range(900)]
    return frame, np.stack([X for X, _ in told]), np.stack([V for _, V in told])


def moving(c: Combination) -> str:
    """Carried along by a fixture that moves, the hand feels what it feels beside one that rests.

    A law of motions may hold the hand back, against the world; it never gives.
    """
    frame, X_WF, V_WF = _carriage()
    n, last = len(X_WF), slice(-200, None)
    for probe in (probes(c.role, c.geometry)[0], probes(c.role, c.geometry)[-1]):
        motion = Motion(X_WF @ probe.X, V_WF)
        carried = Bench(fixture(c, frame=frame)).run(motion)
        rests = Bench(fixture(c)).run(still(probe.X, n))
        off = carried.F[last] - rests.F[-1]
        allowed = 0.02 * np.abs(rests.F[-1]).max() + 1e-3 + K * 4.0 * SPECIMENS[c.geometry].near
        if _corrects(c):  # the correction is a tick old when the fixture has moved on
            allowed += 2.0 * K * DT * float(np.linalg.norm(V_WF[:, :3], axis=1).max())
        if LAWS[c.law].force is None:
            given = float(np.einsum("ij,ij->i", off, V_WF[last]).max())
            if given > 1e-6:
                return f"gives {given:.3g} W to a hand that it carries"
            allowed += B / RATIO * float(np.linalg.norm(V_WF[:, :3], axis=1).max())
        if np.abs(off).max() > allowed:
            return f"{np.abs(off).max():.3g} N (N m) from the {np.abs(rests.F[-1]).max():.3g} of the same at rest"
        X_rest = np.linalg.inv(X_WF[last]) @ carried.X[last]
        if np.abs(X_rest - rests.X[-1])[:, :3].max() > 2.0 * ENTRY / (LEVER if ROLES[c.role].turns else 1.0):
            return "its corrected goal does not move along"
    return ""


def live_edit(c: Combination) -> str:
    """Switched off and on, moved, made stiffer, while the hand rests in it: never a step; then as if always so."""
    probe = probes(c.role, c.geometry)[0]
    hard = POLICIES[c.policy].options.get("hard", False)
    X_WG = np.eye(4)
    X_WG[:3, 3] = [0.0004, -0.0005, 0.0003]
    shape = SPECIMENS[c.geometry].make()
    edits = {
        "switched off": fixture(c, on=False, geometry=shape),
        "switched on": fixture(c, geometry=shape),
        "moved": fixture(c, X_WG=X_WG, geometry=shape),
        "made stiffer": fixture(c, X_WG=X_WG, geometry=shape, law={"K": 1.5 * K, "K_turn": 1.5 * K_TURN}),
    }
    bench, n = Bench(fixture(c, geometry=shape)), 700
    before = bench.run(still(probe.X, n))
    for words, edited in edits.items():
        bench.take(edited)
        after = bench.run(still(probe.X, n))
        F = np.concatenate([before.F[-1:], after.F])
        steps = [np.linalg.norm(np.diff(F[:, s], axis=0), axis=1).max() for s in (slice(0, 3), slice(3, 6))]
        if steps[0] > 1.01 * FORCE_RATE * DT + 1e-9 or steps[1] > 1.01 * (MOMENT_RATE * DT + 0.1 * FORCE_RATE * DT):
            return f"{words}: a step of {steps[0]:.3g} N, {steps[1]:.3g} N m in one tick"
        way = np.linalg.norm(np.diff(np.concatenate([before.X[-1:], after.X])[:, :3, 3], axis=0), axis=1).max()
        if hard and way > 1.01 * RETURN_SPEED * DT + 4.0 * RESERVE:
            return f"{words}: the goal jumps by {1e3 * way:.3g} mm in one tick"
        before = after
    fresh = Bench(edits["made stiffer"]).run(still(probe.X, 1500))
    off = np.abs(fresh.F[-1] - before.F[-1]).max()
    if off > 0.02 * np.abs(fresh.F[-1]).max() + (2.5 * K * RESERVE if hard else 1e-6):
        return f"after the edits {np.round(before.F[-1], 4)}, afresh {np.round(fresh.F[-1], 4)}"
    return ""


#: By name, in the order in which they are told.
CHECKS: dict[str, Callable[[Combination], str]] = {
    "sign and direction": sign_and_direction,
    "continuity": continuity,
    "energy": energy,
    "frame change": frame_change,
    "moving": moving,
    "live edit": live_edit,
}
