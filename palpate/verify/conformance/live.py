"""Edits in the operator's hand: never a step, at rest and in motion, on either kind of master; then as if always so.

The claim is about what is felt, a thousand times a second. Two runs of the same motion without an edit are the measure,
one as it was before and one as it is after, and what the laws' stiffness and damping make of this motion at most: an
edit adds to it 20 N and 0.35 N m a second, no more (on a master that takes damping as such, the damping as much again).
And what is switched, or given another authority, at rest comes and goes no faster than the policy's rise and fall.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np

from palpate import _core
from palpate.arrays import Array
from palpate.verify.conformance.at_rest import SETTLED, WEIGH, settle
from palpate.verify.conformance.bench import (
    DT,
    FORCE_RATE,
    MOMENT_RATE,
    RESERVE,
    RETURN_SPEED,
    Answer,
    Bench,
    Motion,
    fixture,
    held,
)
from palpate.verify.conformance.combinations import ENGAGE, LATER, PER_TURN, POLICIES, QUICK, SLOW, Combination
from palpate.verify.conformance.laws import B_TURN, K_TURN, LAWS, RATIO, B, K
from palpate.verify.conformance.probes import WRONG, Probe, brought, probe_at, probes, smooth
from palpate.verify.conformance.roles import LEVER, ROLES, SPEED, gradient, moved
from palpate.verify.conformance.specimens import SPECIMENS

PERIOD, SWING, NOD = 160, 3e-4, 0.015
"""Of the hand's motion [ticks, m, rad]."""
MOVED, LEAPT = 7e-4, 2.5e-3
"""By which a fixture is moved by hand; by which its frame leaps [m]."""
OTHER = {"spring": "admittance", "potential": "optimise", "admittance": "spring", "optimise": "potential"}
"""The law that takes the place of each."""


@dataclass(frozen=True)
class Setting:
    """What a fixture is at a time: what an edit changes."""

    on: bool = True
    X_FG: Array = field(default_factory=lambda: np.eye(4))
    X_WF: Array = field(default_factory=lambda: np.eye(4))
    """of the live frame that it is attached to."""
    law: dict[str, float] = field(default_factory=dict)
    law_name: str = ""
    authority: float | None = None

    def fixture(
        self, c: Combination, shape: _core.Geometry, frame: _core.LiveFrame, rise: float = SLOW
    ) -> _core.Fixture:
        """For the core."""
        policy: dict[str, Any] = {} if self.authority is None else {"authority": self.authority}
        return fixture(c, X_WG=self.X_FG, frame=frame, law=self.law, law_name=self.law_name, policy=policy, rise=rise,
                       on=self.on, geometry=shape)  # fmt: skip


def _shift(xyz: Array) -> Array:
    X = np.eye(4)
    X[:3, 3] = xyz
    return X


def edits(c: Combination, probe: Probe) -> dict[str, Setting]:
    """One after the other, by what is done."""
    first = Setting()
    up = probe.along[:3].tobytes()
    aside = _smoothly(c.role, c.geometry, probe.X.tobytes(), up, MOVED)
    leapt = _smoothly(c.role, c.geometry, (np.linalg.inv(aside) @ probe.X).tobytes(), up, LEAPT)
    stiffer, damper = {"K": 1.5 * K, "K_turn": 1.5 * K_TURN}, {"B": 3.0 * B, "B_turn": 3.0 * B_TURN}
    authority = 0.5 * float(POLICIES[c.policy].options.get("authority", 1.0))
    last = replace(first, X_FG=aside, law={**stiffer, **damper}, law_name=OTHER[c.law], authority=authority)
    return {
        "as it was": first,
        "switched off": replace(first, on=False),
        "switched on": first,
        "moved by 0.7 mm": replace(first, X_FG=aside),
        "made stiffer": replace(first, X_FG=aside, law=stiffer),
        "damped more": replace(first, X_FG=aside, law={**stiffer, **damper}),
        "given another law": replace(last, authority=None),
        "its frame leapt by 2.5 mm": replace(last, authority=None, X_WF=leapt),
        "given half the authority": replace(last, X_WF=leapt),
    }


def live_edit(c: Combination) -> str:
    """Switched, moved, leapt, made stiffer, more damped, given another law and authority: at rest, then in motion."""
    probe = _place(c.role, c.geometry, "engage" in POLICIES[c.policy].options)
    masters = (False, True) if "admittance" in (c.law, OTHER[c.law]) else (False,)
    motions = {"at rest": (held(probe, 2), False)}
    motions |= {f"in motion{', admittance master' * m}": (_swinging(c, probe), m) for m in masters}
    for words, (motion, damping) in motions.items():
        wrong = _edited(c, probe, motion, damping)
        if wrong:
            return f"{words}, {wrong}"
    return ""


