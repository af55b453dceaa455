"""A client that uses a CRTK robot as its Python libraries do: commands are sent at once, without a pause after the
start of the node; settings are latched; each answer is awaited for the time that the scripts allow."""

from __future__ import annotations

import threading
import time

import numpy as np
from dvrk_client import message_type
from dvrk_topics import ROWS
from rclpy.context import Context
from rclpy.qos import DurabilityPolicy, QoSProfile

from palpate.base.node_thread import NodeThread

LATCHED_BY_CLIENTS = ("state_command", "use_gravity_compensation", "set_cf_orientation_absolute", "set_ratio")
_ROWS = dict(ROWS)


def _row(topic):
    return _ROWS[topic]


class Script:
    """A program with one node, whose callbacks run in a thread."""

    def __init__(self, rclpy, name):
        self._context = Context()
        rclpy.init(context=self._context)
        self.node = rclpy.create_node(name, context=self._context)
        self._thread = NodeThread(self.node, self._context, name)
        self._ends, self.events, self.last = [], {}, {}
        self.were_busy = set()  # topics; a motion of no length is over before the waiting thread wakes up

    def arm(self, name):
        return Arm(self, name)

    def subscribe(self, topic):
        """Subscribe without durability, as the libraries do, latched or not."""
        self.events[topic] = threading.Event()

        def keep(message):
            self.last[topic] = message
            if getattr(message, "is_busy", False):
                self.were_busy.add(topic)
            self.events[topic].set()

        self._ends.append(self.node.create_subscription(message_type(_row(topic).type), topic, keep, 10))

    def publisher(self, topic):
        qos = QoSProfile(depth=10)
        if topic.endswith(LATCHED_BY_CLIENTS):
            qos.durability = DurabilityPolicy.TRANSIENT_LOCAL
        self._ends.append(self.node.create_publisher(message_type(_row(topic).type), topic, qos))
        return self._ends[-1]

    def spin(self):
        """Start the thread of the callbacks."""
        self._thread.start()

    def check_connections(self, seconds=5.0):
        """Wait until each publisher has a subscriber and each subscription a publisher."""
        end = time.monotonic() + seconds
        while left := [end_ for end_ in self._ends if not _connected(end_)]:
            assert time.monotonic() < end, f"not connected within {seconds:g} s: {[e.topic_name for e in left]}"
            time.sleep(0.01)

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self._thread.stop()


def _connected(end):
    return end.get_subscription_count() if hasattr(end, "get_subscription_count") else end.get_publisher_count()


class Arm:
    """An arm of a script: topics by their names, and the calls of the libraries."""

    def __init__(self, script, name):
        self.script, self.name, self._publishers = script, name, {}

    def use(self, *names):
        """Create subscriptions and publishers, in this order."""
        for name in names:
            topic = f"/{self.name}/{name}"
            if _row(topic).direction == "out":
                self.script.subscribe(topic)
            else:
                self._publishers[name] = self.script.publisher(topic)
        return self

    def send(self, name, message=None, **fields):
        """Publish a command at once, connected or not."""
        self._publishers[name].publish(message or message_type(_row(f"/{self.name}/{name}").type)(**fields))

    def read(self, name, wait=1.0):
        """A message that is younger than the call, or an error after `wait` [s], as the libraries raise it."""
        topic = f"/{self.name}/{name}"
        self.script.events[topic].clear()
        assert self.script.events[topic].wait(wait), f"no data received within {wait} s: {topic}"
        return self.script.last[topic]

    def command(self, state, reached, seconds):
        """Send a state command, and wait for an operating state that satisfies `reached`."""
        topic, end = f"/{self.name}/operating_state", time.monotonic() + seconds
        self.script.events[topic].clear()
        self.send("state_command", string=state)
        while not (topic in self.script.last and reached(self.script.last[topic])):
            left = end - time.monotonic()
            assert left > 0.0, f"failed to {state} {self.name} within {seconds:g} s"
            self.script.events[topic].wait(left)
            self.script.events[topic].clear()

    def enable(self, seconds=10.0):
        self.command("enable", lambda s: s.state == "ENABLED", seconds)

    def home(self, seconds=10.0):
        self.command("home", lambda s: s.is_homed and not s.is_busy, seconds)

    def move(self, name, message, seconds=10.0):
        """Send a motion and wait until the arm is busy, then until it is not."""
        topic, end = f"/{self.name}/operating_state", time.monotonic() + seconds
        self.script.events[topic].clear()
        self.script.were_busy.discard(topic)
        self.send(name, message)
        while True:
            assert self.script.events[topic].wait(end - time.monotonic()), f"{name} of {self.name} does not end"
            self.script.events[topic].clear()
            if topic in self.script.were_busy and not self.script.last[topic].is_busy:
                return

    @property
    def tip(self):
        """Measured position (3,) [m]."""
        p = self.read("measured_cp").pose.position
        return np.array([p.x, p.y, p.z])

    @property
    def joints(self):
        """Measured joint positions [rad, m]."""
        return np.array(self.read("measured_js").position)
