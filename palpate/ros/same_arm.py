"""Is the arm on the network the one for which a motion was proved? It is asked itself, before anything is sent.

Its name, the number and order of its joints, where its tip is at its present joints (kinematics and instrument), where
it reports its base to stand, and the instrument that it announces are compared with the plan's arm.
"""

from __future__ import annotations

import re
import time
from typing import TYPE_CHECKING, Any

import numpy as np

from palpate.base.arrays import Array, rigid
from palpate.base.arrays.so3 import pose
from palpate.base.errors import PlanningError
from palpate.planning.sound import apart
from palpate.ros import topic
from palpate.ros.crtk_arm import FIND, CrtkArm

if TYPE_CHECKING:
    from palpate.planning.problem import Problem
    from palpate.planning.result import Plan

TIP = (1e-3, 0.02)
"""Largest difference between the tip that an arm reports and the model's at the same joints [m, rad]."""
BASE = (2e-3, 0.01)
"""Largest difference between the base that an arm reports and the scene's [m, rad]."""
_TOOL = 0.3  # time in which a latched instrument type arrives [s]


def require_name(plan: Plan, name: str) -> None:
    """Refuse an arm of another name than the plan's; both may have a namespace.

    Raises:
        PlanningError: the names differ.
    """
    if name.strip("/").rsplit("/", 1)[-1] != plan.arm.strip("/").rsplit("/", 1)[-1]:
        raise PlanningError(
            f"the plan was proved for {plan.arm}, not for {name}",
            why="another arm stands elsewhere, and may hold another instrument",
            mend=f"--arm {plan.arm}, or plan in a scene whose planning.arm is {name}",
        )


class SameArm:
    """Listens to what an arm reports about itself.

    Args:
        here: a node, which its owner spins.
        arm: the arm.
    """

    def __init__(self, here: Any, arm: CrtkArm) -> None:
        from geometry_msgs.msg import PoseStamped
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from std_msgs.msg import String

        self._here, self._arm = here, arm
        self._poses: dict[str, tuple[Array, Array]] = {}  # by topic: pose, and the joints when it came
        self._tool = ""
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        for name in ("measured_cp", "local/measured_cp"):
            here.create_subscription(PoseStamped, f"/{arm.name}/{name}", lambda m, name=name: self._keep(name, m), 1)
        here.create_subscription(String, f"/{arm.name}/tool_type", self._keep_tool, latched)

    def require(self, problem: Problem, plan: Plan) -> str:
        """Compare the arm with the plan's; returns a note on what the arm does not report, or an empty text.

        Raises:
            PlanningError: the arm is another one; the message names the difference.
        """
        name, model = self._arm.name, problem.robot.arm
        names = self._arm.joint_names
        if names and names != tuple(plan.joint_names) and sorted(names) == sorted(plan.joint_names):
            raise PlanningError(
                f"{name} reports its joints in the order {', '.join(names)}",
                why=f"the plan has them as {', '.join(plan.joint_names)}", mend="plan for this arm",
            )  # fmt: skip
        self._await_poses()
        self._require_tool(problem)
        if not self._poses:
            return f"{name} reports no measured_cp: kinematics, instrument and base are the scene's word alone"
        local = self._poses.get("local/measured_cp")
        measured, q = local or self._poses["measured_cp"]
        moved, turned = apart(model.fk(q), measured)
        base = self._base(model)
        if local is not None and not _near((moved, turned), TIP):
            raise PlanningError(
                f"the tip of {name} is {1e3 * moved:.1f} mm and {np.degrees(turned):.1f} deg from where the plan's "
                f"model {model.name} has it at the same joints",
                why="it is another arm, or holds another instrument", mend="plan with the model of this arm",
            )  # fmt: skip
        if base is None or _near(apart(np.eye(4), base), BASE):
            return f"{name} does not report where its base stands: the scene's arms.follower.base counts"
        away = apart(problem.robot.X_WB, base)
        if not _near(away, BASE):
            p = ", ".join(f"{x:.4f}" for x in base[:3, 3])
            raise PlanningError(
                f"{name} reports its base {1e3 * away[0]:.1f} mm and {np.degrees(away[1]):.1f} deg from where the plan "
                f"has it: at ({p}) m",
                why="its measured_cp differs by this from the model's tip (set_base_frame, setup joints)",
                mend="give arms.follower.base this pose and plan again, or set the arm's base frame",
            )  # fmt: skip
        return ""

    def _base(self, model: Any) -> Array | None:
        """Pose (4, 4) of the arm's base in the frame of measured_cp; None without that topic."""
        if "measured_cp" not in self._poses:
            return None
        measured, q = self._poses["measured_cp"]
        return np.asarray(measured @ rigid.inverse(model.fk(q)))

    def _require_tool(self, problem: Problem) -> None:
        """Refuse another instrument than the model's, where both are known."""
        number, expected = re.search(r":(\d{6})", self._tool), problem.robot.arm.tool_type
        if number and expected and number[1] != expected:
            raise PlanningError(
                f"{self._arm.name} holds {self._tool}, the plan was proved with {problem.robot.arm.name} ({expected})",
                mend="mount that instrument, or plan with the model of this one",
            )

    def _await_poses(self) -> None:
        """Wait for both poses and the instrument; an arm need not report all of them."""
        begin = time.monotonic()
        while time.monotonic() - begin < FIND and len(self._poses) < 2:
            topic.spin(self._here, 0.02)
            waited = time.monotonic() - begin
            listed = [one for one in ("measured_cp", "local/measured_cp")
                      if self._here.count_publishers(f"/{self._arm.name}/{one}")]  # fmt: skip
            if waited > _TOOL and all(one in self._poses for one in listed):
                break
        while time.monotonic() - begin < _TOOL and not self._tool:
            topic.spin(self._here, 0.02)

    def _keep(self, name: str, message: Any) -> None:
        stamp, p, o = message.header.stamp, message.pose.position, message.pose.orientation
        if (stamp.sec or stamp.nanosec) and self._arm.q is not None:
            self._poses[name] = (pose([p.x, p.y, p.z], [o.w, o.x, o.y, o.z]), self._arm.q)

    def _keep_tool(self, message: Any) -> None:
        self._tool = message.data


def _near(away: tuple[float, float], most: tuple[float, float]) -> bool:
    return away[0] <= most[0] and away[1] <= most[1]
