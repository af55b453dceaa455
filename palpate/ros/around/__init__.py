"""What stands around the haptic node: frames, models, markers, diagnostics, parameters, another scene.

All of it looks at the newest tick from a thread of its own, some thirty times a second; nothing here is in the way of
a force (Python, rclpy).
"""

from palpate.ros.around.node import Around

__all__ = ["Around"]
