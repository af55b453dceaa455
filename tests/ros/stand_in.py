"""A CRTK arm with a console in plain rclpy, as a lab writes one to replace its robot; its thread publishes states."""

from __future__ import annotations

import threading
import time
from collections import deque

import numpy as np

HOME = np.array([0.0, -0.3645, -0.1288])  # [m], in front of the wall of `SCENE`
QUAT = np.array([0.5, 0.5, 0.5, -0.5])  # x y z w
SCENE = """
objects:
  - {name: wall, plane: {size: 0.12}, pose: {xyz: [0, -0.387, -0.1288], rpy_deg: [-90, 0, 0]}, stiffness: 200,
     damping: 2}
arms: {leader: {base: {xyz: [0, 0, 0]}, start: [0, 0, 0, 0, 0, 0, 0]}, follower: {bandwidth: 0}}
mapping: {scale: 1.0, align_rate: 0}
rates: {haptic: 200}
operator: {path: [{t: 0.2, xyz: [0, -0.3645, -0.1288]}, {t: 1, xyz: [0, -0.37, -0.1288]}]}
record: {report: false}
"""


class StandIn:
    """The arm. Attributes may be set at any time: p, quat [m], late [s], frame, bad_stamp, twist [m/s] or None."""

    def __init__(self, rclpy, name, rate=200.0):
        from crtk_msgs.msg import OperatingState
        from geometry_msgs.msg import PoseStamped, TwistStamped
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from sensor_msgs.msg import Joy
        from std_msgs.msg import Bool

        self.name, self.node, self.period = name, rclpy.create_node(f"stand_in_{name}"), 1.0 / rate
        self.latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.p, self.quat, self.late, self.frame, self.bad_stamp, self.twist = HOME.copy(), QUAT, 0.0, "", False, None
        self.wrenches = []  # (monotonic time [s], magnitude [N])
        self.poses = deque(maxlen=10_000)  # monotonic times at which poses were sent [s]
        make = self.node.create_publisher
        self._cp, self._cv = (
            make(PoseStamped, f"/{name}/measured_cp", 10),
            make(TwistStamped, f"/{name}/measured_cv", 10),
        )
        self._state = make(OperatingState, f"/{name}/operating_state", self.latched)
        self._operator = make(Joy, f"/{name}_console/operator_present", self.latched)
        self.node.create_subscription(Bool, f"/{name}/body/set_cf_orientation_absolute", lambda _: None, 10)
        self._subscription = None
        self.listen()
        self._state.publish(OperatingState(state="ENABLED", is_homed=True))
        self._operator.publish(Joy(buttons=[1]))
        self._running = True
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._lock = threading.Lock()
        self._thread.start()

    def listen(self):
        from geometry_msgs.msg import WrenchStamped

        def keep(m):
            f = m.wrench.force
            self.wrenches.append((time.monotonic(), float(np.linalg.norm([f.x, f.y, f.z]))))

        self._subscription = self.node.create_subscription(WrenchStamped, f"/{self.name}/body/servo_cf", keep, 50)

    def deafen(self):
        with self._lock:
            self.node.destroy_subscription(self._subscription)

    def pose(self, p, quat=None, late=0.0):
        from geometry_msgs.msg import PoseStamped

        m, t = PoseStamped(), time.time() - late
        m.header.frame_id = self.frame
        m.header.stamp.sec, m.header.stamp.nanosec = (0, 0) if self.bad_stamp else (int(t), int(t % 1 * 1e9))
        m.pose.position.x, m.pose.position.y, m.pose.position.z = map(float, p)
        o = m.pose.orientation
        o.x, o.y, o.z, o.w = map(float, self.quat if quat is None else quat)
        return m

    def _run(self):
        from geometry_msgs.msg import TwistStamped
        from rclpy.executors import SingleThreadedExecutor

        executor = SingleThreadedExecutor(context=self.node.context)
        executor.add_node(self.node)
        due = time.monotonic()
        while self._running:
            due = max(due + self.period, time.monotonic() - 0.005)
            with self._lock:
                while (left := due - time.monotonic()) > 0.0:
                    executor.spin_once(timeout_sec=left)
            message = self.pose(self.p, late=self.late)
            if self.twist is not None:
                twist = TwistStamped(header=message.header)
                twist.twist.linear.y = float(self.twist)
                self._cv.publish(twist)
            self._cp.publish(message)
            self.poses.append(time.monotonic())
        executor.remove_node(self.node)

    def end(self):
        self._running = False
        self._thread.join()
        self.node.destroy_node()

    def paused(self, begin):
        """Longest time without a pose since `begin` [s]: on a starved machine this process itself is silent."""
        times = np.array([t for t in list(self.poses) if t >= begin - 0.1] + [time.monotonic()])
        return float(np.diff(times).max(initial=0.0))

    def force(self, seconds=0.2):
        """Largest force within the last `seconds` [N]; NaN without a wrench."""
        last = [F for t, F in self.wrenches if t > time.monotonic() - seconds]
        return max(last, default=float("nan"))

    def press(self, least=0.3, seconds=40.0):
        """Move towards the wall until the force lasts."""
        end = time.monotonic() + seconds
        while not min([F for t, F in self.wrenches if t > time.monotonic() - 0.3], default=0.0) > least:
            assert time.monotonic() < end, f"no force: {self.wrenches[-3:]} at {self.p}"
            answers = sum(t > time.monotonic() - 0.1 for t, _ in self.wrenches[-50:])  # few on a starved machine
            if not self.force() > least + 0.1 and answers > 8:
                self.p = self.p - [0.0, 0.0002, 0.0]
            time.sleep(0.01)

    def free(self, seconds=5.0, lasts=0.3):
        """Wait until the force is zero and stays zero; returns the time that it took [s]."""
        begin = time.monotonic()
        while True:
            pushed = [t for t, F in self.wrenches if F > 1e-9 and t > begin]
            last = pushed[-1] if pushed else begin
            if time.monotonic() - last > lasts:
                return last - begin
            assert time.monotonic() < begin + seconds, f"still {self.wrenches[-1]}"
            time.sleep(0.02)