def _edited(c: Combination, probe: Probe, motion: Motion, damping: bool) -> str:
    shape, frame, settings = SPECIMENS[c.geometry].make(), _core.LiveFrame(), edits(c, probe)
    controls = {words: _control(c, setting, shape, motion, damping) for words, setting in settings.items()}
    (before, first), *rest = settings.items()
    bench = Bench(c, first.fixture(c, shape, frame), damping=damping).begin(probe.X)
    now = _run(bench, first, motion, _fading(c))
    for words, setting in rest:
        frame.set(setting.X_WF)
        if np.array_equal(setting.X_WF, settings[before].X_WF):  # else the frame has leapt, and no list was handed over
            bench.take(setting.fixture(c, shape, frame))
        after = _run(bench, setting, motion, _fading(c) + len(motion.X))
        was, becomes = controls[before], controls[words]
        goals = max(_ways(was.X), _ways(becomes.X)) + RETURN_SPEED * DT + 4.0 * RESERVE
        seen = (_seen(c, probe, settings[before]), _seen(c, probe, setting))
        felt = _promised(c, words, seen, motion, was, becomes) + damping * DT * np.array([FORCE_RATE, 0.0])
        wrong = _a_step(c, now, after, felt, goals) or _late(c, after, becomes)
        if wrong:
            return f"{words}: {wrong}"
        now, before = after, words
    return ""


@lru_cache(maxsize=64)
def _smoothly(role: str, geometry: str, X: bytes, along: bytes, far: float) -> Array:
    """(4, 4) so far that a tool at X (4, 4) is deeper then, if all is smooth there; else aside, or out.

    along (3,): up the slope. Both as bytes, to be kept for all laws and policies.
    """
    case, s = ROLES[role], SPECIMENS[geometry]
    here, slope = np.frombuffer(X).reshape(4, 4), np.frombuffer(along)
    up = slope / max(float(np.linalg.norm(slope)), 1e-9)
    side = np.cross(up, np.eye(3)[int(np.argmin(np.abs(up)))])
    for way in (up, side, -side, np.cross(up, side), -np.cross(up, side), -up):
        shift = _shift(far * way / max(float(np.linalg.norm(way)), 1e-9))
        Y = np.linalg.inv(shift) @ here
        if case.speed or smooth(case, s, Y, gradient(case, s, Y)):
            return shift
    raise LookupError(f"no move of {1e3 * far} mm beside a {geometry} that ends where {role} has a smooth answer")


def _fading(c: Combination) -> int:
    """Ticks within which all that an edit changes is over."""
    return max(settle(c), 1600 if ROLES[c.role].turns else round(1.6 * SLOW / DT))


@lru_cache(maxsize=64)
def _place(role: str, geometry: str, engages: bool) -> Probe:
    """Where the hand is: not as wanted; of a fixture that engages by nearness, near enough."""
    case, s = ROLES[role], SPECIMENS[geometry]
    if not engages:
        return probes(role, geometry)[0]
    for probe in probes(role, geometry)[:WRONG]:
        X = brought(case, s, probe.X, -0.85 * ENGAGE * (PER_TURN if case.turns else 1.0))
        if X is not None and smooth(case, s, X, gradient(case, s, X)):
            return probe_at(role, geometry, X)
    raise LookupError(f"no smooth place near the border of {role} beside a {geometry}")


def _swinging(c: Combination, probe: Probe) -> Motion:
    """Round and round the probe, PERIOD ticks a turn; so fast as to be too fast, where speed counts."""
    phase = 2.0 * np.pi * np.arange(PERIOD) / PERIOD
    r = 2.5 * SPEED * PERIOD * DT / (2.0 * np.pi) if ROLES[c.role].speed else SWING
    y = np.column_stack([r * np.sin(phase), r * np.cos(phase), 0.5 * r * np.sin(phase),
                         NOD * np.sin(phase), NOD * np.cos(phase), 0.0 * phase])  # fmt: skip
    X = np.stack([moved(probe.X, row) for row in y])
    way = Motion(np.concatenate([X, X[:1]]), np.zeros((PERIOD + 1, 6))).way
    return Motion(X, 0.5 * (way + np.roll(way, 1, axis=0)) / DT)


