"""`palpate ros move`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tyro.conf import Positional, arg

from palpate.cli.terminal import INTERRUPTED
from palpate.cli.terminal.output import console_for, require_writable, say, write_json

if TYPE_CHECKING:
    from palpate.planning import Plan, Problem
    from palpate.ros.moving import Moving


@dataclass
class Command:
    """Execute a motion plan on an arm over ROS 2, by CRTK's servo_jp or move_jp.

    examples:
      palpate ros move plan.yaml --arm PSM1
      palpate ros move plan.yaml --arm PSM1 --speed 0.2 --json moved.json
      palpate ros move plan.yaml --arm PSM1 --by move_jp
      palpate ros topic pub /palpate_move_PSM1/pause std_msgs/msg/Empty

    The arm must be enabled, homed, at rest and at the start of the plan, and the plan free in its scene; otherwise
    nothing is sent. Ctrl-C stops it. Topics of the node: ~/pause, ~/resume, ~/stop, ~/speed. The exit code is
    0 when the arm has arrived, 1 when the motion was stopped or aborted, 2 when it was refused, 130 after Ctrl-C.
    """

    plan: Positional[Path]
    """Plan file, from palpate plan --out."""
    arm: str
    """Name of the arm on the network, such as PSM1."""
    by: Literal["servo_jp", "move_jp"] = "servo_jp"
    """servo_jp: a stream of goals along the whole path; move_jp: way points, between which the arm moves by itself."""
    speed: float = 0.5
    """Pace, 1: as planned; by move_jp: ratio of the arm's own speed and acceleration [-]."""
    scene: Path | None = None
    """Scene in which the plan must be free; the one for which it was made when left out."""
    clearance: str | None = None
    """With --by move_jp: clearance that the arm keeps between way points, e.g. 2.5mm; the plan's when left out."""
    rate: Annotated[float | None, arg(metavar="HZ")] = None
    """Rate of the goals, 20 to 500 [Hz]; when left out, that of the arm's measurements, but no more than 200."""
    network: bool = False
    """Communicate with other machines; otherwise only within this one."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the result as JSON (docs/json/ros.md); - for the standard output."""

    def __call__(self) -> int:
        """Move, and print what came of it; returns the exit code."""
        from palpate.planning import Problem, load
        from palpate.ros import move, topic
        from palpate.scene import Scene

        console = console_for(self.json)
        require_writable(self.json)
        plan = load(self.plan)
        problem = Problem.of(Scene.load(self._scene(plan.scene)), plan.arm)
        with topic.node(self.network, f"palpate_move_{self.arm}") as here:
            mover = self._mover(here, problem, plan, lambda text: say(console, f"{self.arm}: {text}"))
            with move.interrupted(mover.stop) as signals:
                say(console, f"{self.arm}: moving {mover.expectation}; Ctrl-C stops it")
                console.file.flush()
                moved = mover.run()
        words = "arrived" if moved.success else f"{moved.phase} at {moved.along_s:.2f} of {moved.duration_s:.2f} s"
        why = f": {moved.reason}" if moved.reason else ""
        say(console, f"{self.arm}: {words}{why}; at most {1e3 * moved.path_error_m:.2f} mm from the path")
        write_json(self.json, moved)
        if signals and not moved.success:
            return INTERRUPTED
        return 0 if moved.success else 1

    def _mover(self, here: Any, problem: Problem, plan: Plan, on_change: Callable[[str], None]) -> Moving:
        from palpate.base.errors import PalpateError
        from palpate.planning import goals
        from palpate.ros.move import Mover
        from palpate.ros.move_goals import GoalMover

        streamed = self.by == "servo_jp"
        if self.rate is not None and not streamed:
            raise PalpateError("--rate has no effect with --by move_jp: the arm interpolates", mend="leave it out")
        if self.clearance is not None and streamed:
            raise PalpateError(
                "--clearance has no effect with --by servo_jp: the path is the plan's", mend="leave it out"
            )
        if streamed:
            return Mover(here, self.arm, problem, plan, self.speed, self.rate, on_change)
        return GoalMover(
            here, self.arm, problem, plan, self.speed, on_change, goals.length(self.clearance, "--clearance")
        )

    def _scene(self, named: str) -> Path:
        from palpate.base.errors import PlanningError

        if self.scene is None and not named:
            raise PlanningError("the plan does not name its scene", where=str(self.plan), mend="add --scene SCENE")
        return self.scene or Path(named)
