"""`palpate bench execution`: how long a planned motion takes to rest after a stop, over many stops at full speed."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import PalpateError
from palpate.planning.problem import Problem
from palpate.planning.result import Plan
from palpate.record.ticks import Ticks
from palpate.scene import Scene
from palpate.scene.rig import Rig, build
from palpate.session import Session

if TYPE_CHECKING:
    from rich.table import Table

SCENE, GOAL = "planning", "behind-gallbladder"
REST = 1e-4
"""Distance of the tip from its last position below which the tool rests [m]."""
SLOW = 1e-3
"""Speed of the tip below which the tool rests [m/s]."""
RESTS = {"goal": "goal rests", "tool": "tool within 0.1 mm", "slow": "tool below 1 mm/s"}
"""What rests, by the keys of the rows."""
_WINDOW = 5  # ticks before and after, over which the speed is a mean: one encoder count in 1 ms would be 1.3 mm/s
_AFTER = 0.15  # time that is looked at after a request [s]


def run(stops: int = 100, on_progress: Callable[[str], None] = lambda _: None) -> list[dict[str, Any]]:
    """Rows for lockstep and for real time: times [s] from the request until the goal, and the tool, rest."""
    rig = build(Scene.load(SCENE))
    problem = Problem.of(rig.scene, rig=rig)
    plan = problem.plan("current", GOAL, timeout=60.0)
    fastest = _fastest(plan, stops)
    rows = []
    for mode, one in (("lockstep", _lockstep), ("real time", _realtime)):
        times = np.array([one(rig, problem, plan, t) for t in fastest])
        rows.append(row(mode, times, _speed(problem, plan, fastest)))
        worst = 1e3 * rows[-1]["slow_worst_s"]
        on_progress(f"{mode}: the tool rests after {worst:.1f} ms at worst, of {stops} stops")
    return rows


def row(mode: str, times: Array, speed: float) -> dict[str, Any]:
    """The keys of a row. times (stops, 3): as of `rested` [s]; speed: of the tip at the stops [m/s]."""
    made: dict[str, Any] = {"mode": mode, "stops": len(times), "speed_m_s": speed}
    for k, what in enumerate(RESTS):
        made |= {f"{what}_median_s": float(np.median(times[:, k])), f"{what}_worst_s": float(times[:, k].max())}
    return made


def _fastest(plan: Plan, count: int) -> Array:
    """Times along a plan [s] at which its tip is fastest, spread over the fastest tenth."""
    t = np.linspace(0.0, plan.duration_s, 4000)
    speed = np.linalg.norm(plan.scale * plan.trajectory.at(t)[1], axis=1)
    best = np.sort(t[np.argsort(-speed)[:400]])
    return np.asarray(best[np.linspace(0, len(best) - 1, count).astype(int)])


def _speed(problem: Problem, plan: Plan, times: Array) -> float:
    """Mean speed of the tip [m/s] at the times of the stops."""
    q, v, _ = plan.trajectory.at(times)
    arm = problem.robot.arm
    return float(np.mean([np.linalg.norm(arm.jacobian(a)[:3] @ b) for a, b in zip(q, v, strict=True)]))


def _lockstep(rig: Rig, problem: Problem, plan: Plan, t: float) -> tuple[float, float, float]:
    session = Session(rig.scene, rig=rig)
    session.change(following=False)
    execution = session.execute(plan, problem=problem)
    session.step(max(1, round(t * session.rate)))
    asked = float(session.latest()["t"])
    execution.stop()
    return _rested(np.array([session.step().tick for _ in range(round(_AFTER * session.rate))]), asked)


class _Watched(Session):
    """A session that keeps all ticks of its loop."""

    def __init__(self, rig: Rig) -> None:
        super().__init__(rig.scene, rig=rig)
        self.rows: list[Ticks] = []

    def _take(self, ticks: Ticks, realtime: bool = False) -> None:
        self.rows.append(ticks)
        super()._take(ticks, realtime)


def _realtime(rig: Rig, problem: Problem, plan: Plan, t: float) -> tuple[float, float, float]:
    """The request comes from this thread, at any moment between two ticks; all ticks of the loop are looked at."""
    session = _Watched(rig)
    session.change(following=False)
    execution = session.execute(plan, problem=problem)
    session.start()
    try:
        while execution.time < t:
            time.sleep(1e-3)
        asked = float(session.latest()["t"])
        execution.stop()
        time.sleep(2.0 * _AFTER)
    finally:
        session.stop()
    ticks = np.concatenate(session.rows)
    return _rested(ticks[(ticks["t"] >= asked) & (ticks["t"] < asked + _AFTER)], asked)


def rested(t: Array, goal: Array, p: Array, speed: Array) -> tuple[float, float, float]:
    """Times [s] after which the goal (k, n), the place (k, 3) [m] and the speed (k,) [m/s] of the tip rest for good.

    t: times (k,) after the request [s].

    Raises:
        PalpateError: the arm does not rest within these times.
    """
    away = np.abs(goal - goal[-1]).max(axis=1) > 0.0, np.linalg.norm(p - p[-1], axis=1) > REST, speed > SLOW
    last = [int(np.nonzero(moving)[0].max(initial=-1)) + 1 for moving in away]
    if max(last) >= len(t):
        raise PalpateError(f"the arm does not rest within {t[-1]:.2f} s of a stop", mend="try a less busy machine")
    return float(t[last[0]]), float(t[last[1]]), float(t[last[2]])


def _rested(ticks: Ticks, asked: float) -> tuple[float, float, float]:
    t, p = ticks["t"] - asked, ticks["p_WT"]
    before, after = (np.clip(np.arange(len(t)) + k, 0, len(t) - 1) for k in (-_WINDOW, _WINDOW))
    speed = np.linalg.norm(p[after] - p[before], axis=1) / (t[after] - t[before])
    return rested(t, ticks["q_follower_goal"], p, speed)


def table(rows: list[dict[str, Any]]) -> Table:
    """The rows as a table."""
    from rich.table import Table

    made = Table("loop", "stops", "speed [mm/s]", *(f"{words}: median, worst [ms]" for words in RESTS.values()))
    for row in rows:
        times = [f"{1e3 * row[f'{what}_median_s']:.1f}, {1e3 * row[f'{what}_worst_s']:.1f}" for what in RESTS]
        made.add_row(row["mode"], str(row["stops"]), f"{1e3 * row['speed_m_s']:.0f}", *times)
    return made
