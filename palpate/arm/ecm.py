"""The endoscope arm (ECM): pose of its camera, and joints for a pose in closed form.

Frames: B base of the arm at its remote centre of motion, E end of the endoscope with z along its axis, C camera with x
to the right and y down in the picture and z into it. An endoscope with a tilt looks up in its picture by this angle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from palpate.arm.arm import Arm, models_folder
from palpate.base.arrays import Array, so3
from palpate.base.errors import ArmError

TILTS = (-30.0, 0.0, 30.0)
"""Tilts of the endoscopes of a da Vinci [deg]: down, straight, up."""
TOLERANCE = (1e-6, 1e-6)
"""Errors up to which a pose counts as reached [m, rad]."""

R_DL = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
"""Orientation (3, 3) of the base L of an MTM (x left, y towards the operator, z up) in the display D."""
R_CD = np.diag([1.0, -1.0, -1.0])
"""Orientation (3, 3) of the display D (x right, y up, z towards the operator) in the camera C (x right, y down)."""


def follows_picture(R_WC: Array) -> Array:
    """Orientation R_WL (3, 3) of an MTM's base for which motions of the hand follow the picture of a camera.

    R_WC: orientation (3, 3) of the camera. A motion to the right, up, or towards the operator moves the tool to the
    right, up, or out of the picture.
    """
    return np.asarray(R_WC @ R_CD @ R_DL)


def _angle(R: Array) -> float:
    """Angle of a rotation (3, 3) [rad]."""
    sine = 0.5 * float(np.linalg.norm([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]))
    return math.atan2(sine, 0.5 * (float(np.trace(R)) - 1.0))


def _model() -> Arm:
    return Arm.load(models_folder() / "ecm.yaml")


@dataclass(frozen=True)
class Ecm:
    """An endoscope arm with a tilted endoscope.

    Joints q (4,): yaw, pitch [rad], insertion [m], roll [rad].
    """

    tilt_deg: float = 0.0
    """angle by which the camera looks up from the axis of the endoscope [deg]"""
    arm: Arm = field(default_factory=_model)

    @property
    def R_EC(self) -> Array:
        """Orientation (3, 3) of the camera in the end of the endoscope."""
        return so3.about((1.0, 0.0, 0.0), math.radians(self.tilt_deg))

    def camera(self, q: ArrayLike) -> Array:
        """Pose X_BC (4, 4) of the camera at the joints q (4,)."""
        X = self.arm.fk(np.asarray(q, dtype=float))
        X[:3, :3] = X[:3, :3] @ self.R_EC
        return np.asarray(X)

    def inverse(self, X_BC: ArrayLike) -> Array:
        """Joints q (4,) at which the camera has the pose X_BC (4, 4).

        The axis of the endoscope goes through the remote centre, so the position fixes yaw, pitch and insertion, and
        the rotation about the axis fixes the roll.

        Raises:
            ArmError: the pose is beyond the joint limits, or the camera does not look along a line that the remote
                centre allows; the message names the distance.
        """
        X = np.asarray(X_BC, dtype=float)
        q = self.nearest(X)
        missed = self.camera(q)
        far = float(np.linalg.norm(missed[:3, 3] - X[:3, 3]))
        turned = _angle(missed[:3, :3].T @ X[:3, :3])
        if far <= TOLERANCE[0] and turned <= TOLERANCE[1]:
            return q
        p = ", ".join(f"{1e3 * x:.1f}" for x in X[:3, 3])
        raise ArmError(
            f"the endoscope arm cannot bring its camera to ({p}) mm in its base frame with this direction of view",
            why=f"the nearest pose is {1e3 * far:.2f} mm and {math.degrees(turned):.2f} degrees away: the endoscope "
            "pivots about its remote centre, and its joints have limits",
            mend="move the base of the arm, or give a view along a line through the remote centre",
        )

    def nearest(self, X_BC: ArrayLike) -> Array:
        """Joints q (4,) within the limits, by the position of X_BC (4, 4) and its rotation about the axis."""
        X = np.asarray(X_BC, dtype=float)
        R_BE, p = X[:3, :3] @ self.R_EC.T, X[:3, 3]
        length = float(np.linalg.norm(p))
        d = p / length if length > 1e-9 else R_BE[:, 2]
        q = np.zeros(4)
        q[0], q[1] = math.atan2(d[0], -d[2]), -math.asin(np.clip(d[1], -1.0, 1.0))
        q[2] = length + float(self.arm.fk(np.zeros(4))[2, 3])  # the tip lies on -z of the base at zero
        R_0E = self.arm.fk(q)[:3, :3].T @ R_BE
        q[3] = math.atan2(R_0E[1, 0] - R_0E[0, 1], R_0E[0, 0] + R_0E[1, 1])
        return np.clip(q, self.arm.q_min, self.arm.q_max)

    def turning(self, q: ArrayLike) -> Array:
        """Angular velocity of the camera in its own axes per velocity of yaw, pitch and roll: matrix (3, 3)."""
        q = np.asarray(q, dtype=float)
        J = np.asarray(self.arm.jacobian(q))[3:, [0, 1, 3]]
        return np.asarray(self.camera(q)[:3, :3].T @ J)
