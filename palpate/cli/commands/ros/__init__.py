"""Run on ROS 2: a simulated dVRK, forces on a CRTK master, motion plans on an arm. `palpate ros` lists commands."""

FIRST = ("setup", "sim", "haptics", "device", "move", "camera", "topic", "graph", "rviz", "keystore")


def prepare() -> None:
    """Choose the ROS 2 installation before the first import from it."""
    from palpate.ros import where

    where.settle()
