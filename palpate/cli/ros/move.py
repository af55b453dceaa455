"""`palpate ros move`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.console import INTERRUPTED
from palpate.console.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Execute a motion plan on an arm over ROS 2, by CRTK's servo_jp.

    examples:
      palpate ros move plan.yaml --arm PSM1
      palpate ros move plan.yaml --arm PSM1 --speed 0.2 --json moved.json
      palpate ros topic pub /palpate_move_PSM1/pause std_msgs/msg/Empty

    The arm must be enabled, homed, at rest and at the start of the plan, and the plan free in its scene; otherwise
    nothing is sent. Ctrl-C stops within 50 ms. Topics of the node: ~/pause, ~/resume, ~/stop, ~/speed. The exit code is
    0 when the arm has arrived, 1 when the motion was stopped or aborted, 2 when it was refused, 130 after Ctrl-C.
    """

    plan: Positional[Path]
    """Plan file, from palpate plan --out."""
    arm: str
    """Name of the arm on the network, such as PSM1."""
    speed: float = 0.5
    """Pace, 1: as planned [-]."""
    scene: Path | None = None
    """Scene in which the plan must be free; the one for which it was made when left out."""
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
            mover = move.Mover(
                here, self.arm, problem, plan, self.speed, self.rate, lambda text: say(console, f"{self.arm}: {text}")
            )
            with move.interrupted(mover.stop) as signals:
                say(console, f"{self.arm}: moving for {plan.duration_s / self.speed:.1f} s; Ctrl-C stops it")
                console.file.flush()
                moved = mover.run()
        words = "arrived" if moved.success else f"{moved.phase} at {moved.along_s:.2f} of {moved.duration_s:.2f} s"
        why = f": {moved.reason}" if moved.reason else ""
        say(console, f"{self.arm}: {words}{why}; at most {1e3 * moved.path_error_m:.2f} mm from the path")
        write_json(self.json, moved)
        if signals and not moved.success:
            return INTERRUPTED
        return 0 if moved.success else 1

    def _scene(self, named: str) -> Path:
        from palpate.errors import PlanningError

        if self.scene is None and not named:
            raise PlanningError("the plan does not name its scene", where=str(self.plan), mend="add --scene SCENE")
        return self.scene or Path(named)
