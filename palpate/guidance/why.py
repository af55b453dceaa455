"""Which term made this force? In words; the numbers are the core's own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from palpate import _core
from palpate.arrays import Array
from palpate.arrays.so3 import pose
from palpate.guidance.fixture import Fixture
from palpate.guidance.here import Here
from palpate.guidance.reasons import SMALL

_TOLD = 5e-4  # what adds less is not told [N, N m]
_DT, _TICKS = 1e-3, 200  # of the stage that is asked anew


@dataclass(frozen=True)
class Term:
    """What one fixture adds to the wrench on the tool, after authority, quadratic program and priorities."""

    name: str
    F: Array
    """(6,) force [N] over moment [N m], in W."""
    authority: float = 1.0


@dataclass(frozen=True)
class Hand:
    """What the fixtures of a run were told of the operator."""

    V_WT: Array = field(default_factory=lambda: np.zeros(6))
    """(6,) of the tool as the hand moves it, in W [m/s, rad/s]."""
    pedal: float = 1.0
    """of guidance, 0 to 1."""
    force: float = -1.0
    """by a load cell [N]; below zero: there is none."""


def terms(fixtures: Sequence[Fixture], tick: Any, here: Here, hand: Hand | None = None) -> list[Term]:
    """What each fixture adds at a tick of a run, and last what is left: they sum up to the recorded wrench.

    The stage itself is asked, at rest at the tick's pose until nothing fades any more. Left is what only the run knows:
    ramps on their way, the limit of the rate, the share of a motion that is not given, the limits of the follower's
    joints, which lead a goal on that hard fixtures correct.

    Args:
        fixtures: of the run, in their order.
        tick: signals of the run by their names.
        here: what the names in them stand for.
        hand: that was there; at rest, the pedal down and no load cell when left out.
    """
    made = _core.Fixtures([f.model_copy(update={"rise": 0.01, "fall": 0.01}).make(here) for f in fixtures], here.tool)
    options = _core.GuidanceOptions()
    options.force_rate = options.moment_rate = 1e6
    options.return_speed = 0.9  # less than a leap in a period: what was wrong when it came is mended by then
    options.servo_bandwidth = 0.0
    stage = _core.Guidance(options, _DT)
    stage.take(made)
    X = _mapped(tick)
    hand = hand or Hand()
    X_tool = X
    more: dict[str, Any] = {"F_T_W": np.asarray(tick["F_T_W"]), "pedal": hand.pedal, "F_hand": hand.force}
    t = float(tick["t"])
    for when in [t - _ramped(fixtures), *[t] * _TICKS]:
        X_tool = stage.step(when, X, hand.V_WT, X_tool, **more)["X_WT_goal"]
    told = [Term(f.name or f.role.name, stage.wrench(i), stage.authority(i)) for i, f in enumerate(fixtures)]
    left = np.r_[tick["F_guidance_W"], tick["t_guidance_W"]] - sum((term.F for term in told), np.zeros(6))
    return [*told, Term("what is left", left)]


def _ramped(fixtures: Sequence[Fixture]) -> float:
    """How long ago fixtures have to be engaged for every ramp by time to have come to its end [s]."""
    ends = [max(ramp.start, ramp.end) for f in fixtures for ramp in f.ramps if ramp.by == "time"]
    return max(ends, default=0.0) + 1.0


def of_tick(fixtures: Sequence[Fixture], tick: Any, here: Here, hand: Hand | None = None) -> str:
    """What guidance did at a tick of a run: the sum, what each fixture adds to it, and how the most of it comes about.

    Every fixture is asked where the hand sends the tool: at the goal as it was mapped, before it was corrected. As
    `terms`.
    """
    force, index = float(np.linalg.norm(tick["F_guidance_W"])), int(tick["guidance_fixture"])
    held = np.asarray(tick["p_correction_W"], dtype=np.float64)
    lines = []
    if np.linalg.norm(held) > SMALL:
        lines.append(f"hard fixtures hold the tool's goal back by {1e3 * np.linalg.norm(held):.3g} mm")
    if not 0 <= index < len(fixtures):
        return "\n".join([*lines, "no fixture pulls"])
    lines.append(f"guidance pulls with {force:.3g} N; most of it is {fixtures[index].name}'s")
    hand = hand or Hand()
    parts = terms(fixtures, tick, here, hand)
    lines += [_told(term) for term in parts if np.abs(term.F).max() > _TOLD]
    return "\n".join([*lines, fixtures[index].why(_mapped(tick), hand.V_WT, float(tick["t"]), here)])


def _mapped(tick: Any) -> Array:
    """(4, 4) the tool's goal as it was mapped, before it was corrected."""
    return pose(np.asarray(tick["p_WT_goal"]) - np.asarray(tick["p_correction_W"]), tick["quat_WT_asked"])


def _told(term: Term) -> str:
    f, m = term.F[:3], term.F[3:]
    share = f", at {100.0 * term.authority:.3g} % of its authority" if term.authority < 1.0 else ""
    moment = f" and {1e3 * np.linalg.norm(m):.3g} mN m" if np.linalg.norm(m) > 1e-6 else ""
    return f"  {term.name}: ({', '.join(f'{x:+.3f}' for x in f)}) N{moment}{share}"
