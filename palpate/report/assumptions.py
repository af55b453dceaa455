"""Was the motion as slow as the control law assumes?

Eq 13 keeps tau = J^T F + G(q) of the arm's dynamics (Eq 9) and drops Lambda a + Gamma v. What is dropped, the hand
feels beside the rendered force. The cycle estimates it at every tick (signal `F_neglected`, core/palpate/torque):
Lambda and Gamma v of the controller's model at the handle, a its acceleration below 10 Hz, which keeps the motions a
hand makes on purpose and drops encoder steps and stick-slip. Above `torque.fast_force` status `too_fast` is set; its
default, 0.3 N, is a tenth of the default force cap, about the smallest change of force that a hand notices (Weber
fraction 7 to 10 %). Laws that compensate a part neglect only the rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate import _core
from palpate.record.ticks import STATUS, Ticks

FAST_FORCE = float(_core.TorqueOptions().fast_force)
"""Default of `torque.fast_force` [N]."""


@dataclass(frozen=True)
class SlowMotion:
    """How far a run kept to slow motion."""

    peak_speed: float
    """Of the handle [m/s]."""
    peak_inertia: float
    """Largest force of the arm's own dynamics at the handle that the law left to the hand [N]."""
    force_limit: float
    """What `peak_inertia` is compared with [N]."""
    broken_s: float
    """Time in which it was passed [s]."""
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
            f"inertia and Coriolis forces up to {self.peak_inertia:.2f} N (limit {self.force_limit:.2f}), "
            f"handle up to {self.peak_speed:.2f} m/s"
        )
        if self.kept:
            return f"The motion was slow enough throughout: {facts}."
        return (
            f"The motion was too fast for {self.broken_s:.2f} s, first at t = {self.first:.2f} s: {facts}. "
            "There the hand feels the arm's inertia beside the rendered force."
        )


def slow_motion(ticks: Ticks, rate: float, *, fast_force: float = FAST_FORCE) -> SlowMotion:
    """What the cycle found about a run, summed up.

    Args:
        ticks: (n,).
        rate: of the ticks [Hz].
        fast_force: of the scene's `torque` section, for the words [N].
    """
    broken = (ticks["status"].astype(np.int64) & STATUS["too_fast"][0]) != 0
    return SlowMotion(
        peak_speed=float(np.linalg.norm(ticks["v_LH"], axis=1).max(initial=0.0)),
        peak_inertia=float(ticks["F_neglected"].max(initial=0.0)),
        force_limit=fast_force,
        broken_s=float(broken.sum() / rate),
        first=float(ticks["t"][np.argmax(broken)]) if broken.any() else None,
    )
