"""A hand presses a simulated MTM into a wall and feels the force. Run `palpate ros sim --rate 500` and
`palpate ros haptics wall.yaml --follower virtual --teleop none` at the same time (docs/ros2.md). The client uses plain
rclpy, as for a real dVRK."""

import sys

try:
    import rclpy
except ImportError:
    sys.exit("error: this example needs ROS 2: run it with the Python of a sourced installation, or run make setup")
from crtk_msgs.msg import OperatingState
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import Joy
from std_msgs.msg import Empty

rclpy.init()
node, last = rclpy.create_node("hand"), {}
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
node.create_subscription(OperatingState, "/MTMR/operating_state", lambda m: last.update(state=m), latched)
node.create_subscription(PoseStamped, "/MTMR/measured_cp", lambda m: last.update(pose=m), 10)
node.create_subscription(DiagnosticArray, "/diagnostics", lambda m: last.update(words=m.status[0].message), 10)
node.create_subscription(WrenchStamped, "/MTMR/body/servo_cf", lambda m: last.update(wrench=m.wrench.force), 10)
power, home = node.create_publisher(Empty, "/system/power_on", 10), node.create_publisher(Empty, "/system/home", 10)
present = node.create_publisher(Joy, "/console/emulate_operator_present", 10)
hand = node.create_publisher(PoseStamped, "/MTMR/hand/servo_cp", 10)  # only simulated arms have a hand


def wait(condition, seconds=60.0, missing=""):
    end = node.get_clock().now().nanoseconds + 1e9 * seconds
    while not condition() and node.get_clock().now().nanoseconds < end:
        rclpy.spin_once(node, timeout_sec=0.01)
    if missing and not condition():
        sys.exit(f"error: {missing}")


no_arm = "no simulated MTMR answers; start it in another terminal: palpate ros sim --rate 500"
wait(lambda: all(p.get_subscription_count() for p in (power, home, present, hand)), 10.0, no_arm)
power.publish(Empty())
wait(lambda: last["state"].state == "ENABLED" if "state" in last else False, 5.0, no_arm)
home.publish(Empty())
wait(lambda: last["state"].is_homed and not last["state"].is_busy, 60.0, "the arm does not home")
present.publish(Joy(buttons=[1]))
no_node = "no force arrives; start: palpate ros haptics wall.yaml --follower virtual --teleop none"
wait(lambda: {"wrench", "words", "pose"} <= last.keys(), 60.0, no_node)  # the haptic node has started
wait(lambda: False, 1.0)  # and follows the arm
goal = last["pose"]
for millimetre in range(100):  # the wall is 20.5 mm away along -y
    hand.publish(goal)
    wait(lambda: False, 0.2)
    y, f = 1e3 * last["pose"].pose.position.y, last["wrench"].y
    print(f"hand goal {millimetre:2d} mm: handle at y = {y:.1f} mm, pushed by {f:.2f} N; {last['words']}", flush=True)
    if f > 0.5:
        break
    goal.pose.position.y -= 0.001
else:
    raise SystemExit(f"no wall found; message of the node: {last['words']}")
