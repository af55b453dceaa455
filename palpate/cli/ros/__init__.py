"""On ROS 2: a simulated dVRK, and the node that makes a CRTK master feel. `palpate ros` lists the commands."""

FIRST = ("setup", "sim", "haptics", "topic", "keystore")


def prepare() -> None:
    """Settle which ROS 2 is used, before anything of it is imported."""
    from palpate.ros import where

    where.settle()
