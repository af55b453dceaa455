"""Checks with a tool in motion: the wrench is continuous, passive, and correct for moving fixtures."""

from __future__ import annotations

from functools import cache, lru_cache

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate_lab.verify.conformance.at_rest import ENTRY, settle
from palpate_lab.verify.conformance.bench import (
    DT,
    VISIT,
    Bench,
    Motion,
    between,
    constant_pose,
    constant_probe,
    fixture,
)
from palpate_lab.verify.conformance.billing import billing_failure
from palpate_lab.verify.conformance.combinations import Combination
from palpate_lab.verify.conformance.laws import LAWS, K
from palpate_lab.verify.conformance.probes import Probe, moved_to_gap, probes, satisfied_pose
from palpate_lab.verify.conformance.roles import LEVER, ROLES, RoleCase, moved, slope
from palpate_lab.verify.conformance.specimens import SPECIMENS, Specimen

TICKS = 200
"""Ticks of a path in the coarse run."""
FINER = 4
"""Ratio of ticks in the fine run to ticks in the coarse run."""
LEAST, GAINED = 1e-7, 0.004
"""Accepted energy of a closed loop: absolute [J], and relative to the energy moved [-]."""
RADIUS, TILT = 1.5e-3, 0.1
"""Amplitudes of the closed loops in translation [m] and rotation [rad]."""


def paths(c: Combination) -> tuple[tuple[Array, Array], ...]:
    """Start and end poses (4, 4) of short straight paths from a satisfied pose to a violated pose."""
    return tuple(_path(c.role, c.geometry, probe) for probe in probes(c)[:2])


@lru_cache
def _path(role: str, geometry: str, probe: Probe) -> tuple[Array, Array]:
    if ROLES[role].speed:
        return probe.X, moved(probe.X, 0.2 * probe.V)
    end = moved(probe.X, np.r_[0.0, 0.0, 0.0, 0.03, -0.02, 0.02])
    return _smooth_start(ROLES[role], SPECIMENS[geometry], probe, satisfied_pose(role, geometry, probe.X)), end


def _smooth_start(case: RoleCase, s: Specimen, probe: Probe, start: Array) -> Array:
    """The satisfied pose, or one just beyond the border if an edge lies between the satisfied pose and the probe.

    Inside an edge two walls are equally near, and a potential jumps from the normal of one to that of the other.
    """
    if case.turns or case.touches or case.needs_point:
        return start
    n = slope(s.distance, probe.X[:3, 3])
    if float(slope(s.distance, start[:3, 3]) @ n) > 0.999:
        return start
    beyond = moved_to_gap(case, s, probe.X, -2e-5)
    return start if beyond is None else beyond


def continuity(c: Combination) -> str:
    """The wrench is continuous along a path into violation and back: its steps shrink with the tick length.

    The rate limit of the stage is off in this check because it would hide a discontinuity.
    """
    for a, b in paths(c):
        found = []
        for n in (TICKS, FINER * TICKS):
            bench = Bench(c, quick=True).begin(a)
            bench.run(constant_pose(a, settle(c)))
            found.append(bench.run(_join(between(a, b, n), between(b, a, n))))
        coarse, fine = (out.steps().max(axis=0) for out in found)
        size = float(np.abs(found[-1].F).max())
        wander = K * SPECIMENS[c.geometry].wander * c.corrects
        for k, unit in enumerate(("N", "N m")):
            if fine[k] > 0.6 * coarse[k] + 2e-3 * size + wander + 1e-5:
                return f"steps of {coarse[k]:.3g} {unit} a tick; of {fine[k]:.3g} {unit} with {FINER} times the ticks"
    return ""


def _join(a: Motion, b: Motion) -> Motion:
    return Motion(np.concatenate([a.X, b.X]), np.concatenate([a.V, b.V]))


def _loops(c: Combination) -> list[tuple[Motion, Motion]]:
    """Closed loops in position and orientation with their approach paths, at two speeds and in both directions."""
    found = probes(c)
    return [approached_loop(found[k].X.tobytes(), n, sign) for k, n in ((0, 600), (1, 200)) for sign in (1.0, -1.0)]


@lru_cache
def approached_loop(X: bytes, n: int, sign: float) -> tuple[Motion, Motion]:
    """The approach path from X (4, 4), as bytes, to a loop of n ticks around X in the direction of sign, and the loop.

    Bytes are hashable and serve as a cache key.
    """
    middle = np.frombuffer(X).reshape(4, 4)
    loop = _loop(middle, n, sign)
    return between(middle, loop.X[0], 200), loop


def energy(c: Combination) -> str:
    """The fixture supplies no net energy in a closed loop of position and orientation.

    Energy that only the rate limit of the stage causes must be in the ledger, and withheld by the passivity layer.
    """
    for damping in (False, True) if LAWS[c.law].force is None else (False,):
        for approach, loop in _loops(c):
            failure, F = _gain(c, approach, loop, damping, False)
            if failure:
                failure = _gain(c, approach, loop, damping, True)[0] or billing_failure(F, loop)
            if failure:
                return failure
    return ""


