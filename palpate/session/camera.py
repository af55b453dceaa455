"""The endoscope arm of a running session: both hands move it while the camera pedal is pressed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from palpate.arm.ecm import R_CD
from palpate.arrays import Array, so3
from palpate.errors import ArmError
from palpate.scene.placed_ecm import PlacedEcm
from palpate.session.camera_hands import PictureMotion, picture_motion

_DAMPING = 0.05  # of the inverse of the turning matrix near its singularity [-]


class CameraArm:
    """Moves the camera, and with it the axes in which the hands move the tools.

    Args:
        placed: the endoscope arm of the scene.
        R_WL0: orientation (3, 3) of the leaders' base at the start.
        change: `LiveSession.change` of every hand.
    """

    def __init__(self, placed: PlacedEcm, R_WL0: Array, change: Sequence[Callable[..., Any]]) -> None:
        self.placed = placed
        self._q = np.array(placed.q0)
        self._R_WL0, self._change = np.asarray(R_WL0), tuple(change)
        R_WC0 = placed.camera(self._q)[:3, :3]
        self._R_CL = R_WC0.T @ self._R_WL0
        self._R_DL = R_CD.T @ self._R_CL  # hands in the display
        self._hands0: Array | None = None
        self._done = PictureMotion()

    @property
    def q(self) -> Array:
        """Joints (4,): yaw, pitch [rad], insertion [m], roll [rad]."""
        return self._q.copy()

    @property
    def X_WC(self) -> Array:
        """Pose (4, 4) of the camera in W [m]."""
        return self.placed.camera(self._q)

    def move_to(self, q: ArrayLike) -> None:
        """Place the joints (4,). The tools do not move: the hands are anchored anew.

        Raises:
            ArmError: a joint is outside its limits.
        """
        q, arm = np.asarray(q, dtype=float), self.placed.ecm.arm
        if q.shape != (4,) or not (np.all(q >= arm.q_min) and np.all(q <= arm.q_max)):
            limits = ", ".join(f"{low:.2f} to {high:.2f}" for low, high in zip(arm.q_min, arm.q_max, strict=True))
            raise ArmError(
                f"the endoscope arm cannot take the joints {np.round(q, 4).tolist()}", mend=f"limits: {limits}"
            )
        self._take(q)

    def look_from(self, X_WC: ArrayLike) -> None:
        """Place the camera at a pose (4, 4) in W; raises ArmError if it is out of reach."""
        self.move_to(self.placed.ecm.inverse(np.linalg.inv(self.placed.X_WB) @ np.asarray(X_WC, dtype=float)))

    def step(self, pressed: bool, p_LH: ArrayLike, dt: float) -> None:
        """One period with the hands at p_LH (n, 3), n = 1 or 2, in the order left, right, in their leaders' bases.

        Args:
            pressed: the session is in the state `camera`.
            p_LH: positions of the handles [m].
            dt: time since the last step [s].
        """
        hands = np.atleast_2d(np.asarray(p_LH, dtype=float)) @ self._R_DL.T
        if not (pressed and np.isfinite(hands).all()):
            self._hands0, self._done = None, PictureMotion()
            return
        if self._hands0 is None or len(self._hands0) != len(hands):
            self._hands0, self._done = hands, PictureMotion()
        motion = picture_motion(self._hands0, hands)
        self._follow(motion.minus(self._done), dt)
        self._done = motion

    def _follow(self, by: PictureMotion, dt: float) -> None:
        """Turn and insert the camera so that the picture moves by this, within the limits of joints and speed."""
        ecm = self.placed.ecm
        # The picture goes to the right if the camera turns to the left, about its y axis, which points down; and up if
        # the camera turns down, about its x axis, which points to the right.
        w_C = np.array([-by.tilt, -by.pan, by.roll])
        J = ecm.turning(self._q)
        turn = J.T @ np.linalg.solve(J @ J.T + _DAMPING**2 * np.eye(3) * (np.linalg.cond(J) > 50.0), w_C)
        step = np.array([turn[0], turn[1], by.insertion, turn[2]])
        most = ecm.arm.v_max * dt
        step *= min(1.0, float((most / np.maximum(np.abs(step), 1e-15)).min()))
        self._take(np.clip(self._q + step, ecm.arm.q_min, ecm.arm.q_max))

    def _take(self, q: Array) -> None:
        if np.array_equal(q, self._q):
            return
        self._q = q
        if not self.placed.section.follow_picture:
            return
        quat = so3.quaternions((self.X_WC[:3, :3] @ self._R_CL)[None])[0]
        for change in self._change:
            change(quat_WL=quat)
