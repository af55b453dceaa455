"""The node `/palpate`, which runs next to the haptic node."""

from __future__ import annotations

import threading
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Self

from palpate import ros

if TYPE_CHECKING:
    from palpate.ros.haptics import HapticSession

RATE = 30.0
"""Rate of frames and markers [Hz]; diagnostics are published at the usual 1 Hz."""
NAME = "palpate"


class Around:
    """Publishes a session while the context is open.

        with HapticSession(scene) as session, Around(session):
            session.run()

    Args:
        session: the session, started or not.
        name: name of the node.
        pair: name of the session's pair, which is the namespace of the node: names and topics of several sessions on
            one network differ.
        draws_objects: False leaves out the frames of the objects, which another pair publishes.
    """

    def __init__(self, session: HapticSession, name: str = NAME, pair: str = "", draws_objects: bool = True) -> None:
        ros.messages()
        import rclpy
        from rclpy.context import Context
        from rclpy.executors import SingleThreadedExecutor

        from palpate.ros.around.diagnostics import Diagnostics
        from palpate.ros.around.frames import Frames
        from palpate.ros.around.markers import Markers
        from palpate.ros.around.swap import Swap

        self._context = Context()
        rclpy.init(context=self._context, domain_id=session.loop.context.domain)
        self.node: Any = rclpy.create_node(
            name, namespace=f"/{pair}" if pair else None, context=self._context, enable_rosout=False
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        frames, markers = Frames(self.node, session, pair, draws_objects), Markers(self.node, session)
        Swap(self.node, session, on_swap=markers.draw_objects)

        def show() -> None:
            tick = session.latest()
            frames.show(tick)
            markers.show(tick)

        self.node.create_timer(1.0 / RATE, show)
        self.node.create_timer(1.0, Diagnostics(self.node, session).publish)
        self._thread = threading.Thread(target=self._spin, name="palpate-around", daemon=True)
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
