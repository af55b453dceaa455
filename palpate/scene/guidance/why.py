"""Explains in words which fixture and which term made a recorded force. The core computes the numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.arrays.so3 import pose
from palpate.scene.guidance.context import FixtureContext
from palpate.scene.guidance.fixture import Fixture
from palpate.scene.guidance.reasons import SMALL

_LEAST = 5e-4  # smaller contributions are not listed [N, N m]
_LEVER = 0.02  # length that makes a moment comparable to a force [m], as in core/palpate/guidance/guidance.cpp
_DT, _TICKS = 1e-3, 200  # period [s] and number of ticks of the repeated guidance stage


@dataclass(frozen=True)
class Contribution:
    """Contribution of one fixture to the wrench on the tool, after authority, quadratic program and priorities."""

    name: str
    F: Array
    """(6,) force [N] over moment [N m], in W."""
    authority: float = 1.0
    F_taken_over: Array = field(default_factory=lambda: np.zeros(6))
    """(6,) part of F with which the tool was pressed against a hard fixture when this began to hold the tool."""


@dataclass(frozen=True)
class OperatorInput:
    """Inputs of the operator to the fixtures of a run."""

    V_WT: Array = field(default_factory=lambda: np.zeros(6))
    """(6,) velocity of the tool commanded by the hand, in W [m/s, rad/s]."""
    pedal: float = 1.0
    """position of the guidance pedal, 0 to 1."""
    force: float = -1.0
    """force of the hand measured by a load cell [N]; negative without a load cell."""


def terms(
    fixtures: Sequence[Fixture], tick: Any, context: FixtureContext, hand: OperatorInput | None = None
) -> list[Contribution]:
    """Contribution of each fixture at a tick of a run, and last the residual: their sum is the recorded wrench.

    The guidance stage runs at the tick's pose until all transients have settled. What a hard fixture took over when it
    began to hold the tool is not known from one tick: it acts along the wrench of this fixture and is fitted to what
    the recorded wrench has beyond the others. The residual contains the other effects that depend on the history of
    the run: moving ramps, the rate limit, parts of the motion that `hand` lacks, and the joint limits of the follower,
    which move a goal corrected by hard fixtures.

    Args:
        fixtures: of the run, in their order.
        tick: signals of the run by name.
        context: files, frames, places and objects that the fixtures name.
        hand: inputs of the operator; when left out: at rest, pedal pressed, no load cell.
    """
    from palpate import _guidance

    quick = [f.model_copy(update={"rise": 0.01, "fall": 0.01}) for f in fixtures]
    made = _guidance.Fixtures([f.make(context) for f in quick], context.tool)
    # The hard fixtures begin to hold the tool with nothing that presses it, so that they take over nothing.
    first = _guidance.Fixtures(
        [f.model_copy(update={"enabled": f.enabled and f.hard}).make(context) for f in quick], context.tool
    )
    options = _core.GuidanceOptions()
    options.force_rate = options.moment_rate = 1e6
    options.return_speed = (
        0.9  # slower than a jump within one period: an initial violation is corrected by the last tick
    )
    options.servo_bandwidth = 0.0
    stage = _guidance.Guidance(options, _DT)
    stage.take(first)
    X = _commanded_pose(tick)
    hand = hand or OperatorInput()
    X_tool = X
    contact = np.asarray(tick["F_T_W"])
    t = float(tick["t"])
    begin = t - _settling_time(fixtures)
    for when, F_T_W in [*[(begin, np.zeros(3))] * _TICKS, (begin, contact), *[(t, contact)] * _TICKS]:
        if F_T_W is contact and when == begin:
            stage.take(made)
        out = stage.step(when, X, hand.V_WT, X_tool, F_T_W=F_T_W, pedal=hand.pedal, F_hand=hand.force)
        X_tool = out["X_WT_goal"]
    F = np.array([stage.wrench(i) for i in range(len(fixtures))]).reshape(-1, 6)
    residual = np.r_[tick["F_guidance_W"], tick["t_guidance_W"]] - F.sum(axis=0)
    more = _taken_over(fixtures, F, residual)
    found = [
        Contribution(f.name or f.role.name, F[i] + more[i], stage.authority(i), more[i]) for i, f in enumerate(fixtures)
    ]
    return [*found, Contribution("residual", residual - more.sum(axis=0))]


def _taken_over(fixtures: Sequence[Fixture], F: Array, residual: Array) -> Array:
    """(n, 6) part of the residual along the wrench of each hard fixture, beyond what F (n, 6) has of it."""
    scale = np.r_[np.ones(3), np.full(3, 1.0 / _LEVER)]
    size = np.linalg.norm(F * scale, axis=1)
    hard = np.array([f.hard for f in fixtures], dtype=bool) & (size > SMALL)
    along = np.where(hard, 1.0 / np.maximum(size, SMALL), 0.0)[:, None] * F
    share = np.linalg.lstsq((along * scale).T, residual * scale, rcond=1e-6)[0] if len(F) else np.zeros(0)
    return np.asarray(share[:, None] * along)


def _settling_time(fixtures: Sequence[Fixture]) -> float:
    """Time after engagement at which every ramp by time has ended [s]."""
    ends = [max(ramp.start, ramp.end) for f in fixtures for ramp in f.ramps if ramp.by == "time"]
    return max(ends, default=0.0) + 1.0


def explain_tick(
    fixtures: Sequence[Fixture], tick: Any, context: FixtureContext, hand: OperatorInput | None = None
) -> str:
    """Explain the guidance force at a tick of a run: the sum, all contributions, and the largest in detail.

    Every fixture is evaluated at the commanded tool pose before correction. Arguments as for `terms`.
    """
    force, index = float(np.linalg.norm(tick["F_guidance_W"])), int(tick["guidance_fixture"])
    correction = np.asarray(tick["p_correction_W"], dtype=np.float64)
    lines = []
    if np.linalg.norm(correction) > SMALL:
        lines.append(f"hard fixtures hold the tool's goal back by {1e3 * np.linalg.norm(correction):.3g} mm")
    if not 0 <= index < len(fixtures):
        return "\n".join([*lines, "no fixture applies a force"])
    lines.append(f"guidance applies {force:.3g} N, most of it from {fixtures[index].name}")
    hand = hand or OperatorInput()
    parts = terms(fixtures, tick, context, hand)
    lines += [_describe(term) for term in parts if np.abs(term.F).max() > _LEAST]
    return "\n".join([*lines, fixtures[index].why(_commanded_pose(tick), hand.V_WT, float(tick["t"]), context)])


def _commanded_pose(tick: Any) -> Array:
    """Commanded tool pose (4, 4) from the mapping, before correction."""
    return pose(np.asarray(tick["p_WT_goal"]) - np.asarray(tick["p_correction_W"]), tick["quat_WT_asked"])


def _describe(term: Contribution) -> str:
    f, m = term.F[:3], term.F[3:]
    authority = f", at {100.0 * term.authority:.3g} % of its authority" if term.authority < 1.0 else ""
    moment = f" and {1e3 * np.linalg.norm(m):.3g} mN m" if np.linalg.norm(m) > 1e-6 else ""
    taken = float(np.linalg.norm(term.F_taken_over[:3]))
    before = f", {taken:.3g} N of it taken over from what pressed the tool against it" if taken > _LEAST else ""
    return f"  {term.name}: ({', '.join(f'{x:+.3f}' for x in f)}) N{moment}{authority}{before}"
