"""Checks whether the motion was as slow as the control law assumes.

Eq 13 keeps tau = J^T F + G(q) of the arm's dynamics (Eq 9) and neglects Lambda a + Gamma v, which the hand feels in
addition to the rendered force. The cycle estimates this force at every tick (signal `F_neglected`,
core/palpate/torque): Lambda and Gamma v come from the controller's model at the handle, and a is the handle's
acceleration below 10 Hz, which covers voluntary motion but not encoder steps and stick-slip. Above `torque.fast_force`
the cycle sets status `too_fast`. The default, 0.3 N, is a tenth of the default force cap, about the smallest change
of force that a hand notices (Weber fraction 7 to 10 %). Control laws that compensate a part neglect only the rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate import _core
from palpate.record.ticks import STATUS, Ticks
from palpate.report.digest import Digest

FAST_FORCE = float(_core.TorqueOptions().fast_force)
"""Default of `torque.fast_force` [N]."""


@dataclass(frozen=True)
class SlowMotion:
    """Speed and neglected force of a run."""

    peak_speed: float
    """Peak speed of the handle [m/s]."""
    peak_inertia: float
    """Largest force of the arm's dynamics at the handle that the control law neglects [N]."""
    force_limit: float
    """Limit for `peak_inertia` [N]."""
    broken_s: float
    """Time above the limit [s]."""
    first: float | None
    """First time above the limit [s]; None if never."""

    @property
    def kept(self) -> bool:
        """True if the assumption holds throughout."""
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
            "During that time the hand feels the arm's inertia in addition to the rendered force."
        )


def slow_motion_of(digest: Digest, fast_force: float = FAST_FORCE) -> SlowMotion:
    """As `slow_motion`, of a digested run."""
    ticks = digest.ticks
    return SlowMotion(
        peak_speed=float(np.linalg.norm(ticks["v_LH"], axis=1).max(initial=0.0)),
        peak_inertia=float(ticks["F_neglected"].max(initial=0.0)),
        force_limit=fast_force,
        broken_s=digest.status["too_fast"] / digest.rate,
        first=digest.first_fast,
    )


def slow_motion(ticks: Ticks, rate: float, *, fast_force: float = FAST_FORCE) -> SlowMotion:
    """Summarises the neglected force over a run.

    Args:
        ticks: (n,) ticks of the run.
        rate: tick rate [Hz].
        fast_force: limit `torque.fast_force` of the scene [N].
    """
    broken = (ticks["status"].astype(np.int64) & STATUS["too_fast"][0]) != 0
    return SlowMotion(
        peak_speed=float(np.linalg.norm(ticks["v_LH"], axis=1).max(initial=0.0)),
        peak_inertia=float(ticks["F_neglected"].max(initial=0.0)),
        force_limit=fast_force,
        broken_s=float(broken.sum() / rate),
        first=float(ticks["t"][np.argmax(broken)]) if broken.any() else None,
    )
