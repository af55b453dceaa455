"""A haptic device with one axis: its parameters, its linear loop for the analysis, and its simulated loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate import _core
from palpate.arrays import Array
from palpate.certificate.loop import SampledLoop, difference
from palpate.errors import PalpateError
from palpate.hands import PRESETS, Hand

#: Speed of the fastest tap that a certificate considers [m/s]. Dry friction damps the fastest tap least.
TAP = 0.5


def as_viscous(friction: float | Array, speed: float | Array) -> Array:
    """Viscous friction that dissipates as much as dry friction in an oscillation of velocity amplitude `speed`.

    This is the describing function 4 Fc / (pi v) (Gelb and Vander Velde 1968, 2.3). Units: [N] and [m/s] give [N s/m];
    [N m] and [rad/s] give [N m s/rad].
    """
    return np.asarray(4.0 * friction / (np.pi * speed))


@dataclass(frozen=True)
class DeviceModel:
    """A device along one direction, its haptic loop, and the hands that hold it. All values are in SI units.

    Raises:
        PalpateError: a value is outside its physical range; the error names the value.
    """

    mass: float
    """Moving mass [kg]."""
    damping: float
    """Viscous friction of the device itself [N s/m]."""
    rate: float = 1000.0
    """Rate of the haptic cycle [Hz]."""
    delay: float = 0.0
    """Time from the position measurement to the force on the hand [s]."""
    jitter: float = 0.0
    """Upper bound of the random delay that is added in each cycle, uniform from 0 [s]."""
    filter: float = 0.0
    """Cut-off of the velocity's low pass; 0: the unfiltered difference of two positions [Hz]."""
    quantum: float = 0.0
    """Resolution of the position measurement at the handle; 0: ideal [m]."""
    friction: float = 0.0
    """Dry friction of the device at the handle [N]."""
    hand: Hand | tuple[Hand, ...] = tuple(PRESETS.values())
    """One hand, or the range of hands for which the loop must be stable."""

    def __post_init__(self) -> None:
        """Refuse values outside their physical range."""
        try:
            _core.Axis(self.axis(self.hands[0], 0.0, 0.0))
        except ValueError as error:
            what, _, mend = str(error).partition(": ")
            raise PalpateError(what.replace("axis", "device"), mend=mend) from None

    @property
    def hands(self) -> tuple[Hand, ...]:
        """The range of hands."""
        return (self.hand,) if isinstance(self.hand, Hand) else self.hand

    def loop(self, hand: Hand, lubricated: bool = True) -> SampledLoop:
        """Device and hand as a linear loop; the full jitter is added to the delay.

        lubricated: leave dry friction out. Otherwise it is replaced by the viscous friction that dissipates as much in
        an oscillation of velocity amplitude `TAP` (`as_viscous`).
        """
        M = self.mass + hand.mass
        D = self.damping + hand.damping + (0.0 if lubricated else as_viscous(self.friction, TAP))
        A = np.array([[0.0, 1.0], [-hand.stiffness / M, -D / M]])
        T = 1.0 / self.rate
        return SampledLoop(A, np.array([0.0, 1.0 / M]), np.array([1.0, 0.0]), T, self.delay + self.jitter,
                    velocity=difference(T, self.filter))  # fmt: skip

    def axis(self, hand: Hand, K: float, B: float, bilateral: bool = False) -> _core.AxisOptions:
        """Options of the simulated axis with all nonlinear effects, for a wall of K [N/m] and B [N s/m]."""
        o = _core.AxisOptions()
        o.mass, o.damping, o.coulomb, o.rate = self.mass, self.damping, self.friction, self.rate
        o.delay, o.jitter, o.quantum, o.velocity_cutoff = self.delay, self.jitter, self.quantum, self.filter
        o.hand_mass, o.hand_damping, o.hand_stiffness = hand.mass, hand.damping, hand.stiffness
        o.K, o.B, o.bilateral = K, B, bilateral
        return o
