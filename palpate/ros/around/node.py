"""The node `/palpate`, beside the haptic one."""

from __future__ import annotations

import threading
from contextlib import suppress
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from palpate import ros

if TYPE_CHECKING:
    from palpate.ros.haptics import HapticSession

RATE = 30.0
"""Of frames and markers [Hz]; diagnostics come once a second, as is the custom."""
NAME = "palpate"


class Around:
    """Publishes a session until it is left.

        with HapticSession(scene) as session, Around(session):
            session.run()

    Args:
        session: that runs, or will.
        name: of the node, where several sessions are on one network.
    """

    def __init__(self, session: HapticSession, name: str = NAME) -> None:
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
        self.node: Any = rclpy.create_node(name, context=self._context, enable_rosout=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        frames, markers = Frames(self.node, session), Markers(self.node, session)
        Swap(self.node, session, on_swap=markers.draw_objects)

        def show() -> None:
            tick = session.latest()
            frames.show(tick)
            markers.show(tick)

        self.node.create_timer(1.0 / RATE, show)
        self.node.create_timer(1.0, Diagnostics(self.node, session).tell)
        self._thread = threading.Thread(target=self._spin, name="palpate-around", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Take the node from the network."""
        import rclpy

        if self._thread.is_alive():
            self._executor.shutdown(timeout_sec=2.0)
            self._thread.join(timeout=2.0)
            self.node.destroy_node()
            rclpy.shutdown(context=self._context)

    def __enter__(self) -> Self:
        """The same."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def _spin(self) -> None:
        from rclpy.executors import ExternalShutdownException

        with suppress(ExternalShutdownException):
            self._executor.spin()
