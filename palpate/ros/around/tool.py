"""Holds a session while its follower announces another instrument than the one whose kinematics the session knows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from palpate.base.errors import StateError
from palpate.session import machine

if TYPE_CHECKING:
    from palpate.ros.plant import CrtkPlant
    from palpate.session import Session


class Tool:
    """Topics of a dVRK about the instrument: tool_type (std_msgs/String) and tool_type_request (std_msgs/Empty).

    The first type that the follower reports counts as that of the scene. Another one, or the question which instrument
    is mounted, makes the session hold; it says so, and how to go on. The service ~/resume (std_srvs/Trigger) ends the
    hold, unless the other instrument is still mounted.
    """

    def __init__(self, node: Any, session: Session, plant: CrtkPlant) -> None:
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from std_msgs.msg import Empty, String
        from std_srvs.srv import Trigger

        self._session, self._plant, self._arm = session, plant, plant.loop.names.follower
        self.known = self.mounted = ""  #: type at the start, and the newest one; empty before the arm reports it
        self._service = f"{node.get_fully_qualified_name()}/resume"
        node.create_service(Trigger, "~/resume", self._resume)
        if not self._arm:
            return  # no follower
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        for qos in (QoSProfile(depth=10), latched):  # a dVRK latches its type; other publishers may not
            node.create_subscription(String, f"/{self._arm}/tool_type", lambda message: self.take(message.data), qos)
        node.create_subscription(Empty, f"/{self._arm}/tool_type_request", lambda _: self.ask(), 10)

    def take(self, kind: str) -> None:
        """Take the type of the mounted instrument."""
        if not kind or kind == self.mounted:
            return
        known = self.known
        self.known, self.mounted = known or kind, kind
        if kind == self.known:
            if known:
                how = f"ros2 service call {self._service} std_srvs/srv/Trigger"
                self._tell(f"{self._arm} has {kind} again; to go on: {how}")
            return
        self._hold()
        what = f"{self._arm} has another instrument, {kind} instead of {self.known}"
        self._tell(f"{what}: everything holds. {self._mend()}")

    def ask(self) -> None:
        """The follower asks which instrument is mounted."""
        self._hold()
        name = f"publish its name (std_msgs/String) to /{self._arm}/set_tool_type"
        self._tell(f"{self._arm} asks which instrument is mounted: everything holds. To answer: {name}")

    def _mend(self) -> str:
        model = self._session.scene.arms.follower.model
        return (
            f"The session knows the kinematics of {model}: mount {self.known} again, or end it, give "
            "arms.follower.model the new instrument, and start again"
        )

    def _hold(self) -> None:
        try:
            self._session.request("hold")
        except StateError:  # it cannot hold yet, for example in a fault: it holds as soon as it can
            self._session.change(**machine.level("hold"))

    def _tell(self, words: str) -> None:
        self._plant.events.append(words)

    def _resume(self, _: Any, answer: Any) -> Any:
        if self.mounted != self.known:
            answer.success, answer.message = False, f"{self._arm} has {self.mounted}. {self._mend()}"
            return answer
        self._session.change(**machine.level("resume"))
        answer.success, answer.message = True, "the session goes on"
        return answer
