"""Run on ROS 2: a simulated dVRK, and the node that renders forces on a CRTK master. `palpate ros` lists commands."""

FIRST = ("setup", "sim", "haptics", "camera", "topic", "graph", "keystore")


def prepare() -> None:
    """Choose the ROS 2 installation before the first import from it."""
    from palpate.ros import where

    where.settle()
