"""Live edits never cause a step of the wrench, at rest and in motion, on impedance and admittance masters.

The wrench is checked in every tick against two control runs of the same motion without an edit, one with the old and
one with the new settings, and against the largest change that stiffness and damping can cause in this motion. An edit
may add at most 20 N/s and 0.35 N m/s; on an admittance master, the change of the damping force may add as much again.
At rest, switching or a new authority changes the wrench no faster than the policy's rise and fall times. Finally the
wrench equals that of a run that had the new settings from the start.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from palpate import _core, _guidance
from palpate.base.arrays import Array
from palpate_lab.verify.conformance.at_rest import SETTLED, WEIGHTS, settle
from palpate_lab.verify.conformance.bench import (
    DT,
    FORCE_RATE,
    MOMENT_RATE,
    RESERVE,
    RETURN_SPEED,
    Answer,
    Bench,
    Motion,
    constant_probe,
    fixture,
)
from palpate_lab.verify.conformance.combinations import ENGAGE, LATER, PER_TURN, POLICIES, QUICK, SLOW, Combination
from palpate_lab.verify.conformance.laws import B_TURN, K_TURN, LAWS, RATIO, B, K
from palpate_lab.verify.conformance.probes import Probe, moved_to_gap, pool, probe_at, probes, smooth
from palpate_lab.verify.conformance.roles import LEVER, ROLES, SPEED, gradient, moved
from palpate_lab.verify.conformance.specimens import SPECIMENS

PERIOD, SWING, NOD = 160, 3e-4, 0.015
"""Period and amplitudes of the hand's motion [ticks, m, rad]."""
MOVE, JUMP = 7e-4, 2.5e-3
"""Displacement of a fixture by an edit, and of its frame by a jump [m]."""
OTHER = {"spring": "admittance", "potential": "optimise", "admittance": "spring", "optimise": "potential"}
"""The law that an edit substitutes for each law."""


@dataclass(frozen=True)
class Setting:
    """Settings of a fixture that edits change."""

    on: bool = True
    X_FG: Array = field(default_factory=lambda: np.eye(4))
    X_WF: Array = field(default_factory=lambda: np.eye(4))
    """Pose of the live frame that carries the fixture."""
    law: dict[str, float] = field(default_factory=dict)
    law_name: str = ""
    authority: float | None = None

    def fixture(
        self, c: Combination, shape: _guidance.Geometry, frame: _core.LiveFrame, rise: float = SLOW
    ) -> _guidance.Fixture:
        """The core's fixture with these settings."""
        policy = POLICIES[c.policy]
        if self.authority is not None:
            policy = replace(policy, authority=self.authority)
        return fixture(c, X_WG=self.X_FG, frame=frame, law=self.law, law_name=self.law_name, policy=policy, rise=rise,
                       on=self.on, geometry=shape)  # fmt: skip


def _shift(xyz: Array) -> Array:
    X = np.eye(4)
    X[:3, 3] = xyz
    return X


def edits(c: Combination, probe: Probe) -> dict[str, Setting]:
    """Settings after each consecutive edit, by the name of the edit."""
    first = Setting()
    up = probe.J[:3].tobytes()  # bytes are hashable and serve as a cache key
    aside = _smooth_shift(c.role, c.geometry, probe.X.tobytes(), up, MOVE)
    jump = _smooth_shift(c.role, c.geometry, (np.linalg.inv(aside) @ probe.X).tobytes(), up, JUMP)
    stiffer, damper = {"K": 1.5 * K, "K_turn": 1.5 * K_TURN}, {"B": 3.0 * B, "B_turn": 3.0 * B_TURN}
    authority = 0.5 * POLICIES[c.policy].authority
    last = replace(first, X_FG=aside, law={**stiffer, **damper}, law_name=OTHER[c.law], authority=authority)
    return {
        "as it was": first,
        "switched off": replace(first, on=False),
        "switched on": first,
        "moved by 0.7 mm": replace(first, X_FG=aside),
        "made stiffer": replace(first, X_FG=aside, law=stiffer),
        "damped more": replace(first, X_FG=aside, law={**stiffer, **damper}),
        "given another law": replace(last, authority=None),
        "its frame leapt by 2.5 mm": replace(last, authority=None, X_WF=jump),
        "given half the authority": replace(last, X_WF=jump),
    }


def live_edit(c: Combination) -> str:
    """All edits of `edits` in sequence, first at rest and then in motion."""
    probe = _edit_probe(c)
    masters = (False, True) if "admittance" in (c.law, OTHER[c.law]) else (False,)
    motions = {"at rest": (constant_probe(probe, 2), False)}
    motions |= {f"in motion{', admittance master' * m}": (_swinging(c, probe), m) for m in masters}
    for words, (motion, damping) in motions.items():
        failure = _edit_failure(c, probe, motion, damping)
        if failure:
            return f"{words}, {failure}"
    return ""


