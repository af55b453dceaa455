"""The patient's side of a link over ROS 2: an arm follows an operator across the network by CRTK's servo_cp.

A thread steps the site (`_network.Site`) with the arm's measured pose and the force of a sensor, and sends its goals.
Nothing is sent before an operator has aligned, and while the arm is silent, disabled, without a force or far from its
goal. Its packets then grow old, so that the operator's end lets the hand go.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, Literal

import numpy as np

from palpate import _network, ros
from palpate.base.arrays import rigid, so3
from palpate.base.errors import PalpateError
from palpate.ros import topic
from palpate.ros.background import BackgroundNode
from palpate.ros.crtk_arm import FIND, refusal
from palpate.ros.newest import Newest
from palpate.scene.rig import Rig
from palpate.session.remote.site import PATIENCE, known, site_options

STALE = 0.1
"""Age from which a measured pose or force is too old [s]."""
RATE = 250.0
"""Rate of the site and of its goals [Hz]."""
LAG = 0.03
"""Distance of the tool from its goal from which the arm does not follow, as in the haptic cycle [m]."""
_REST = 2.0  # time for which it then gets no goal, so that the operator is told of an outage [s]
_LONGEST = 0.02  # longest step of the goal, however late this process is [s]
_MOST = 4096  # packets that wait for the next step
_NOTHING = _network.encode(_network.Datagram())


class RosPatient:
    """Lets one arm over ROS 2 follow an operator across the network.

    Args:
        rig: the rig of the scene; the arm's base is that of the scene's follower.
        arm: name of the arm on the network, such as PSM1.
        force: topic of the force of the tissue on the tool (geometry_msgs/WrenchStamped).
        axes: axes of that force: of the arm's base, or of its tip.
        network: whether ROS 2 communicates with other machines.
        say: takes lines for the user.

    Raises:
        PalpateError: the arm or the force is silent, or ROS 2 is not installed.
    """

    def __init__(
        self, rig: Rig, arm: str, force: str, axes: Literal["base", "tip"] = "base", network: bool = False,
        say: Callable[[str], None] = lambda _: None,
    ) -> None:  # fmt: skip
        self.arm, self._force, self._tip, self._say = arm, force, axes == "tip", say
        self._X_WB = np.asarray(rig.arms.X_WB, np.float64)
        self._site = _network.Site(site_options(rig), known(rig))
        self._inbox: deque[tuple[_network.Datagram, float]] = deque(maxlen=_MOST)
        self._newest = Newest()
        self._state: Any = None  # newest operating state
        self._packet = _NOTHING
        self._forget, self._stopped = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="palpate-patient", daemon=True)
        self._why, self._drives, self._heard = "", False, 0.0  # words, and when an operator was heard last [s]
        self._behind, self._rests_until = "", 0.0  # why the arm rests, and until when [s]
        self._largest, self._ticks, self._missed = 0.0, 0, 0
        self.sent = 0  #: goals
        self._listen(network)

    # -- what the server of the link calls -------------------------------------------------------------------------

    def start(self) -> None:
        """Begin to follow."""
        self._thread.start()

    def stop(self) -> None:
        """End following, and leave the network."""
        self._stopped.set()
        if self._thread.is_alive():
            self._thread.join()
        self._background.close()

    def receive(self, bytes: bytes, at: float, /) -> bool:
        """The bytes of a datagram that arrived at the own time ``at`` [s]; False unless they are valid."""
        datagram = _network.decode(bytes)
        if datagram is not None:
            self._heard = at
            self._inbox.append((datagram, at))
        return datagram is not None

    def packet(self) -> bytes:
        """The bytes of the datagram that leaves next."""
        return self._packet

    def forget_operator(self) -> None:
        """The operator has left, or a new one comes: no goal is sent until one drives the arm."""
        self._forget.set()

    def state(self) -> SimpleNamespace:
        """``largest``: the largest measured force so far [N]."""
        return SimpleNamespace(largest=self._largest)

    def timing(self) -> dict[str, Any]:
        """Number of ``ticks``, and of ``missed_ticks``."""
        return {"ticks": self._ticks, "missed_ticks": self._missed}

    # -- ROS 2 -----------------------------------------------------------------------------------------------------

    def _listen(self, network: bool) -> None:
        """Subscribe, and wait until arm and force speak."""
        ros.messages()
        from geometry_msgs.msg import PoseStamped, TwistStamped, WrenchStamped
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from sensor_msgs.msg import JointState

        domain = ros.load().Context(network=network).domain
        self._background = BackgroundNode(f"palpate_follower_{self.arm}", domain)
        here = self._background.node
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        state = topic.message_type("crtk_msgs/OperatingState")
        here.create_subscription(state, f"/{self.arm}/operating_state", self._keep_state, latched)
        self._topics = {
            "pose": (PoseStamped, f"/{self.arm}/measured_cp"),
            "velocity": (TwistStamped, f"/{self.arm}/measured_cv"),
            "jaw": (JointState, f"/{self.arm}/jaw/measured_js"),
            "force": (WrenchStamped, self._force),
        }
        for name, (kind, place) in self._topics.items():
            here.create_subscription(kind, place, lambda m, name=name: self._keep(name, m), 1)
        self._pose_type, self._joint_type = PoseStamped, JointState
        self._goals = here.create_publisher(PoseStamped, f"/{self.arm}/servo_cp", 1)
        self._jaws = here.create_publisher(JointState, f"/{self.arm}/jaw/servo_jp", 1)
        self._background.spin()
        end = time.monotonic() + FIND
        while (silent := self._silent()) and time.monotonic() < end:
            time.sleep(0.02)
        if silent and not refusal(self.arm, self._state):
            places = ", ".join(silent)
            self._background.close()
            raise PalpateError(f"{self.arm} cannot follow: nothing valid on {places}",
                               mend="check names and types with `palpate ros topic list`")  # fmt: skip

    def _silent(self) -> list[str]:
        """Topics that have not spoken and must."""
        unheard = [] if self._state is not None else [f"/{self.arm}/operating_state"]
        return unheard + [self._topics[name][1] for name in ("pose", "force") if name not in self._newest]

    def _keep_state(self, message: Any) -> None:
        self._state = message

    def _keep(self, name: str, message: Any) -> None:
        self._newest.keep(name, message, time.monotonic())

    # -- following -------------------------------------------------------------------------------------------------

    def _run(self) -> None:
        due = last = time.monotonic()
        while not self._stopped.is_set():
            now = time.monotonic()
            self._missed += max(0, int((now - due) * RATE))
            self._step(now, min(max(now - last, 1e-4), _LONGEST))
            last, due = now, max(due + 1.0 / RATE, now)
            self._ticks += 1
            time.sleep(max(0.0, due - time.monotonic()))

    def _refusal(self, now: float) -> str:
        """Why the arm may not be moved now, in words; empty if it may."""
        why = refusal(self.arm, self._state)
        for name in ("pose", "force"):
            if not why and self._newest.age(name, now) > STALE:
                why = f"{self._topics[name][1]} is silent"
        return why or (self._behind if now < self._rests_until else "")

    def _step(self, now: float, dt: float) -> None:
        if self._drives and now - self._heard > PATIENCE:  # whoever has left without a word
            self._forget.set()
        if self._forget.is_set():
            self._forget.clear()
            self._inbox.clear()
            self._site.forget_operator()
            self._packet = _NOTHING
            self._drives = False
        while self._inbox:
            self._site.receive(*self._inbox.popleft())
        why = self._refusal(now)
        if why != self._why:
            self._say(f"{why}: no goal is sent" if why else f"{self.arm} is ready")
            self._why = why
        if why:
            self._drives = False
            return  # packets grow old, so the operator is told
        if not self._drives:
            self._site.rest()  # others may move the tool: its goal begins where it is
        state = self._measured(now)
        goal = self._site.step(state, dt)
        self._drives = self._drives or not goal.flags & _network.FLAG_HOLDING
        behind = float(np.linalg.norm(goal.X[:3, 3] - state.X[:3, 3]))
        if self._drives and behind > LAG:
            self._behind, self._rests_until = f"{self.arm} is {1e3 * behind:.0f} mm from its goal", now + _REST
            return
        self._packet = _network.encode(self._site.send())
        if self._drives:
            self._send(goal)

    def _measured(self, now: float) -> _network.SiteInput:
        state, R, newest = _network.SiteInput(), self._X_WB[:3, :3], self._newest
        pose, F = newest["pose"], newest["force"]
        state.t, state.X = now, self._X_WB @ so3.pose(pose[:3], pose[3:])
        state.F = (state.X[:3, :3] if self._tip else R) @ F
        self._largest = max(self._largest, float(np.linalg.norm(F)))
        if newest.age("velocity", now) <= STALE:
            state.v = R @ newest["velocity"]
        if "jaw" in newest:
            state.jaw = float(newest["jaw"][0])
        return state

    def _send(self, goal: _network.SiteGoal) -> None:
        X = rigid.inverse(self._X_WB) @ goal.X
        message, stamp = self._pose_type(), self._background.node.get_clock().now().to_msg()
        message.header.stamp = stamp
        p, o = message.pose.position, message.pose.orientation
        p.x, p.y, p.z = X[:3, 3].tolist()
        o.w, o.x, o.y, o.z = so3.quaternions(X[:3, :3]).tolist()
        self._goals.publish(message)
        if "jaw" in self._newest:
            jaw = self._joint_type()
            jaw.header.stamp, jaw.position = stamp, [float(goal.jaw)]
            self._jaws.publish(jaw)
        self.sent += 1
