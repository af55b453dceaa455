"""A node of Python that runs in a thread of its own, beside the haptic nodes."""

from __future__ import annotations

from typing import Any, Self

from palpate import ros
from palpate.base.node_thread import NodeThread


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

        context = Context()
        rclpy.init(context=context, domain_id=domain)
        self.node: Any = rclpy.create_node(
            name, namespace=f"/{space}" if space else None, context=context, enable_rosout=False
        )
        self._thread = NodeThread(self.node, context, name)

    def spin(self) -> None:
        """Run the callbacks from now on."""
        self._thread.start()

    def close(self) -> None:
        """Remove the node from the network."""
        self._thread.stop()

    def __enter__(self) -> Self:
        """Return the object itself."""
        return self

    def __exit__(self, *error: object) -> None:
        """Close the node."""
        self.close()
