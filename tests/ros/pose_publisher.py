"""Publishes PoseStamped messages until its standard input ends: python pose_publisher.py RATE.

Each line of the standard input, `TOPIC x y z turn_z_deg [stamp]`, sets the pose on a topic; `stamp` is `zero` or
`back`, the stamps go on with the clock otherwise. `TOPIC off` stops a topic.
"""

import sys
import threading
from contextlib import suppress

import numpy as np
import rclpy
from geometry_msgs.msg import PoseStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

TARGETS: dict[str, list[str]] = {}


def message(node: Node, words: list[str]) -> PoseStamped:
    x, y, z, turn = map(float, words[:4])
    made, how = PoseStamped(), words[4] if len(words) > 4 else ""
    made.header.frame_id = "tracker"
    if how != "zero":
        made.header.stamp = node.get_clock().now().to_msg()
        made.header.stamp.sec -= 100 if how == "back" else 0
    made.pose.position.x, made.pose.position.y, made.pose.position.z = x, y, z
    half = 0.5 * np.radians(turn)
    made.pose.orientation.z, made.pose.orientation.w = float(np.sin(half)), float(np.cos(half))
    return made


def main() -> None:
    rclpy.init()
    node, publishers = rclpy.create_node("poses"), {}

    def publish() -> None:
        for topic, words in list(TARGETS.items()):
            if words[0] == "off":
                continue
            if topic not in publishers:
                publishers[topic] = node.create_publisher(PoseStamped, topic, 10)
            publishers[topic].publish(message(node, words))

    def read() -> None:
        for line in sys.stdin:
            topic, *words = line.split()
            TARGETS[topic] = words
        rclpy.shutdown()

    node.create_timer(1.0 / float(sys.argv[1]), publish)
    threading.Thread(target=read, daemon=True).start()
    print("ready", flush=True)
    with suppress(ExternalShutdownException, KeyboardInterrupt):
        rclpy.spin(node)


main()
