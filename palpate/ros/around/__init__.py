"""ROS interfaces around the haptic node: frames, models, markers, diagnostics, parameters, change of scene.

They read the newest tick in their own thread at 30 Hz (Python, rclpy), outside the path of the force.
"""

from palpate.ros.around.node import Around

__all__ = ["Around"]
