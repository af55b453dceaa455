"""Check at the places that the other checks reject because the constraint is not smooth there: edges, creases, bends.

What holds there holds everywhere. At rest the wrench is the law's, along the gradient of the gap. In motion it changes
by no more than the motion explains and the rates allow, and a hard goal stays outside. Without the rate limit no energy
is gained. What the rate limit yields is in the energy ledger, and the passivity layer withholds it.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from palpate.base.arrays import Array
from palpate_lab.verify.conformance.at_rest import ENTRY, WEIGHTS, expected, settle
from palpate_lab.verify.conformance.bench import DT, FORCE_RATE, MOMENT_RATE, Bench, Motion, constant_pose
from palpate_lab.verify.conformance.billing import billing_failure
from palpate_lab.verify.conformance.combinations import POLICIES, Combination
from palpate_lab.verify.conformance.in_motion import GAINED, LEAST, approached_loop
from palpate_lab.verify.conformance.laws import B_TURN, K_TURN, LAWS, RATIO, B, K
from palpate_lab.verify.conformance.probes import probe_at, rejected_poses
from palpate_lab.verify.conformance.roles import ROLES, gradient
from palpate_lab.verify.conformance.specimens import SPECIMENS

TICKS, TURNS = 200, 2
"""Ticks of a loop, and number of loops for which the energy is counted."""
STEEPEST = 100.0
"""Largest rate at which an axis or a frame counts as turning with the position [rad/m]."""


def rejected_places(c: Combination) -> str:
    """Rest and motion at places where the constraint is not smooth."""
    for X in rejected_poses(c):
        failure = _at_rest(c, X) or _in_motion(c, X)
        if failure:
            return f"at {np.round(X[:3, 3], 4)}: {failure}"
    return ""


def exact(c: Combination, X: Array) -> bool:
    """True if the wrench is an exact gradient: no correction makes it, and its target turns by less than STEEPEST."""
    return not (c.corrects or (_bounded(c.role) and _steepness(c.role, c.geometry, X.tobytes()).max() >= STEEPEST))


def _bounded(role: str) -> bool:
    """True if the target may turn without a bound in space, so that the product bounds its rate by STEEPEST."""
    return ROLES[role].turns and ROLES[role].options.get("target") != "normal"


def _at_rest(c: Combination, X: Array) -> str:
    if not exact(c, X) or LAWS[c.law].force is None:
        return ""
    probe = probe_at(c.role, c.geometry, X)
    F = Bench(c, quick=True).begin(X).run(constant_pose(X, settle(c))).F[-1]
    reference = expected(c, probe)
    off = float(np.linalg.norm((F - reference) * WEIGHTS))
    if off > 0.01 * float(np.linalg.norm(reference * WEIGHTS)) + K * SPECIMENS[c.geometry].near + 1e-5:
        return f"wrench {np.round(F, 4)}, by finite differences {np.round(reference, 4)}"
    return ""


def _in_motion(c: Combination, X: Array) -> str:
    approach, loop = approached_loop(X.tobytes(), TICKS, 1.0)
    turns = Motion(*(np.concatenate([x[:-1]] * TURNS + [x[-1:]]) for x in (loop.X, loop.V)))
    F = {}
    for quick in (True, False):
        bench = Bench(c, quick=quick).begin(X)
        bench.run(approach)
        for _ in range(-(-settle(c) // TICKS)):
            bench.run(loop)
        out = bench.run(turns)
        F[quick] = out.F
        if not quick:
            failure = _step_failure(c, X, out.steps(), turns) or _entry_failure(c, out.X)
            if failure:
                return failure
    given = np.einsum("ij,ij->i", 0.5 * (F[True][1:] + F[True][:-1]), turns.displacements)
    if exact(c, X) and given.sum() > LEAST + GAINED * np.abs(given).sum():
        return f"gives {1e3 * given.sum():.3g} of {1e3 * np.abs(given).sum():.3g} mJ without the rate limit"
    return billing_failure(F[False], turns)


def _step_failure(c: Combination, X: Array, steps: Array, motion: Motion) -> str:
    """No step exceeds what the motion explains and the rates of the stage allow."""
    per = _steepness(c.role, c.geometry, X.tobytes())[np.arange(len(motion.X)) % TICKS]
    per = np.maximum(per[1:], per[:-1])
    ways, changes = (
        np.column_stack([np.linalg.norm(rows[:, s], axis=1) for s in (slice(0, 3), slice(3, 6))])
        for rows in (motion.displacements, np.diff(motion.V, axis=0))
    )
    if c.corrects and ROLES[c.role].turns:
        per[:, 1] = 1.0  # the correction may end where the mean normal is longer
    turns, ratio = ROLES[c.role].turns, RATIO if LAWS[c.law].force is None else 1.0
    stiffness, damping = (K_TURN, B_TURN / ratio) if turns else (K, B / ratio)
    damped = changes[:, 1] if turns else (per * changes).sum(axis=1)
    explained = per * (stiffness * (per * ways).sum(axis=1) + damping * damped)[:, None]
    bound = 1.02 * (explained + DT * np.array([FORCE_RATE, MOMENT_RATE])) + 1e-6
    worst = np.unravel_index(int(np.argmax(steps - bound)), steps.shape)
    if steps[worst] > bound[worst]:
        return f"a step of {steps[worst]:.3g} {('N', 'N m')[worst[1]]} in one tick, {bound[worst]:.3g} promised"
    return ""


@lru_cache
def _steepness(role: str, geometry: str, X: bytes) -> Array:
    """Norms (TICKS, 2) of the gradient's linear and angular part along the loop, the largest of three ticks each."""
    case, s = ROLES[role], SPECIMENS[geometry]
    poses = approached_loop(X, TICKS, 1.0)[1].X[:TICKS]
    if not case.turns and not case.needs_point:
        return np.tile([1.0, 0.0], (TICKS, 1))
    J = np.stack([gradient(case, s, pose) for pose in poses])
    per = np.column_stack([np.linalg.norm(J[:, :3], axis=1), np.linalg.norm(J[:, 3:], axis=1)])
    near = np.maximum(np.maximum(per, np.roll(per, 1, axis=0)), np.roll(per, -1, axis=0))
    return np.asarray(np.minimum(near, [STEEPEST if _bounded(role) else np.inf, np.inf]))


def _entry_failure(c: Combination, goals: Array) -> str:
    """The goal of a hard fixture that repels, with full authority, stays outside."""
    case = ROLES[c.role]
    if not POLICIES[c.policy].hard or case.attracts or c.activation(-ENTRY) < 1.0:
        return ""
    least = min(case.gap(SPECIMENS[c.geometry], X) for X in goals[::10])
    return f"the goal enters by {-least:.2g} m" if least < -ENTRY - SPECIMENS[c.geometry].near else ""
