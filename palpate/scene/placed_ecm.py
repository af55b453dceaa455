"""The endoscope arm in a scene: where it is placed, and the poses of its eyes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from palpate.arm.ecm import Ecm, follows_picture
from palpate.base.arrays import Array
from palpate.base.errors import ArmError, SceneError
from palpate.scene.ecm import EcmSection
from palpate.scene.hand import HandPlan
from palpate.scene.scene import Scene

_DISTANCE = 0.09  # of an automatic camera from the start of the path [m]
_VIEW = np.array([0.0, 1.0, -1.0]) / math.sqrt(2.0)  # its direction: away from the operator and down


@dataclass(frozen=True)
class PlacedEcm:
    """An endoscope arm in a scene."""

    ecm: Ecm
    X_WB: Array  # (4, 4) pose of its base [m]
    q0: Array  # (4,) joints at the start [rad, rad, m, rad]
    section: EcmSection

    def camera(self, q: Array) -> Array:
        """Pose X_WC (4, 4) of the camera in W, in the middle between both eyes, at joints q (4,)."""
        return np.asarray(self.X_WB @ self.ecm.camera(q))

    @property
    def R_WL(self) -> Array | None:
        """Orientation (3, 3) of a leader's base whose hand follows the picture at the start; None if it shall not."""
        return follows_picture(self.camera(self.q0)[:3, :3]) if self.section.follow_picture else None

    def eye(self, q: Array, side: Literal["left", "right"]) -> Array:
        """Pose (4, 4) of one eye in W, at joints q (4,)."""
        X = self.camera(q)
        X[:3, 3] += (0.5 if side == "right" else -0.5) * self.section.endoscope.baseline * X[:3, 0]
        return X


def place(scene: Scene, section: EcmSection, path: HandPlan) -> PlacedEcm:
    """The endoscope arm of a scene at the start.

    Raises:
        SceneError: the joints or the pose of the camera are out of reach; the message names the line.
    """
    ecm = Ecm(float(section.endoscope.tilt_deg))
    q = ecm.arm.home if section.joints is None else np.array(section.joints)
    _check_limits(scene, ecm, q)
    X_WB = section.base.matrix() if section.base is not None else _base_that_sees(ecm, q, path.positions_W[0])
    if section.camera is not None:
        try:
            q = ecm.inverse(np.linalg.inv(X_WB) @ section.camera.matrix())
        except ArmError as error:
            raise SceneError(error.what, where=scene.where("ecm", "camera"), why=error.why, mend=error.mend) from None
    return PlacedEcm(ecm, X_WB, q, section)


def _check_limits(scene: Scene, ecm: Ecm, q: Array) -> None:
    arm = ecm.arm
    for name, value, low, high in zip(arm.joint_names, q, arm.q_min, arm.q_max, strict=True):
        if not low <= value <= high:
            unit = "m" if name == "insertion" else "rad"
            raise SceneError(
                f"ecm.joints: {name} = {value:g} {unit} is outside its limits, {low:.3f} to {high:.3f} {unit}",
                where=scene.where("ecm", "joints"),
                mend="choose a value within the limits, or leave joints out",
            )


def _base_that_sees(ecm: Ecm, q: Array, p_W: Array) -> Array:
    """Pose (4, 4) of a base whose camera looks at a point (3,) in W."""
    right = np.array([1.0, 0.0, 0.0])
    R_WC = np.stack([right, np.cross(_VIEW, right), _VIEW], axis=1)
    X_WC = np.eye(4)
    X_WC[:3, :3], X_WC[:3, 3] = R_WC, p_W - _DISTANCE * _VIEW
    return np.asarray(X_WC @ np.linalg.inv(ecm.camera(q)))
