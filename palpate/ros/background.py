"""A node of Python that runs in a thread of its own, beside the haptic nodes."""

from __future__ import annotations

import threading
from contextlib import suppress
from typing import Any, Self

from palpate import ros


class BackgroundNode:
    """A node whose callbacks run in a thread from `spin` until `close`.

    Args:
        name: name of the node.
        domain: ROS domain, e.g. that of a session's context.
        space: namespace without slashes; empty: none.
    """

    def __init__(self, name: str, domain: int, space: str = "") -> None:
        ros.messages()
        import rclpy
        from rclpy.context import Context
        from rclpy.executors import SingleThreadedExecutor

        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self.node: Any = rclpy.create_node(
            name, namespace=f"/{space}" if space else None, context=self._context, enable_rosout=False
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._spin, name=name, daemon=True)

    def spin(self) -> None:
        """Run the callbacks from now on."""
        self._thread.start()

    def close(self) -> None:
        """Remove the node from the network."""
        import rclpy

        if self._thread.is_alive():
            self._executor.shutdown(timeout_sec=2.0)
            self._thread.join(timeout=2.0)
            self.node.destroy_node()
            rclpy.shutdown(context=self._context)

    def __enter__(self) -> Self:
        """Return the object itself."""
        return self

    def __exit__(self, *error: object) -> None:
        """Close the node."""
        self.close()

    def _spin(self) -> None:
        from rclpy.executors import ExternalShutdownException

        with suppress(ExternalShutdownException):
            self._executor.spin()
