"""How the motion of the hands moves the picture while the camera pedal is pressed.

The hands hold the picture: it goes where they go. With C the vector from the operator's eye to the middle between the
hands, n the direction from the left to the right hand, and index 0 for the moment at which the pedal was pressed:

    pan       = azimuth(C) - azimuth(C0)          the picture turns to the right with the hands
    tilt      = elevation(C) - elevation(C0)      up with the hands
    insertion = |C0| - |C|                        the hands come nearer: the picture comes nearer
    roll      = angle of n x C - angle of n0 x C0 in the plane of the picture, counter-clockwise

These are the angles that mtsTeleOperationECM of sawIntuitiveResearchKit uses. One hand has no direction n: it pans,
tilts and inserts, and the picture does not roll.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

REACH = 0.4
"""Distance from the eye to the middle between the hands when the pedal is pressed, unless the eye is given [m]."""
APART = 0.01
"""Distance between the hands below which they define no direction [m]."""


class PictureMotion(NamedTuple):
    """Motion of the picture: pan to the right, tilt up, roll counter-clockwise [rad], insertion to the scene [m]."""

    pan: float = 0.0
    tilt: float = 0.0
    insertion: float = 0.0
    roll: float = 0.0

    def minus(self, other: PictureMotion) -> PictureMotion:
        """What is left of this motion after another one."""
        return PictureMotion(*(a - b for a, b in zip(self, other, strict=True)))


def picture_motion(hands0: ArrayLike, hands: ArrayLike, eye: ArrayLike | None = None) -> PictureMotion:
    """Motion of the picture since the pedal was pressed.

    Args:
        hands0: positions (n, 3) of one hand, or of the left and the right hand, in the display D when the pedal was
            pressed [m].
        hands: their positions now.
        eye: position (3,) of the eye in D [m]; `REACH` in front of the middle of the hands at the start when left out.
    """
    first, now = np.atleast_2d(np.asarray(hands0, dtype=float)), np.atleast_2d(np.asarray(hands, dtype=float))
    p_eye = first.mean(axis=0) + np.array([0.0, 0.0, REACH]) if eye is None else np.asarray(eye, dtype=float)
    C0, C = first.mean(axis=0) - p_eye, now.mean(axis=0) - p_eye
    roll = 0.0
    if len(first) == 2 and min(np.linalg.norm(pair[1] - pair[0]) for pair in (first, now)) > APART:
        up0, up = (np.cross(pair[1] - pair[0], mid) for pair, mid in ((first, C0), (now, C)))
        roll = _wrapped(math.atan2(up[1], up[0]) - math.atan2(up0[1], up0[0]))
    return PictureMotion(
        _wrapped(math.atan2(C[0], -C[2]) - math.atan2(C0[0], -C0[2])),
        _wrapped(math.atan2(C[1], -C[2]) - math.atan2(C0[1], -C0[2])),
        float(np.linalg.norm(C0) - np.linalg.norm(C)),
        roll,
    )


def _wrapped(angle: float) -> float:
    return math.remainder(angle, math.tau)
