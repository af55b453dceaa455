"""A thread that runs the callbacks of one ROS 2 node. It ends before the node is destroyed.

The executor's own `shutdown` destroys what a spinning thread waits for: the thread then fails, or waits for ever.
"""

from __future__ import annotations

import threading
from contextlib import suppress
from typing import Any

_LOOK = 0.2  # longest wait until the thread looks whether it is to end [s]


class NodeThread:
    """Runs the callbacks of a node from `start` until `stop`.

    Args:
        node: an rclpy node.
        context: its rclpy context, which `stop` shuts down.
        name: name of the thread.
    """

    def __init__(self, node: Any, context: Any, name: str) -> None:
        from rclpy.executors import SingleThreadedExecutor

        self._node, self._context = node, context
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(node)
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._spin, name=name, daemon=True)

    def start(self) -> None:
        """Run the callbacks from now on."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread and remove the node from the network. No effect before `start` or after the first call."""
        if self._thread.is_alive():
            self._ending.set()
            self._executor.create_task(lambda: None)  # wakes the thread
            self._thread.join(timeout=10.0)
            self._executor.shutdown(timeout_sec=2.0)
            remove(self._node, self._context)

    def _spin(self) -> None:
        from rclpy.executors import ExternalShutdownException

        with suppress(ExternalShutdownException):
            while not self._ending.is_set():
                self._executor.spin_once(timeout_sec=_LOOK)  # a wake-up may be lost


def remove(node: Any, context: Any) -> None:
    """Remove a node from the network, with its rclpy context."""
    import rclpy

    node.destroy_node()
    rclpy.shutdown(context=context)


def silence(node: Any, topic: str, kind: str) -> str:
    """Why nothing may arrive on a topic of messages of this kind, as the network shows it, in words."""
    types = dict(node.get_topic_names_and_types())
    name = node.resolve_topic_name(topic)
    count = node.count_publishers(name)
    if not count:
        domain = node.context.get_domain_id()
        return f"no node publishes {name} in domain {domain}"
    if kind not in types.get(name, [kind]):
        return f"{name} carries {', '.join(types[name])}, not {kind}"
    return f"{count} nodes publish {name}, and no message arrives"
