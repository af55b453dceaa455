"""Palpate on ROS 2: a simulated dVRK, and the node that renders forces on a CRTK master.

This package converts messages to structs of the core and back; the control laws are in the core. The nodes run in C++
outside the interpreter (`cpp/`), and are compiled once against the installed ROS 2 (`build.py`).
"""

from __future__ import annotations

from palpate.ros.build import load as load
from palpate.ros.build import messages as messages

__all__ = ["load", "messages"]
