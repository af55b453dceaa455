"""Clients that latch their settings and clients that do not, beside one robot: nobody is warned, all are heard."""

import os
import time

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile

LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@pytest.fixture
def others(rclpy):
    """A function that makes nodes."""
    made = []

    def make(name):
        made.append(rclpy.create_node(f"{name}_{os.getpid()}_{len(made)}"))
        return made[-1]

    yield make
    for node in made:
        node.destroy_node()


@pytest.mark.parametrize("latching", ["speaks", "is silent", "has ended"])
def test_client_after_a_latching_one_is_not_warned_and_is_heard(sim, rclpy, node, others, until, latching):
    """Fast DDS warns a volatile publisher of each latching subscription: "No messages will be sent to it"."""
    from crtk_msgs.msg import OperatingState, StringStamped
    from rclpy.event_handler import PublisherEventCallbacks

    states = []
    node.create_subscription(OperatingState, "/PSM1/operating_state", states.append, LATCHED)
    first = others("latching")
    to = first.create_publisher(StringStamped, "/PSM1/state_command", LATCHED)
    until(to.get_subscription_count, "the robot hears the latching client")
    if latching == "speaks":
        to.publish(StringStamped(string="disable"))
    if latching == "has ended":
        first.destroy_publisher(to)
    end = time.monotonic() + 5.0
    until(lambda: time.monotonic() > end, "time", 10.0)
    warned, later = [], others("later")
    callbacks = PublisherEventCallbacks(incompatible_qos=warned.append)
    own = later.create_publisher(StringStamped, "/PSM1/state_command", 10, event_callbacks=callbacks)
    until(own.get_subscription_count, "the robot hears the later client")
    end = time.monotonic() + 2.0
    while time.monotonic() < end:
        rclpy.spin_once(later, timeout_sec=0.05)
    assert not warned, f"warned {len(warned)} times that no messages will be sent"
    states.clear()
    own.publish(StringStamped(string="enable"))
    until(lambda: any(state.state == "ENABLED" for state in states), "the later client is heard")
    own.publish(StringStamped(string="disable"))
    until(lambda: states[-1].state == "DISABLED", "disabled again")