def _edit_failure(c: Combination, probe: Probe, motion: Motion, damping: bool) -> str:
    shape, frame, settings = SPECIMENS[c.geometry].make(), _core.LiveFrame(), edits(c, probe)
    controls = {edit: _control(c, setting, shape, motion, damping) for edit, setting in settings.items()}
    seen = {edit: _probe_after(c, probe, setting) for edit, setting in settings.items()}
    (before, first), *rest = settings.items()
    bench = Bench(c, first.fixture(c, shape, frame), damping=damping).begin(probe.X)
    now = _run(bench, first, motion, _transition_ticks(c))
    for edit, setting in rest:
        frame.set(setting.X_WF)
        if np.array_equal(setting.X_WF, settings[before].X_WF):  # a jump of the live frame needs no new fixtures
            bench.take(setting.fixture(c, shape, frame))
        after = _run(bench, setting, motion, _transition_ticks(c) + len(motion.X))
        was, becomes = controls[before], controls[edit]
        goals = max(_largest_goal_step(was.X), _largest_goal_step(becomes.X)) + RETURN_SPEED * DT + 4.0 * RESERVE
        bound = _step_bound(c, edit, (seen[before], seen[edit]), motion, was, becomes)
        bound[0] += damping * DT * FORCE_RATE
        failure = _step_failure(c, now, after, bound, goals) or _residual_failure(c, after, becomes)
        if failure:
            return f"{edit}: {failure}"
        now, before = after, edit
    return ""


@lru_cache
def _smooth_shift(role: str, geometry: str, X: bytes, along: bytes, far: float) -> Array:
    """Displacement of the fixture (4, 4) by ``far`` [m] after which the constraint is smooth at the tool pose X.

    A displacement that increases the violation is preferred to a sideways or a reducing one. X (4, 4) and the gradient
    ``along`` (3,) are passed as bytes so that results can be cached.
    """
    case, s = ROLES[role], SPECIMENS[geometry]
    here, slope = np.frombuffer(X).reshape(4, 4), np.frombuffer(along)
    up = slope / max(float(np.linalg.norm(slope)), 1e-9)
    side = np.cross(up, np.eye(3)[int(np.argmin(np.abs(up)))])
    for direction in (up, side, -side, np.cross(up, side), -np.cross(up, side), -up):
        shift = _shift(far * direction / max(float(np.linalg.norm(direction)), 1e-9))
        Y = np.linalg.inv(shift) @ here
        if case.speed or smooth(case, s, Y, gradient(case, s, Y)):
            return shift
    raise LookupError(f"no displacement of {1e3 * far} mm near a {geometry} leads to a smooth constraint of {role}")


def _transition_ticks(c: Combination) -> int:
    """Ticks until the transition after an edit has ended."""
    return max(settle(c), 1600 if ROLES[c.role].turns else round(1.6 * SLOW / DT))


def _edit_probe(c: Combination) -> Probe:
    """A probe with a violated constraint; for a fixture that engages by distance, within this distance."""
    case, s = ROLES[c.role], SPECIMENS[c.geometry]
    if POLICIES[c.policy].engage is None:
        return next((probe for probe in probes(c) if probe.violated and _can_jump(c, probe)), probes(c)[0])
    for probe in pool(c.role, c.geometry, c.seed).violated:
        X = moved_to_gap(case, s, probe.X, -0.85 * ENGAGE * (PER_TURN if case.turns else 1.0))
        if X is not None and smooth(case, s, X, gradient(case, s, X)):
            return probe_at(c.role, c.geometry, X)
    raise LookupError(f"no smooth point near the boundary of {c.role} for a {c.geometry}")


def _can_jump(c: Combination, probe: Probe) -> bool:
    """True if the edits of the fixture's pose lead from the probe to smooth places."""
    try:
        edits(c, probe)
    except LookupError:
        return False
    return True


def _swinging(c: Combination, probe: Probe) -> Motion:
    """Periodic motion around the probe, PERIOD ticks per turn; it exceeds the limit of a role that limits speed."""
    phase = 2.0 * np.pi * np.arange(PERIOD) / PERIOD
    r = 2.5 * SPEED * PERIOD * DT / (2.0 * np.pi) if ROLES[c.role].speed else SWING
    y = np.column_stack([r * np.sin(phase), r * np.cos(phase), 0.5 * r * np.sin(phase),
                         NOD * np.sin(phase), NOD * np.cos(phase), 0.0 * phase])  # fmt: skip
    X = np.stack([moved(probe.X, row) for row in y])
    steps = Motion(np.concatenate([X, X[:1]]), np.zeros((PERIOD + 1, 6))).displacements
    return Motion(X, 0.5 * (steps + np.roll(steps, 1, axis=0)) / DT)


