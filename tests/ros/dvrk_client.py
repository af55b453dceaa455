"""A client of a dVRK as one writes it with rclpy and crtk_msgs; nothing in it knows that the robot is simulated."""

from __future__ import annotations

import importlib

from dvrk_topics import ROWS
from rclpy.qos import DurabilityPolicy, QoSProfile

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def message_type(name: str, kind: str = "msg"):
    """The class of `package/Type`."""
    package, _, cls = name.partition("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), cls)


class Dvrk:
    """Hears what it subscribes to, keeps the last of each; publishes commands by the name of their topic."""

    def __init__(self, node, until):
        self._node, self._until = node, until
        self._rows = dict(ROWS)
        self._publishers, self.last, self.count = {}, {}, {}

    def hear(self, *topics, wait=True):
        """Subscribe, and wait for what is told without being asked."""
        for topic in topics:
            row = self._row(topic)

            def keep(message, topic=topic):
                self.last[topic] = message
                self.count[topic] = self.count.get(topic, 0) + 1

            self._node.create_subscription(message_type(row.type), topic, keep, LATCHED if row.latched else 10)
        for topic in topics:
            periodic = topic.rpartition("/")[2].startswith(("measured", "setpoint", "jacobian"))
            if wait and (periodic or self._row(topic).latched):
                self._until(lambda topic=topic: topic in self.last, f"anything on {topic}")

    def say(self, topic, message=None, **fields):
        """Publish once somebody listens; fields of the message, or its one value as `data` or `string`."""
        row = self._row(topic)
        if topic not in self._publishers:
            self._publishers[topic] = self._node.create_publisher(message_type(row.type), topic, 10)
        publisher = self._publishers[topic]
        self._until(publisher.get_subscription_count, f"somebody who listens to {topic}")
        publisher.publish(message or message_type(row.type)(**fields))

    def _row(self, topic):
        """Other arms have the topics of their kind."""
        return self._rows[topic.replace("/MTML/", "/MTMR/").replace("/ECM/", "/PSM1/")]

    def state(self, arm):
        """Operating state in words."""
        return self.last[f"/{arm}/operating_state"].state

    def home(self, arm):
        """Enable and home, and wait for it."""
        self.say(f"/{arm}/state_command", string="enable")
        self._until(lambda: self.state(arm) == "ENABLED", f"{arm} enabled")
        self.say(f"/{arm}/state_command", string="home")

        def homed():
            state = self.last[f"/{arm}/operating_state"]
            return state.is_homed and not state.is_busy

        self._until(homed, f"{arm} homed", 20.0)
