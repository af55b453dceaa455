"""Palpate on ROS 2: a simulated dVRK, and the node that makes a CRTK master feel. `palpate ros --help`.

Messages become structs of the core, and back; there is no law of control here. The nodes run in C++ outside the
interpreter (`cpp/`), compiled once against the ROS 2 at hand (`build.py`).
"""

from __future__ import annotations

from palpate.ros.build import load as load
from palpate.ros.build import messages as messages

__all__ = ["load", "messages"]