def _gain(c: Combination, approach: Motion, loop: Motion, damping: bool, quick: bool) -> tuple[str, Array]:
    """Words if a loop yields energy, and its wrenches (n, 6). quick: without the stage's rate limit."""
    bench = Bench(c, damping=damping, quick=quick).begin(approach.X[0])
    bench.run(approach)
    for _ in range(-(-settle(c) // len(loop.X))):  # repeated until the fixture's state is periodic
        bench.run(loop)
    F = bench.run(loop).F
    given = np.einsum("ij,ij->i", 0.5 * (F[1:] + F[:-1]), loop.displacements)
    if given.sum() <= LEAST + GAINED * np.abs(given).sum():
        return "", F
    return f"gives {1e3 * given.sum():.3g} mJ in a loop in which {1e3 * np.abs(given).sum():.3g} mJ moved", F


def _loop(X: Array, n: int, sign: float) -> Motion:
    """A periodic loop in position and orientation around X with n ticks; sign: direction."""
    phase = sign * 2.0 * np.pi * np.arange(n + 1) / n
    y = np.column_stack([RADIUS * np.cos(phase), RADIUS * np.sin(phase), 0.6 * RADIUS * np.sin(phase),
                         TILT * np.sin(phase), TILT * np.cos(phase), np.zeros(n + 1)])  # fmt: skip
    poses = np.stack([moved(X, row) for row in y])
    steps = Motion(poses, np.zeros((n + 1, 6))).displacements
    V = 0.5 * (steps + np.roll(steps, 1, axis=0)) / DT
    return Motion(poses, np.concatenate([V, V[:1]]))


AMPLITUDE, PERIOD, CARRIED, DAMPED = 0.004, 1.25, 900, 40.0
"""Oscillation of a moving fixture [m, s], number of ticks, and its damping [N s/m]."""


@cache
def _carriage() -> tuple[_core.Frame, Array, Array]:
    """An oscillating frame, its poses (n, 4, 4) and its velocities (n, 6) per tick."""
    wave = _core.Wave(shift=np.array([AMPLITUDE, 0.0, 0.0]), period=PERIOD)
    frame = _core.MotionFrame(np.eye(4), _core.Motion(waves=[wave]))
    states = [frame.at(DT * k) for k in range(CARRIED + VISIT)]
    return frame, np.stack([X for X, _ in states]), np.stack([V for _, V in states])


def moving(c: Combination) -> str:
    """A hand that moves with a moving fixture gets the same wrench as at a resting fixture.

    Exceptions: a velocity law may brake the hand relative to the world but never drives it; a speed limit applies to
    the tool's speed in the world; a force limit does not know the velocity of the touched object. All other fixtures
    have so much damping that an ignored fixture velocity changes the wrench.
    """
    frame, X_WF, V_WF = _carriage()
    law = {} if LAWS[c.law].force is None or ROLES[c.role].touches else {"B": DAMPED}
    last, of_world = slice(-200, None), ROLES[c.role].speed
    for probe in (probes(c)[0], probes(c)[-1]):
        bench = Bench(c, fixture(c, frame=frame, law=law)).begin(probe.X, X_WF)
        X, V = (states[bench.ticks :][:CARRIED] for states in (X_WF, V_WF))
        motion = constant_probe(probe, CARRIED).carried(X, V)
        carried = bench.run(motion, X)
        rests = Bench(c, fixture(c, law=law)).begin(probe.X).run(motion if of_world else constant_probe(probe, CARRIED))
        failure = _carried_failure(c, carried.F[last], rests.F[last], V[last])
        if failure:
            return failure
        X_rest = carried.X[last] if of_world else np.linalg.inv(X[last]) @ carried.X[last]
        if np.abs(X_rest - rests.X[last])[:, :3].max() > 2.0 * ENTRY / (LEVER if ROLES[c.role].turns else 1.0):
            return "its corrected goal does not move along"
    return ""


def _carried_failure(c: Combination, carried: Array, rests: Array, V_WF: Array) -> str:
    off, size = carried - rests, float(np.abs(rests).max())
    allowed = 0.02 * size + 1e-3 + K * 4.0 * SPECIMENS[c.geometry].near
    # A correction and a touch are computed from the fixture's pose of the previous tick.
    if c.corrects or ROLES[c.role].touches:
        allowed += 2.0 * K * DT * float(np.linalg.norm(V_WF[:, :3], axis=1).max())
    if LAWS[c.law].force is None and not ROLES[c.role].speed:
        given = float(np.einsum("ij,ij->i", off, V_WF).max())
        if given > 1e-6:
            return f"gives {given:.3g} W to a hand that it carries"
        allowed += LAWS[c.law].damping * float(np.linalg.norm(V_WF[:, :3], axis=1).max())
    if np.abs(off).max() > allowed:
        return f"{np.abs(off).max():.3g} N (N m) from the {size:.3g} of the same at rest"
    return ""
