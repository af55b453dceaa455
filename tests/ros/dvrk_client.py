"""A client of a dVRK with rclpy and crtk_msgs, as for a real robot."""

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
    """Keeps the last message of each subscribed topic, and publishes commands by topic name."""

    def __init__(self, node, until, rows=ROWS):
        self._node, self._until = node, until
        self._rows = dict(rows)
        self._publishers, self.last, self.count = {}, {}, {}

    def subscribe(self, *topics, wait=True):
        """Subscribe, and wait for the first message of periodic and latched topics."""
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

    def publish(self, topic, message=None, **fields):
        """Publish a message, or one with these fields, once the topic has a subscriber."""
        row = self._row(topic)
        if topic not in self._publishers:
            self._publishers[topic] = self._node.create_publisher(message_type(row.type), topic, 10)
        publisher = self._publishers[topic]
        self._until(publisher.get_subscription_count, f"a subscriber of {topic}")
        publisher.publish(message or message_type(row.type)(**fields))

    def _row(self, topic):
        """Row of a topic; other arms have the topics of their kind."""
        return (
            self._rows.get(topic)
            or self._rows[topic.replace("/MTML/", "/MTMR/").replace("/ECM/", "/PSM1/").replace("/PSM2/", "/PSM1/")]
        )

    def state(self, arm):
        """Name of the operating state of an arm."""
        return self.last[f"/{arm}/operating_state"].state

    def home(self, *arms):
        """Enable and home arms at the same time, and wait for both."""
        for arm in arms:
            self.publish(f"/{arm}/state_command", string="enable")
        for arm in arms:
            self._until(lambda arm=arm: self.state(arm) == "ENABLED", f"{arm} enabled")
        for arm in arms:
            self.publish(f"/{arm}/state_command", string="home")

        def homed(arm):
            state = self.last[f"/{arm}/operating_state"]
            return state.is_homed and not state.is_busy

        for arm in arms:
            self._until(lambda arm=arm: homed(arm), f"{arm} homed", 20.0)
