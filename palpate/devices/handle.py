"""What is known of a device at its handle, for the passivity layer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate import _core
from palpate.base.errors import DeviceError

MASS = 0.2
"""Moving mass of a device that does not state its own [kg]."""


@dataclass(frozen=True)
class AtHandle:
    """What is known of a device at its handle, along any direction.

    Raises:
        DeviceError: `friction` or `damping` without `resolution`: noise would count as motion that takes energy.
    """

    resolution: float = 0.0
    """Resolution of the measured position, 0: unknown [m]."""
    mass: float = MASS
    """Moving mass [kg]."""
    delay: float | None = None
    """Time from the measurement to the force on the hand; None: not stated [s]."""
    friction: float = 0.0
    """Dry friction that certainly resists a motion [N]."""
    damping: float = 0.0
    """Viscous friction that certainly resists a motion [N s/m]."""

    def __post_init__(self) -> None:
        """Refuse friction of a handle whose position is not known."""
        for name in ("resolution", "friction", "damping"):
            if not 0.0 <= getattr(self, name) < np.inf:
                what = f"{name} = {getattr(self, name):g} of the device: must be 0 or more, and finite"
                raise DeviceError(what, mend="give what palpate device bench measures")
        if (self.friction > 0.0 or self.damping > 0.0) and self.resolution == 0.0:
            what = (
                "friction and damping of a device count only with its resolution: noise is no motion that they resist"
            )
            raise DeviceError(
                what, mend="give the step of the position, or six times its noise if that is larger, in m"
            )

    def certain_friction(self) -> _core.CertainFriction:
        """The friction along the axes of the base; three of Fc / sqrt(3) take no more than Fc along the motion."""
        found = _core.CertainFriction()
        if self.friction > 0.0 or self.damping > 0.0:
            found.at_handle = True
            found.coulomb = np.full(3, self.friction / np.sqrt(3.0))
            found.viscous, found.quantum = np.full(3, self.damping), np.full(3, self.resolution)
        return found


UNKNOWN = AtHandle()
