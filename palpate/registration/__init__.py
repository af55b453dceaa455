"""Registration of frames from measurements, with the error predicted at the target.

`points` maps fiducials onto fiducials, `surface` a partial cloud onto a surface. `handeye` finds a camera on or beside
an arm, `camera` a camera from the tool tip seen in it, and `pivot` the tip of a tool.
"""

from palpate.registration.fiducials import PointRegistration as PointRegistration
from palpate.registration.fiducials import points as points

__all__ = ["PointRegistration", "points"]
