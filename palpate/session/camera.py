"""The endoscope arm of a running session: both hands move it while the camera pedal is pressed."""

from __future__ import annotations

import weakref
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from palpate.arm.ecm import R_CD
from palpate.base.arrays import Array, so3
from palpate.base.errors import ArmError
from palpate.record.ticks import Ticks
from palpate.scene.placed_ecm import PlacedEcm
from palpate.session import machine
from palpate.session.camera_hands import PictureMotion, picture_motion
from palpate.session.console import Hand

_DAMPING = 0.05  # of the inverse of the turning matrix near its singularity [-]


class CameraArm:
    """Moves the camera, and with it the axes in which the hands move the tools.

    The bases of the leaders and the display stand still in the room of the operator. The hands are therefore compared
    in the display D: X_DL of each leader is the one that the scene has at the start.

    Args:
        placed: the endoscope arm of the scene.
        X_WL0: pose (4, 4) of each leader's base at the start [m].
        hands: session of each leader, in the same order; the camera does not keep them alive.
    """

    def __init__(self, placed: PlacedEcm, X_WL0: Sequence[Array], hands: Sequence[Hand]) -> None:
        self.placed = placed
        self._q = np.array(placed.q0)
        self._hands = tuple(weakref.ref(hand) for hand in hands)
        X_WL = np.stack(list(X_WL0))
        R_WC0 = placed.camera(self._q)[:3, :3]
        self._R_CL = R_WC0.T @ X_WL[:, :3, :3]
        self._R_DL = R_CD.T @ self._R_CL
        self._p_DL = X_WL[:, :3, 3] @ (R_WC0 @ R_CD)  # up to one common shift, which has no effect
        self._hands0: Array | None = None
        self._holding = np.zeros(len(X_WL), dtype=bool)
        self._done = PictureMotion()
        self.steps = 0  #: number of periods in which the hands were asked; in lockstep only those with something to do

    @property
    def q(self) -> Array:
        """Joints (4,): yaw, pitch [rad], insertion [m], roll [rad]."""
        return self._q.copy()

    @property
    def X_WC(self) -> Array:
        """Pose (4, 4) of the camera in W [m]."""
        return self.placed.camera(self._q)

    @property
    def at_rest(self) -> bool:
        """True unless a hand moved the camera in the last period."""
        return self._hands0 is None

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

    def steer(self, ticks: Sequence[Ticks], dt: float) -> None:
        """One period [s] with the newest tick of each hand: the hands in the state `camera` move the camera."""
        self.steps += 1
        pressed = [machine.name_of(float(tick["session_state"])) == "camera" for tick in ticks]
        if not any(pressed):
            self._rest()
            return
        self.step(pressed, [tick["p_LH"] for tick in ticks], dt)

    def step(self, pressed: bool | Sequence[bool], p_LH: ArrayLike, dt: float) -> None:
        """One period with the handles at p_LH (n, 3), in the bases of their leaders.

        Args:
            pressed: the session of each hand is in the state `camera`; one value for all hands.
            p_LH: positions of the handles [m].
            dt: time since the last step [s].
        """
        p_LH = np.atleast_2d(np.asarray(p_LH, dtype=float))
        holding = np.asarray(pressed, dtype=bool) & np.isfinite(p_LH).all(axis=1)
        if not holding.any():
            self._rest()
            return
        hands = (np.einsum("nij,nj->ni", self._R_DL, p_LH) + self._p_DL)[holding]
        if self._hands0 is None or not np.array_equal(holding, self._holding):
            self._hands0, self._holding, self._done = hands, holding, PictureMotion()
        motion = picture_motion(self._hands0, hands)
        self._follow(motion.minus(self._done), dt)
        self._done = motion

    def _rest(self) -> None:
        """No hand moves the camera."""
        self._hands0, self._done = None, PictureMotion()

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
        quats = so3.quaternions(self.X_WC[:3, :3] @ self._R_CL)
        for ref, quat in zip(self._hands, quats, strict=True):
            if (hand := ref()) is not None:
                hand.change(quat_WL=quat)
