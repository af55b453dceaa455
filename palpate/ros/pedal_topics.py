"""The console and the foot pedals of a dVRK as pedals of a session's console.

    with PedalTopics(session.console, plant.loop.context.domain):
        session.run()

The haptic node reads operator presence, clutch and camera itself as well, in its cycle, so that no force waits for
Python; both obey the same topics.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from palpate.ros.background import BackgroundNode
from palpate.session.console import Console

NAME = "palpate_console"
SOURCE = "dvrk"
"""Name of this source of pedals."""
_LOOK = 0.2  # period of the search for publishers that have gone [s]


def topics(console: str = "console", head_sensor: str = "") -> Iterator[tuple[str, str]]:
    """Pairs of topic and pedal; all topics are sensor_msgs/Joy, whose buttons[0] is 1 while the pedal is pressed.

    A dVRK with a head sensor reports it as operator_present. Its newer releases publish the coagulation pedal under the
    console's name, the older ones under footpedals.

    Args:
        console: CRTK name of the console.
        head_sensor: topic of a head sensor that reports for itself; empty: none does.
    """
    yield f"/{console}/operator_present", "operator"
    yield f"/{console}/clutch", "clutch"
    yield f"/{console}/camera", "camera"
    yield f"/{console}/coag", "coag"
    yield "/footpedals/coag", "coag"
    if head_sensor:
        yield f"/{head_sensor.strip('/')}", "head"


class PedalTopics(BackgroundNode):
    """Presses and releases the pedals of one console as the topics of a dVRK report them.

    A topic whose publisher disappears is a lost source: presence ends, and a clutch that it held stays pressed until
    the topic reports again.

    Args:
        console: the console of all hands.
        domain: ROS domain.
        name: CRTK name of the console on ROS 2.
        head_sensor: topic of a head sensor that reports for itself; empty: none does.
        space: namespace of the node, for a process that renders one of several pairs.
    """

    def __init__(
        self, console: Console, domain: int, name: str = "console", head_sensor: str = "", space: str = ""
    ) -> None:
        super().__init__(NAME, domain, space)
        self._console, self._published = console, set[str]()
        self._newest: dict[str, float] = {}  # stamp of the newest message of each topic [s]
        self._topics = list(topics(name.strip("/"), head_sensor))
        self._subscriptions = [self._subscribe(topic, pedal) for topic, pedal in self._topics]
        if head_sensor:
            console.release("head", source(self._topics[-1][0]))  # absent until it reports
        self.node.create_timer(_LOOK, self._look)
        self.spin()

    def close(self) -> None:
        """Remove the node from the network; its pedals are released, and nobody's presence is reported any more."""
        super().close()
        for topic, pedal in self._topics:
            self._console.forget(pedal, source(topic))

    def _subscribe(self, topic: str, pedal: str) -> Any:
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from sensor_msgs.msg import Joy

        def take(message: Joy) -> None:
            stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
            late = stamp < self._newest.get(topic, 0.0)
            button = message.buttons[0] if message.buttons else 0
            if button in (0, 1) and not late:  # 2: a tap, too short for a pedal that is held
                self._newest[topic] = stamp
                self._console.set(pedal, button == 1, source(topic))

        # Two subscriptions a topic: a volatile one hears every publisher, a latched one the last state of a dVRK. A
        # message that both deliver is taken once, or twice with the same result.
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        return [self.node.create_subscription(Joy, topic, take, qos) for qos in (QoSProfile(depth=10), latched)]

    def _look(self) -> None:
        """Find topics whose publishers have gone."""
        now = {topic for topic, _ in self._topics if self.node.count_publishers(topic)}
        for topic in sorted(self._published - now):
            self._newest.pop(topic, None)
            self._console.lose(source(topic))
        self._published = now


def source(topic: str) -> str:
    """Name of a topic among the sources of pedals."""
    return f"{SOURCE} {topic}"