def _run(bench: Bench, setting: Setting, motion: Motion, n: int) -> Answer:
    turns = -(-n // len(motion.X))
    X, V = np.tile(motion.X, (turns, 1, 1)), np.tile(motion.V, (turns, 1))
    return bench.run(Motion(X, V), setting.X_WF @ setting.X_FG)


def _control(c: Combination, setting: Setting, shape: _core.Geometry, motion: Motion, damping: bool) -> Answer:
    """The last turn of a run in which nothing is edited, and no rate is limited."""
    frame = _core.LiveFrame()
    frame.set(setting.X_WF)
    made = setting.fixture(c, shape, frame, QUICK)
    bench = Bench(c, made, damping=damping, quick=True).begin(motion.X[0], setting.X_WF @ setting.X_FG)
    n = len(motion.X)
    out = _run(bench, setting, motion, (settle(c) if setting.law_name != "optimise" else SETTLED) + 2 * n)
    return Answer(out.F[-n - 1 :], out.X[-n - 1 :], out.B[-n - 1 :])


def _a_step(c: Combination, now: Answer, after: Answer, felt: Array, goals: float) -> str:
    """felt (2,), goals: what is promised of wrench and goal in a tick."""
    steps = after.steps(now.F[-1]).max(axis=0)
    for step, allowed, unit in zip(steps, felt, ("N", "N m"), strict=True):
        if step > 1.02 * allowed + 1e-6:
            return f"a step of {step:.3g} {unit} in one tick, {allowed:.3g} promised"
    way = _ways(np.concatenate([now.X[-1:], after.X]))
    if POLICIES[c.policy].hard and way > 1.02 * goals:
        return f"the goal jumps by {1e3 * way:.3g} mm in one tick"
    return ""


def _seen(c: Combination, probe: Probe, setting: Setting) -> Probe:
    """The probe, as the fixture has it where it is then."""
    if ROLES[c.role].speed:
        return probe
    return _probe(c.role, c.geometry, (np.linalg.inv(setting.X_WF @ setting.X_FG) @ probe.X).tobytes())


@lru_cache(maxsize=64)
def _probe(role: str, geometry: str, X: bytes) -> Probe:
    return probe_at(role, geometry, np.frombuffer(X).reshape(4, 4))


def _promised(
    c: Combination, words: str, seen: tuple[Probe, Probe], motion: Motion, was: Answer, becomes: Answer
) -> Array:
    """(2,) N and N m in a tick. seen: the probe before and after the edit."""
    controls = np.maximum(was.steps().max(axis=0), becomes.steps().max(axis=0))
    rate = DT * np.array([FORCE_RATE, MOMENT_RATE])
    corrects = c.corrects or LAWS[OTHER[c.law]].together
    if words.startswith(("switched", "given half")) and not corrects and not np.ptp(motion.X, axis=0).any():
        fading = 1.0 / SLOW + (1.0 / LATER if POLICIES[c.policy].ramp else 0.0)
        whole = np.maximum(_sizes(was), _sizes(becomes)) / max(c.share(seen[1].gap), 0.01)
        rate = np.minimum(rate, DT * fading * whole)
    explained = np.maximum(*(_explained(c, probe, motion) for probe in seen))
    return np.asarray(np.maximum(controls, explained) + rate)


def _sizes(answer: Answer) -> Array:
    return np.array([np.linalg.norm(answer.F[:, s], axis=1).max() for s in (slice(0, 3), slice(3, 6))])


def _explained(c: Combination, probe: Probe, motion: Motion) -> Array:
    """(2,) what the stiffest and most damped of the settings make of a motion's ticks: K times the way of the gap."""
    per = np.array([np.linalg.norm(probe.along[s]) for s in (slice(0, 3), slice(3, 6))])
    ways, changes = (
        np.array([np.linalg.norm(rows[:, s], axis=1).max() for s in (slice(0, 3), slice(3, 6))])
        for rows in (motion.way, np.diff(motion.V, axis=0))
    )
    stiffness, damping = (1.5 * K_TURN, 3.0 * B_TURN) if ROLES[c.role].turns else (1.5 * K, 3.0 * B)
    damping = damping / RATIO if "admittance" in (c.law, OTHER[c.law]) else damping
    return np.asarray(per * (stiffness * (per @ ways) + damping * (per @ changes)))


def _ways(X: Array) -> float:
    return float(np.linalg.norm(np.diff(X[:, :3, 3], axis=0), axis=1).max())


def _late(c: Combination, after: Answer, becomes: Answer) -> str:
    """Of the last turn: as if it had always been so.

    A hard limit of speed has a memory: how far its goal trails the hand tells where it began.
    """
    if ROLES[c.role].speed and POLICIES[c.policy].hard:
        return ""
    n = len(becomes.F) - 1
    off = float(np.linalg.norm((after.F[-n:] - becomes.F[-n:]) * WEIGH, axis=1).max())
    size = float(np.linalg.norm(becomes.F * WEIGH, axis=1).max())
    reserve = 2.5 * RESERVE * (K_TURN / LEVER**2 if ROLES[c.role].turns else 1.5 * K) if c.corrects else 0.0
    if off > 0.03 * size + reserve + 1e-5:
        return f"still {off:.3g} N from what it would always have been, {size:.3g} N"
    return ""
