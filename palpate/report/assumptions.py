"""Was the motion as slow as the paper's controller assumes (R22)?

Eq 13 keeps tau = J^T F + G(q) of the arm's dynamics (Eq 1) and drops M(q) a + C(q, v) v. What is dropped, the hand
feels beside the rendered force. Two limits say when that is no longer small:

* Inertia: Lambda |a| above 10 % of the force cap. Lambda = (J M^-1 J^T)^-1 is the arm's mass at the handle, 0.1 of the
  force is about the smallest change a hand notices (Weber fraction of force, 7 to 10 %).
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
_WINDOW = 0.05  # the acceleration is averaged over this: encoder steps are no motion [s]
_SAMPLES = 400


@dataclass(frozen=True)
class SlowMotion:
    """How far a run kept to slow motion."""

    peak_speed: float
    """Of the handle [m/s]."""
    peak_inertia: float
    """Largest force of inertia at the handle, Lambda |a| [N]."""
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
    half = max(1, round(0.5 * _WINDOW * rate))
    acceleration = np.zeros(len(ticks))
    if len(ticks) > 2 * half:
        smooth = _mean(velocity, half)
        acceleration[half:-half] = np.linalg.norm(smooth[2 * half :] - smooth[: -2 * half], axis=1) * rate / (2 * half)
    mass = _handle_mass(ticks["q"], leader)
    inertia = np.interp(np.arange(len(ticks)), mass[0], mass[1]) * acceleration
    limit = INERTIA_LIMIT * force_cap
    broken = (speed > SPEED_LIMIT) | (inertia > limit)
    first = float(ticks["t"][np.argmax(broken)]) if broken.any() else None
    return SlowMotion(
        peak_speed=float(speed.max(initial=0.0)),
        peak_inertia=float(inertia.max(initial=0.0)),
        mass=float(np.median(mass[1])),
        force_limit=limit,
        broken_s=float(broken.sum() / rate),
        first=first,
    )


def _mean(values: NDArray[np.float64], half: int) -> NDArray[np.float64]:
    """Moving average over `half` rows to either side (n, 3); rows near the ends stay as they are."""
    total = np.cumsum(np.vstack([np.zeros(3), values]), axis=0)
    out = values.copy()
    width = 2 * half + 1
    out[half : len(values) - half] = (total[width:] - total[:-width]) / width
    return out


def _handle_mass(q: NDArray[np.float64], leader: str) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Ticks sampled over the run, and the arm's largest translational mass at the handle there [kg]."""
    rows = np.unique(np.linspace(0, len(q) - 1, min(_SAMPLES, len(q))).astype(np.int64))
    try:
        arm = Arm.mtm(leader.removeprefix("mtm_"))
    except (PalpateError, ValueError):
        return rows, np.full(len(rows), 1.0)
    masses = []
    for row in rows:
        J = arm.jacobian(q[row])[:3]
        inverse = J @ np.linalg.solve(arm.mass_matrix(q[row]), J.T)  # Lambda^-1
        masses.append(1.0 / max(1e-9, float(np.linalg.eigvalsh(inverse)[0])))
    return rows, np.array(masses)
