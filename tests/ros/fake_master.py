"""Mock CRTK masters with a console each, one after the other, as a process: publishes the state of the present one and
prints each received wrench.

    python fake_master.py RATE SCENE    one JSON line for each wrench on standard output: its stamp [s], force

Commands on standard input, one per line: `arm NAME` (a new master, with teleoperation NAME_PSM1 and console
NAME_console; the one before leaves the network), `depth METRES`, `further METRES` (from the present depth),
`following 0|1`, `operator 0|1`, `state NAME`, `teleop STATE`, `silent 0|1`.
The last wrench stays active without a timeout, as on the real arm.
"""

import contextlib
import json
import queue
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
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402
from sensor_msgs.msg import Joy  # noqa: E402
from std_msgs.msg import Bool, String  # noqa: E402

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


LOCK = threading.Lock()


def write_line(**values):
    with LOCK:
        print(json.dumps(values), flush=True)


class Master:
    """One arm with its console. rig: gives the place of its handle. period: of its states [s]."""

    def __init__(self, name, rig, period):
        self.node, self.teleop = rclpy.create_node(f"fake_{name}"), f"/{name}_PSM1"
        X_LH = Arm.mtm("right").fk(rig.arms.q_leader0)
        self.at, self.turn = X_LH[:3, 3], Rotation.from_matrix(X_LH[:3, :3]).as_quat()
        self.down = rig.arms.X_WL[:3, :3].T @ np.array([0.0, 0.0, -1.0])
        self.depth = self.goal = 0.0
        self.silent, self.period = False, period
        make = self.node.create_publisher
        self.cp = make(PoseStamped, f"/{name}/measured_cp", 10)
        self.cv = make(TwistStamped, f"/{name}/measured_cv", 10)
        self.state = make(OperatingState, f"/{name}/operating_state", LATCHED)
        self.following = make(Bool, f"{self.teleop}/following", LATCHED)
        self.operator = make(Joy, f"/{name}_console/operator_present", LATCHED)
        self.subscribe(WrenchStamped, f"/{name}/body/servo_cf", self.wrench)
        self.subscribe(WrenchStamped, f"{self.teleop}/following/mtm/body/servo_cf", self.wrench)
        for flag in ("body/set_cf_orientation_absolute", "use_gravity_compensation"):
            self.subscribe(Bool, f"/{name}/{flag}", lambda m, flag=flag: write_line(flag=flag, on=m.data))
        self.publish_state("ENABLED")

    def subscribe(self, kind, topic, callback):
        self.node.create_subscription(kind, topic, callback, 50)

    def wrench(self, m):
        f = m.wrench.force
        stamp = m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec
        write_line(t=stamp, force=float(np.linalg.norm([f.x, f.y, f.z])), f=[f.x, f.y, f.z])

    def publish_state(self, name):
        self.state.publish(OperatingState(state=name, is_homed=True))

    def publish(self):
        step = 0.05 * self.period  # the hand moves at 5 cm/s at most
        moved = float(np.clip(self.goal - self.depth, -step, step))
        self.depth += moved
        stamp = self.node.get_clock().now().to_msg()
        pose, twist = PoseStamped(), TwistStamped()
        pose.header.stamp = twist.header.stamp = stamp
        p = self.at + self.depth * self.down
        v = moved / self.period * self.down
        twist.twist.linear.x, twist.twist.linear.y, twist.twist.linear.z = map(float, v)
        pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = map(float, p)
        o = pose.pose.orientation
        o.x, o.y, o.z, o.w = map(float, self.turn)
        self.cv.publish(twist)
        self.cp.publish(pose)

    def execute(self, word, value):
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
            self.node.create_publisher(String, f"{self.teleop}/current_state", LATCHED).publish(String(data=value))
        elif word == "state":
            self.publish_state(value)


def main(rate, scene):
    rig, commands = build(Scene.load(scene)), queue.Queue()
    threading.Thread(target=lambda: [commands.put(line.split()) for line in sys.stdin], daemon=True).start()
    executor, master = SingleThreadedExecutor(), None
    due = time.monotonic()
    while rclpy.ok():
        due = max(due + 1.0 / rate, time.monotonic() - 0.005)
        while (left := due - time.monotonic()) > 0.0:  # everything in one thread, so that masters can be replaced
            executor.spin_once(timeout_sec=left) if master else time.sleep(left)
        while not commands.empty():
            word, value = commands.get()
            if word == "arm":
                if master:
                    executor.remove_node(master.node)
                    master.node.destroy_node()
                master = Master(value, rig, 1.0 / rate)
                executor.add_node(master.node)
                write_line(arm=value)
            else:
                master.execute(word, value)
        if master and not master.silent:
            with contextlib.suppress(rclpy._rclpy_pybind11.RCLError):  # ROS has shut down, or the machine is busy
                master.publish()


rclpy.init()
with contextlib.suppress(ExternalShutdownException, KeyboardInterrupt):
    main(float(sys.argv[1]), sys.argv[2])
