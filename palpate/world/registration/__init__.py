"""Registration of frames from measurements, with the error predicted at the target.

`points` maps fiducials onto fiducials, `surface` a partial cloud onto a surface. `handeye` finds a camera on or beside
an arm, `camera` a camera from the tool tip seen in it, and `pivot` the tip of a tool.
"""

from palpate.world.registration.fiducials import PointRegistration as PointRegistration
from palpate.world.registration.fiducials import points as points
from palpate.world.registration.hand_eye import HandEye as HandEye
from palpate.world.registration.hand_eye import handeye as handeye
from palpate.world.registration.surfaces import SurfaceRegistration as SurfaceRegistration
from palpate.world.registration.surfaces import surface as surface
from palpate.world.registration.tip import Pivot as Pivot
from palpate.world.registration.tip import pivot as pivot
from palpate.world.registration.tip_seen import CameraRegistration as CameraRegistration
from palpate.world.registration.tip_seen import camera as camera

__all__ = [
    "CameraRegistration",
    "HandEye",
    "Pivot",
    "PointRegistration",
    "SurfaceRegistration",
    "camera",
    "handeye",
    "pivot",
    "points",
    "surface",
]
