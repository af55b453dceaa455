"""Of a tool in motion: continuous, never a source of energy, and carried along by what moves."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from palpate import _core
from palpate.arrays import Array
from palpate.verify.conformance.at_rest import ENTRY, settle
from palpate.verify.conformance.bench import DT, VISIT, Bench, Motion, between, fixture, held, still
from palpate.verify.conformance.combinations import Combination
from palpate.verify.conformance.laws import LAWS, K
from palpate.verify.conformance.probes import beside, probes
from palpate.verify.conformance.roles import LEVER, ROLES, moved
from palpate.verify.conformance.specimens import SPECIMENS

TICKS = 200
"""Of a way; once more with FINER times as many."""
FINER = 4
RADIUS, TILT = 1.5e-3, 0.1
"""Of the closed loops: how far the tip goes around [m], how far the tool nods [rad]."""


@lru_cache(maxsize=64)
def ways(role: str, geometry: str) -> tuple[tuple[Array, Array], ...]:
    """From where all is well to where it is not, straight and near enough for the answer to turn smoothly."""
    found = probes(role, geometry)
    if ROLES[role].speed:
        return tuple((p.X, moved(p.X, 0.2 * p.V)) for p in found[:2])
    tilt = np.r_[0.0, 0.0, 0.0, 0.03, -0.02, 0.02]
    return tuple((beside(role, geometry, p.X), moved(p.X, tilt)) for p in found[:2])


def continuity(c: Combination) -> str:
    """From where all is well to where it is not and back: steps shrink with the ticks, as of what is continuous.

    The stage's limit of the wrench's rate is off here: it would hide a step.
    """
    for a, b in ways(c.role, c.geometry):
        largest, size = [], 0.0
        for n in (TICKS, FINER * TICKS):
            bench = Bench(c, quick=True).begin(a)
            bench.run(still(a, settle(c)))
            out = bench.run(_join(between(a, b, n), between(b, a, n)))
            largest.append(out.steps().max(axis=0))
            size = float(np.abs(out.F).max())
        coarse, fine = largest
        for k, unit in enumerate(("N", "N m")):
            if fine[k] > 0.6 * coarse[k] + 2e-3 * size + 1e-5:
                return f"steps of {coarse[k]:.3g} {unit} a tick; of {fine[k]:.3g} {unit} with {FINER} times the ticks"
    return ""


def _join(a: Motion, b: Motion) -> Motion:
    return Motion(np.concatenate([a.X, b.X]), np.concatenate([a.V, b.V]))


@lru_cache(maxsize=64)
def _loops(role: str, geometry: str) -> tuple[tuple[Motion, Motion], ...]:
    """Ways into closed loops of place and attitude, and the loops, at two speeds, either way round."""
    found = probes(role, geometry)
    loops = [(found[k].X, _loop(found[k].X, n, way)) for k, n in ((0, 600), (1, 200)) for way in (1.0, -1.0)]
    return tuple((between(X, loop.X[0], 200), loop) for X, loop in loops)


def energy(c: Combination) -> str:
    """Around closed loops of place and attitude, at two speeds: what the fixture gives to the hand it has taken."""
    for damping in (False, True) if LAWS[c.law].force is None else (False,):
        for way_in, loop in _loops(c.role, c.geometry):
            bench = Bench(c, damping=damping).begin(way_in.X[0])
            bench.run(way_in)
            for _ in range(-(-settle(c) // len(loop.X))):  # so that it begins as it ends
                bench.run(loop)
            F = bench.run(loop).F
            given = np.einsum("ij,ij->i", 0.5 * (F[1:] + F[:-1]), loop.way)
            if given.sum() > 1e-7 + 0.004 * np.abs(given).sum():
                return f"gives {1e3 * given.sum():.3g} mJ in a loop in which {1e3 * np.abs(given).sum():.3g} mJ moved"
    return ""


def _loop(X: Array, n: int, way: float) -> Motion:
    """A circle with a nod, beginning and ending at the same pose with the same velocity."""
    phase = way * 2.0 * np.pi * np.arange(n + 1) / n
    y = np.column_stack([RADIUS * np.cos(phase), RADIUS * np.sin(phase), 0.6 * RADIUS * np.sin(phase),
                         TILT * np.sin(phase), TILT * np.cos(phase), np.zeros(n + 1)])  # fmt: skip
    poses = np.stack([moved(X, row) for row in y])
    steps = Motion(poses, np.zeros((n + 1, 6))).way
    V = 0.5 * (steps + np.roll(steps, 1, axis=0)) / DT
    return Motion(poses, np.concatenate([V, V[:1]]))


AMPLITUDE, PERIOD, CARRIED, DAMPED = 0.004, 1.25, 900, 40.0
"""Of a fixture that swings [m, s]; for so many ticks; its damping [N s/m]."""


@lru_cache(maxsize=1)
def _carriage() -> tuple[_core.Frame, Array, Array]:
    """A frame that swings, its poses (n, 4, 4) and velocities (n, 6), tick by tick."""
    wave = _core.Wave(shift=np.array([AMPLITUDE, 0.0, 0.0]), period=PERIOD)
    frame = _core.MotionFrame(np.eye(4), _core.Motion(waves=[wave]))
    told = [frame.at(DT * k) for k in range(CARRIED + VISIT)]
    return frame, np.stack([X for X, _ in told]), np.stack([V for _, V in told])


def moving(c: Combination) -> str:
    """Carried along by a fixture that moves, the hand feels what it feels beside one that rests.

    A law of motions may hold the hand back, against the world; it never gives. A limit of speed is of the tool's speed
    in the world, however its region moves; one of force does not know how fast what is touched moves. All others are
    damped so much that a fixture whose velocity is not reckoned with is felt.
    """
    frame, X_WF, V_WF = _carriage()
    law = {} if LAWS[c.law].force is None or ROLES[c.role].touches else {"B": DAMPED}
    last, of_world = slice(-200, None), ROLES[c.role].speed
    for probe in (probes(c.role, c.geometry)[0], probes(c.role, c.geometry)[-1]):
        bench = Bench(c, fixture(c, frame=frame, law=law)).begin(probe.X, X_WF)
        X, V = (told[bench.ticks :][:CARRIED] for told in (X_WF, V_WF))
        motion = held(probe, CARRIED).carried(X, V)
        carried = bench.run(motion, X)
        rests = Bench(c, fixture(c, law=law)).begin(probe.X).run(motion if of_world else held(probe, CARRIED))
        wrong = _not_carried(c, carried.F[last], rests.F[last], V[last])
        if wrong:
            return wrong
        X_rest = carried.X[last] if of_world else np.linalg.inv(X[last]) @ carried.X[last]
        if np.abs(X_rest - rests.X[last])[:, :3].max() > 2.0 * ENTRY / (LEVER if ROLES[c.role].turns else 1.0):
            return "its corrected goal does not move along"
    return ""


def _not_carried(c: Combination, carried: Array, rests: Array, V_WF: Array) -> str:
    off, size = carried - rests, float(np.abs(rests).max())
    allowed = 0.02 * size + 1e-3 + K * 4.0 * SPECIMENS[c.geometry].near
    if (
        c.corrects or ROLES[c.role].touches
    ):  # the correction, and the touch, are a tick old when the fixture has moved on
        allowed += 2.0 * K * DT * float(np.linalg.norm(V_WF[:, :3], axis=1).max())
    if LAWS[c.law].force is None and not ROLES[c.role].speed:
        given = float(np.einsum("ij,ij->i", off, V_WF).max())
        if given > 1e-6:
            return f"gives {given:.3g} W to a hand that it carries"
        allowed += LAWS[c.law].damping * float(np.linalg.norm(V_WF[:, :3], axis=1).max())
    if np.abs(off).max() > allowed:
        return f"{np.abs(off).max():.3g} N (N m) from the {size:.3g} of the same at rest"
    return ""
