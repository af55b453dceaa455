"""A mock CRTK master with a console, as a process: publishes its state and prints each received wrench.

    python fake_master.py RATE        one JSON line for each wrench on standard output: its stamp [s], force

Commands on standard input, one per line: `depth METRES`, `further METRES` (from the present depth), `following 0|1`,
`operator 0|1`, `state NAME`, `teleop STATE`, `silent 0|1`.
The last wrench stays active without a timeout, as on the real arm.
"""

import contextlib
import json
import sys
import threading
import time

import numpy as np
from scipy.spatial.transform import Rotation

from palpate import ros
from palpate.arm import Arm
from palpate.scene.rig import build
from palpate.scene.scene import Scene

ros.messages()
import rclpy  # noqa: E402
from crtk_msgs.msg import OperatingState  # noqa: E402
from geometry_msgs.msg import PoseStamped, TwistStamped, WrenchStamped  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402
from sensor_msgs.msg import Joy  # noqa: E402
from std_msgs.msg import Bool, String  # noqa: E402

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Master:
    def __init__(self, rate, scene):
        self.node, self.lock = rclpy.create_node("fake_master"), threading.Lock()
        rig = build(Scene.load(scene))
        X_LH = Arm.mtm("right").fk(rig.arms.q_leader0)
        self.at, self.turn = X_LH[:3, 3], Rotation.from_matrix(X_LH[:3, :3]).as_quat()
        self.down = rig.arms.X_WL[:3, :3].T @ np.array([0.0, 0.0, -1.0])
        self.depth = self.goal = 0.0
        self.silent = False
        make = self.node.create_publisher
        self.cp = make(PoseStamped, "/MTMR/measured_cp", 10)
        self.cv = make(TwistStamped, "/MTMR/measured_cv", 10)
        self.state = make(OperatingState, "/MTMR/operating_state", LATCHED)
        self.following = make(Bool, "/MTMR_PSM1/following", LATCHED)
        self.operator = make(Joy, "/console/operator_present", LATCHED)
        self.flags = []
        self.subscribe(WrenchStamped, "/MTMR/body/servo_cf", self.wrench)
        self.subscribe(WrenchStamped, "/MTMR_PSM1/following/mtm/body/servo_cf", self.wrench)
        for name in ("body/set_cf_orientation_absolute", "use_gravity_compensation"):
            self.subscribe(Bool, f"/MTMR/{name}", lambda m, name=name: self.write_line(flag=name, on=m.data))
        self.publish_state("ENABLED")
        self.period = 1.0 / rate

    def subscribe(self, kind, topic, callback):
        self.node.create_subscription(kind, topic, callback, 50)

    def write_line(self, **values):
        with self.lock:
            print(json.dumps(values), flush=True)

    def wrench(self, m):
        f = m.wrench.force
        stamp = m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec
        self.write_line(t=stamp, force=float(np.linalg.norm([f.x, f.y, f.z])), f=[f.x, f.y, f.z])

    def publish_state(self, name):
        self.state.publish(OperatingState(state=name, is_homed=True))

    def publish(self):
        step = 0.05 * self.period  # the hand moves at 5 cm/s at most
        self.depth += float(np.clip(self.goal - self.depth, -step, step))
        stamp = self.node.get_clock().now().to_msg()
        pose, twist = PoseStamped(), TwistStamped()
        pose.header.stamp = twist.header.stamp = stamp
        p = self.at + self.depth * self.down
        pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = map(float, p)
        o = pose.pose.orientation
        o.x, o.y, o.z, o.w = map(float, self.turn)
        self.cv.publish(twist)
        self.cp.publish(pose)

    def execute(self, line):
        word, value = line.split()
        if word == "depth":
            self.goal = float(value)
        elif word == "further":
            self.goal = self.depth + float(value)
        elif word == "silent":
            self.silent = value == "1"
        elif word == "following":
            self.following.publish(Bool(data=value == "1"))
        elif word == "operator":
            self.operator.publish(Joy(buttons=[int(value)]))
        elif word == "teleop":
            self.teleop = self.node.create_publisher(String, "/MTMR_PSM1/current_state", LATCHED)
            self.teleop.publish(String(data=value))
        elif word == "state":
            self.publish_state(value)

    def listen(self):
        with contextlib.suppress(rclpy.executors.ExternalShutdownException):
            rclpy.spin(self.node)

    def run(self):
        threading.Thread(target=lambda: [self.execute(line) for line in sys.stdin], daemon=True).start()
        threading.Thread(target=self.listen, daemon=True).start()
        self.write_line(ready=True)
        due = time.monotonic()
        while rclpy.ok():
            due = max(due + self.period, time.monotonic() - 0.005)
            time.sleep(max(0.0, due - time.monotonic()))
            if not self.silent:
                with contextlib.suppress(rclpy._rclpy_pybind11.RCLError):  # ROS has shut down
                    self.publish()


rclpy.init()
Master(float(sys.argv[1]), sys.argv[2]).run()
