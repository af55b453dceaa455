"""A subscription that hears latching publishers and others: settings and commands of CRTK come from both."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_PERIOD = 0.5  # between two looks at the publishers [s]
_LOOKS = 10  # for which it listens to what a new publisher has latched: on a busy machine that takes seconds to arrive


class LatchedSubscription:
    """A transient-local subscription hears no volatile publisher, a volatile one nothing that was latched before it.

    So this one is volatile, and is transient-local as well for five seconds after a latching publisher was found. It
    would otherwise let the middleware warn each volatile publisher that no messages will be sent.

    Args:
        node: its node.
        kind: type of the messages.
        topic: full name.
        take: called with each message; with a latched one possibly twice.
    """

    def __init__(self, node: Any, kind: type, topic: str, take: Callable[[Any], None]) -> None:
        self._node, self._kind, self._topic, self._take = node, kind, topic, take
        self._known: set[bytes] = set()
        self._latched: Any = None
        self._left = 0
        node.create_subscription(kind, topic, take, 10)
        node.create_timer(_PERIOD, self._look)

    def _look(self) -> None:
        from rclpy.qos import DurabilityPolicy, QoSProfile

        self._left -= 1
        if self._latched is not None and self._left <= 0:
            self._node.destroy_subscription(self._latched)
            self._latched = None
        found = self._node.get_publishers_info_by_topic(self._topic)
        latching = {bytes(one.endpoint_gid) for one in found
                    if one.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL}  # fmt: skip
        if latching - self._known:
            self._left = _LOOKS
            if self._latched is None:
                quality = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
                self._latched = self._node.create_subscription(self._kind, self._topic, self._take, quality)
        self._known = latching
