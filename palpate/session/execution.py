"""Plans executed by the follower of a session: the cycle moves it, a thread beside the cycle looks at the world ahead.

    execution = session.execute(plan, speed=0.5)
    execution.pause(); execution.resume(); execution.stop()      # the tool rests within 50 ms, on the plan's path

The cycle (`core/palpate/loop/execution.hpp`) moves the goal only up to the time along the plan for which this module
has proved the plan free in the newest world. Where the proofs stop coming, the tool comes to rest by itself.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.errors import PlanningError, StateError
from palpate.record.ticks import Ticks
from palpate.session import machine

if TYPE_CHECKING:
    from palpate.planning.live_world import Neighbour
    from palpate.planning.problem import Problem
    from palpate.planning.result import Plan
    from palpate.scene.rig import Rig
    from palpate.sensing.sensing import Sensing

PERIOD: Final = 0.02
"""Period at which the world ahead is looked at [s]."""
HORIZON: Final = 0.5
"""Time along the plan that is proved ahead in a world that has changed [s]."""
GUARD: Final = 1.0
"""Contact force on the tool that stops a motion [N]."""
_DT = 2e-3  # between the rows of joint positions that the cycle receives [s]
PHASES: Final = ("none", "moving", "done", "stopped", "stopped", "aborted", "aborted", "aborted")
"""What an execution does, by the number in the signal ``execution``."""
_REASONS: Final = (
    "", "", "", "", "a pedal, a hold or a fault ended the motion", "the tool touched something",
    "a hard fixture does not allow the motion", "the tool was not at the start of the plan",
)  # fmt: skip


class Executor(Protocol):
    """A loop that executes planned motions."""

    def execute(self, q: Array, v: Array, dt: float, levers: Array, pace: float, until: float, guard: float) -> int:
        """Give the follower a motion; returns its number."""
        ...

    def order(self, motion: int, pace: float, until: float, stop: bool, guard: float) -> None:
        """Replace the order about a motion."""
        ...


class PlanExecution:
    """One plan on the follower of a session. Its methods may be called from any thread.

    Args:
        executor: the loop.
        latest: returns its newest tick.
        plan: the plan.
        ahead: proves what lies ahead, and its world at a tick.
        speed: pace, 0 < speed <= 1.
        guard: contact force that stops the motion [N].
    """

    def __init__(
        self, executor: Executor, latest: Callable[[], Ticks], plan: Plan, ahead: Ahead, speed: float, guard: float
    ) -> None:
        from palpate.planning.ahead import require_speed

        self._executor, self._latest, self._ahead, self._guard = executor, latest, ahead, guard
        self.plan = plan
        self._lock = threading.Lock()
        self._speed, self._paused, self._stop, self._why = require_speed(speed), False, False, ""
        count = max(2, int(np.ceil(plan.duration_s / _DT)) + 1)
        dt = plan.duration_s / (count - 1)
        q, v, _ = plan.trajectory.at(np.linspace(0.0, plan.duration_s, count))
        self._until, self._looked_at = ahead.until(0.0), -np.inf
        self.number = executor.execute(q, v, dt, plan.scale, self._speed, self._until, guard)
        """Number of the motion in the signal ``execution_motion``."""

    @property
    def phase(self) -> str:
        """waiting, moving, paused, done, stopped or aborted."""
        return self._phase(self._latest())

    def _phase(self, tick: Ticks) -> str:
        if int(tick["execution_motion"]) != self.number:
            return "waiting"
        phase = PHASES[int(tick["execution"])]
        if phase == "moving":
            return "paused" if self._paused else phase
        return "aborted" if phase == "stopped" and self._why else phase

    @property
    def reason(self) -> str:
        """Why the motion ended before its goal; empty if it did not."""
        tick = self._latest()
        return self._why or (_REASONS[int(tick["execution"])] if self._phase(tick) != "waiting" else "")

    @property
    def time(self) -> float:
        """Time along the plan [s]."""
        tick = self._latest()
        return float(tick["execution_t"]) if self._phase(tick) != "waiting" else 0.0

    @property
    def over(self) -> bool:
        """True when the motion has ended for good, and the tool rests."""
        tick = self._latest()
        at_rest = machine.name_of(float(tick["session_state"])) != "executing"
        return at_rest and self._phase(tick) in ("done", "stopped", "aborted")

    def words(self) -> str:
        """What became of the motion, as a line for people."""
        why = f": {self.reason}" if self.reason else ""
        return f"plan: {self.phase} at {self.time:.2f} of {self.plan.duration_s:.2f} s{why}"

    @property
    def speed(self) -> float:
        """Pace of the motion, 1: as planned."""
        return self._speed

    @speed.setter
    def speed(self, value: float) -> None:
        from palpate.planning.ahead import require_speed

        with self._lock:
            self._speed = require_speed(value)
            self._send()

    def pause(self) -> None:
        """Come to rest within 50 ms; `resume` goes on."""
        with self._lock:
            self._paused = True
            self._send()

    def resume(self) -> None:
        """Go on after a pause."""
        with self._lock:
            self._paused = False
            self._send()

    def stop(self, why: str = "") -> None:
        """Come to rest within 50 ms for good; `why` makes it an abort."""
        with self._lock:
            self._stop, self._why = True, self._why or why
            self._send()

    def look(self) -> None:
        """Prove what lies ahead in the newest world, or abort; called beside the loop every `PERIOD`."""
        tick, time = self._latest(), self.time
        if self.over or self._stop or float(tick["t"]) < self._looked_at + PERIOD - 1e-9:
            return
        self._looked_at = float(tick["t"])
        why = self._ahead.prove(tick, time)
        with self._lock:
            self._until = self._ahead.until(time)
            self._stop, self._why = self._stop or bool(why), self._why or why
            self._send()

    def _send(self) -> None:
        pace = 0.0 if self._paused else self._speed
        self._executor.order(self.number, pace, self._until, self._stop, self._guard)


class Ahead:
    """What is proved ahead of a motion, in the world of a run."""

    def __init__(
        self, problem: Problem, plan: Plan, rig: Rig, sensing: Sensing | None, neighbours: Sequence[Neighbour]
    ) -> None:
        from palpate.planning import ahead
        from palpate.planning.live_world import LiveWorld

        self._duration = plan.duration_s
        self._world = LiveWorld(problem, rig, None if sensing is None else sensing.clouds, neighbours)
        self._ahead = ahead.Ahead(problem.robot, plan)

    def prove(self, tick: Ticks, time: float, whole: bool = False) -> str:
        """Prove `HORIZON` ahead of a time along the plan [s], or all of it; why it is not free, in words."""
        end = self._duration if whole else min(time + HORIZON, self._duration)
        return self._ahead.prove(self._world.at(tick), time, end)

    def until(self, time: float) -> float:
        """Time along the plan up to which the tool may move [s]."""
        proved = max(self._ahead.until, time)
        return min(proved, time + HORIZON) if self._world.changes and proved < self._duration else proved


def begin(
    loop: Any, rig: Rig, sensing: Sensing | None, latest: Callable[[], Ticks], plan: Plan, speed: float,
    guard: float, problem: Problem | None, neighbours: Sequence[Neighbour] = (),
) -> PlanExecution:  # fmt: skip
    """Begin a plan on the follower of a loop; see `Session.execute`. neighbours: as for `LiveWorld`."""
    from palpate.planning import ahead
    from palpate.planning.problem import Problem

    if not isinstance(loop, _core.Simulation):
        raise StateError("this session executes no plans: its follower is no simulated arm with joints",
                         mend="on an arm over ROS 2: palpate ros move plan.yaml --arm PSM1")  # fmt: skip
    if not (np.isfinite(guard) and guard >= 0.0):
        raise PlanningError(f"the guard must be a force of 0 N or more. Got: {guard!r}", mend="e.g. 1.0")
    tick = latest()
    begun = int(tick["session_state"]) != 0 or float(tick["t"]) > 0.0
    state = machine.name_of(float(tick["session_state"]))
    if begun and not any(at == state and cause == "execute" for at, cause, _ in machine.TRANSITIONS):
        raise StateError(f"no plan is executed while the session is {state}", why=machine.STATES[state],
                         mend="execute in homed or following")  # fmt: skip
    controls = loop.controls
    if controls.clutch or controls.camera or not controls.operator_present:
        pressed = "clutch" if controls.clutch else "camera"
        what = f"the pedal {pressed} is down" if controls.clutch or controls.camera else "no operator is at the console"
        raise StateError(f"no plan is executed while {what}", mend="release it, or come back, and execute again")
    problem = problem or Problem.of(rig.scene, rig=rig)
    ahead.require_arm(problem, plan)
    q = np.asarray(tick["q_follower_goal"])[: problem.robot.arm.n] if begun else rig.arms.q_follower0
    ahead.require_start(plan, q)
    jaw = float(tick["jaw"]) if begun else rig.scene.arms.follower.jaw.start
    problem = replace(problem, robot=problem.robot.with_jaws(jaw, jaw))  # the jaws hold their angle during the motion
    proofs = Ahead(problem, plan, rig, sensing, neighbours)
    why = proofs.prove(tick, 0.0, whole=True)
    low, high = plan.jaw
    if why and not low - 1e-3 <= jaw <= high + 1e-3:
        raise PlanningError(f"the jaws are at {jaw:.3f} rad, and the plan is not free with them", why=why,
                            mend=f"it was proved for {low:.3f} to {high:.3f} rad: bring the jaws there, or plan again "
                            "with planning.jaw: [low, high]")  # fmt: skip
    if why:
        raise PlanningError("the scene has changed and the plan is not free in it", why=why, mend="plan again")
    return PlanExecution(loop, latest, plan, proofs, speed, guard)