def _run(bench: Bench, setting: Setting, motion: Motion, n: int) -> Answer:
    turns = -(-n // len(motion.X))
    X, V = np.tile(motion.X, (turns, 1, 1)), np.tile(motion.V, (turns, 1))
    return bench.run(Motion(X, V), setting.X_WF @ setting.X_FG)


def _control(c: Combination, setting: Setting, shape: _guidance.Geometry, motion: Motion, damping: bool) -> Answer:
    """The last turn of a run without edits and without rate limits."""
    frame = _core.LiveFrame()
    frame.set(setting.X_WF)
    made = setting.fixture(c, shape, frame, QUICK)
    bench = Bench(c, made, damping=damping, quick=True).begin(motion.X[0], setting.X_WF @ setting.X_FG)
    n = len(motion.X)
    out = _run(bench, setting, motion, (settle(c) if setting.law_name != "optimise" else SETTLED) + 2 * n)
    return Answer(out.F[-n - 1 :], out.X[-n - 1 :], out.B[-n - 1 :])


def _step_failure(c: Combination, now: Answer, after: Answer, bound: Array, goals: float) -> str:
    """Compare the steps per tick with their bounds: bound (2,) of the wrench [N, N m], goals of the goal [m]."""
    steps = after.steps(now.F[-1]).max(axis=0)
    for step, allowed, unit in zip(steps, bound, ("N", "N m"), strict=True):
        if step > 1.02 * allowed + 1e-6:
            return f"a step of {step:.3g} {unit} in one tick, {allowed:.3g} promised"
    goal_step = _largest_goal_step(np.concatenate([now.X[-1:], after.X]))
    if POLICIES[c.policy].hard and goal_step > 1.02 * goals:
        return f"the goal jumps by {1e3 * goal_step:.3g} mm in one tick"
    return ""


def _probe_after(c: Combination, probe: Probe, setting: Setting) -> Probe:
    """The probe relative to the fixture's pose in a setting."""
    if ROLES[c.role].speed:
        return probe
    return probe_at(c.role, c.geometry, np.linalg.inv(setting.X_WF @ setting.X_FG) @ probe.X)


def _step_bound(
    c: Combination, edit: str, seen: tuple[Probe, Probe], motion: Motion, was: Answer, becomes: Answer
) -> Array:
    """Bounds (2,) of the wrench's step in one tick [N, N m]. seen: the probe before and after the edit."""
    controls = np.maximum(was.steps().max(axis=0), becomes.steps().max(axis=0))
    rate = DT * np.array([FORCE_RATE, MOMENT_RATE])
    corrects = c.corrects or LAWS[OTHER[c.law]].together
    if edit.startswith(("switched", "given half")) and not corrects and not np.ptp(motion.X, axis=0).any():
        fading = 1.0 / SLOW + (1.0 / LATER if POLICIES[c.policy].ramp else 0.0)
        full = np.maximum(_sizes(was), _sizes(becomes)) / max(c.activation(seen[1].gap), 0.01)
        rate = np.minimum(rate, DT * fading * full)
    explained = np.maximum(*(_motion_bound(c, probe, motion) for probe in seen))
    return np.asarray(np.maximum(controls, explained) + rate)


def _sizes(answer: Answer) -> Array:
    return np.array([np.linalg.norm(answer.F[:, s], axis=1).max() for s in (slice(0, 3), slice(3, 6))])


def _motion_bound(c: Combination, probe: Probe, motion: Motion) -> Array:
    """Largest wrench change per tick (2,) that this motion can cause with the stiffest and most damped setting."""
    per = np.array([np.linalg.norm(probe.J[s]) for s in (slice(0, 3), slice(3, 6))])
    ways, changes = (
        np.array([np.linalg.norm(rows[:, s], axis=1).max() for s in (slice(0, 3), slice(3, 6))])
        for rows in (motion.displacements, np.diff(motion.V, axis=0))
    )
    stiffness, damping = (1.5 * K_TURN, 3.0 * B_TURN) if ROLES[c.role].turns else (1.5 * K, 3.0 * B)
    damping = damping / RATIO if "admittance" in (c.law, OTHER[c.law]) else damping
    return np.asarray(per * (stiffness * (per @ ways) + damping * (per @ changes)))


def _largest_goal_step(X: Array) -> float:
    return float(np.linalg.norm(np.diff(X[:, :3, 3], axis=0), axis=1).max())


def _residual_failure(c: Combination, after: Answer, becomes: Answer) -> str:
    """Compare the last turn after an edit with a run that had the new settings from the start.

    A hard speed limit is skipped: the lag of its goal depends on the initial state.
    """
    if ROLES[c.role].speed and POLICIES[c.policy].hard:
        return ""
    n = len(becomes.F) - 1
    off = float(np.linalg.norm((after.F[-n:] - becomes.F[-n:]) * WEIGHTS, axis=1).max())
    size = float(np.linalg.norm(becomes.F * WEIGHTS, axis=1).max())
    reserve = 2.5 * RESERVE * (K_TURN / LEVER**2 if ROLES[c.role].turns else 1.5 * K) if c.corrects else 0.0
    if off > 0.03 * size + reserve + 1e-5:
        return f"still {off:.3g} N from what it would always have been, {size:.3g} N"
    return ""
