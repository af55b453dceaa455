"""Was the motion as slow as the paper's controller assumes (R22)?

Eq 13 keeps tau = J^T F + G(q) of the arm's dynamics (Eq 1) and drops M(q) a + C(q, v) v. What is dropped, the hand
feels beside the rendered force. Two limits say when that is no longer small:

* Inertia: |Lambda a| above 10 % of the force cap. Lambda = (J M^-1 J^T)^-1 is the arm's mass at the handle, 0.1 of the
  force is about the smallest change a hand notices (Weber fraction of force, 7 to 10 %). The acceleration is the mean
  over 0.1 s, which keeps the motions a hand makes on purpose (below 5 Hz) and drops encoder steps and stick-slip.
* Speed above 0.25 m/s: centripetal and Coriolis forces grow with the square of the speed. At the arm's reach of 0.38 m
  a mass of 1 kg then pulls with v^2 / r = 0.16 N, as much as the friction of a real MTM at its handle (0.04 to 0.16 N).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.arm import Arm
from palpate.errors import PalpateError
from palpate.record.ticks import Ticks

SPEED_LIMIT = 0.25
"""Of the handle [m/s]."""
INERTIA_LIMIT = 0.10
"""Share of the force cap that inertia may reach."""
_WINDOW = 0.1  # the acceleration is the mean over this [s]
_SAMPLES = 400


@dataclass(frozen=True)
class SlowMotion:
    """How far a run kept to slow motion."""

    peak_speed: float
    """Of the handle [m/s]."""
    peak_inertia: float
    """Largest force of inertia at the handle, |Lambda a| [N]."""
    mass: float
    """The arm's mass at the handle, in the direction where it is heaviest, median over the run [kg]."""
    force_limit: float
    """What `peak_inertia` is compared with [N]."""
    broken_s: float
    """Time in which either limit was passed [s]."""
    first: float | None
    """When first [s]; None if never."""

    @property
    def kept(self) -> bool:
        """Does the assumption hold throughout?"""
        return self.first is None

    @property
    def words(self) -> str:
        """The verdict in a sentence."""
        facts = (
            f"handle up to {self.peak_speed:.2f} m/s (limit {SPEED_LIMIT:.2f}), "
            f"inertia up to {self.peak_inertia:.2f} N (limit {self.force_limit:.2f})"
        )
        if self.kept:
            return f"The motion was slow enough throughout: {facts}."
        return (
            f"The motion was too fast for {self.broken_s:.2f} s, first at t = {self.first:.2f} s: {facts}. "
            "There the hand feels the arm's inertia beside the rendered force."
        )


def slow_motion(ticks: Ticks, rate: float, *, leader: str = "mtm_right", force_cap: float = 3.0) -> SlowMotion:
    """Compare a run with the assumption.

    Args:
        ticks: (n,).
        rate: of the ticks [Hz].
        leader: arm of the scene, ``mtm_right`` or ``mtm_left``.
        force_cap: [N].
    """
    velocity = ticks["v_LH"]
    speed = np.linalg.norm(velocity, axis=1)
    step = max(1, round(_WINDOW * rate))
    inertia = np.zeros(len(ticks))
    rows, Lambda = _handle_inertia(ticks["q"], leader)
    if len(ticks) > step:
        acceleration = (velocity[step:] - velocity[:-step]) * rate / step
        middle = np.arange(len(acceleration)) + step // 2
        nearest = Lambda[np.searchsorted(rows, middle).clip(0, len(rows) - 1)]
        inertia[middle] = np.linalg.norm(np.einsum("nij,nj->ni", nearest, acceleration), axis=1)
    limit = INERTIA_LIMIT * force_cap
    broken = (speed > SPEED_LIMIT) | (inertia > limit)
    first = float(ticks["t"][np.argmax(broken)]) if broken.any() else None
    return SlowMotion(
        peak_speed=float(speed.max(initial=0.0)),
        peak_inertia=float(inertia.max(initial=0.0)),
        mass=float(np.median(np.linalg.eigvalsh(Lambda)[:, -1])),
        force_limit=limit,
        broken_s=float(broken.sum() / rate),
        first=first,
    )


def _handle_inertia(q: NDArray[np.float64], leader: str) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Ticks sampled over the run, and the arm's inertia Lambda (k, 3, 3) at the handle there, in L [kg]."""
    rows = np.unique(np.linspace(0, len(q) - 1, min(_SAMPLES, len(q))).astype(np.int64))
    try:
        arm = Arm.mtm(leader.removeprefix("mtm_"))
    except (PalpateError, ValueError):
        return rows, np.tile(np.eye(3), (len(rows), 1, 1))
    inertias = []
    for row in rows:
        J = arm.jacobian(q[row])[:3]
        inverse = J @ np.linalg.solve(arm.mass_matrix(q[row]), J.T)  # Lambda^-1
        inertias.append(np.linalg.inv(inverse + 1e-3 * np.eye(3)))  # a stretched elbow cannot make it infinite
    return rows, np.array(inertias)
