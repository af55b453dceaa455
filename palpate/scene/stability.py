"""Section `stability` of a scene file: caps, passivity, virtual coupling and low-pass filter (docs/stability.md)."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BeforeValidator, Field

from palpate import _core
from palpate.base.values import NotNegative, Positive, Section

_S = _core.SimulationOptions().stability
_SPEED, _SOFT = 0.2, 250.0  # [m/s], [N/m]: a rate cap that a wall outruns gives the hand energy (docs/stability.md)

Share = Annotated[NotNegative, Field(le=1.0)]


def _off(given: object) -> object:
    """YAML 1.1 reads a bare ``off`` as false."""
    return "off" if given is False else given


class StabilitySection(Section):
    """Limits and passivity of the force: the last stage before the torques."""

    force_cap: Positive = _S.force_cap
    """maximum force on the hand [N]"""
    rate_cap: Positive = _S.rate_cap
    """maximum rate of change of the force; when left out 50 N/s, and more where an object feels stiffer than 500 N/m:
    0.2 m/s times the felt stiffness less 250 N/m [N/s]"""
    moment_cap: NotNegative = _S.moment_cap
    """maximum moment on the hand; 0: forces only [N m]"""
    moment_rate_cap: Positive = _S.moment_rate_cap
    """maximum rate of change of the moment [N m/s]"""
    stale_after: Positive = _S.stale_after
    """maximum age of a measured state; with older states the force ramps to zero [s]"""
    passivity: Annotated[Literal["observer", "tank", "off"], BeforeValidator(_off)] = _S.passivity
    """observer: the hand receives at most the energy it put in, of which the account keeps what the springs store now
    and a reserve to remove the force; tank: at most the energy in a tank of fixed capacity; off: no limit"""
    allowance: NotNegative = _S.allowance
    """energy that the hand may receive beyond this limit [J]"""
    tank_capacity: NotNegative = _S.tank_capacity
    """capacity of the tank, whose excess is discarded; in all modes also the largest energy that fixtures which are
    switched on may credit in all, until the hand's work repays it [J]"""
    moving_share: Share = _S.moving_share
    """fraction of the work of moving objects and of other hands' instruments that this hand may receive; 0: none, a
    hand that is pushed feels no more than it has paid for; 1: all of it [-]"""
    known_delay: Annotated[NotNegative, Field(le=1.0)] | None = None
    """delay from a measurement to the force, assumed by the layer; when left out the loop's own mean delay, or for a
    device of your own that which its driver states [s]"""
    delay_doubt: Annotated[NotNegative, Field(le=1.0)] | None = None
    """the true delay may be longer by this time, and every force is paid for the worst case; when left out 0, or 3 ms
    for a device whose delay nobody states [s]"""
    friction_share: Share = 0.5
    """certified fraction of the arm's friction, less what torque.friction_gain or the control law removes [-]"""
    acceleration: Positive | None = None
    """maximum acceleration of the handle assumed by the layer; when left out 5 m/s^2, or, if larger, the acceleration
    that force_cap gives to a handle held by a relaxed hand of 50 g [m/s^2]"""
    angular_acceleration: Positive = _S.angular_acceleration
    """maximum angular acceleration of the handle assumed by the layer [rad/s^2]"""
    speed: Positive = _S.speed
    """fastest motion of the handle along the largest force for which the observer keeps a reserve [m/s]"""
    angular_speed: Positive = _S.angular_speed
    """fastest rotation of the handle along the largest moment for which the observer keeps a reserve [rad/s]"""
    coupling_stiffness: NotNegative = _S.coupling_stiffness
    """stiffness of a virtual coupling between handle and virtual tool; 0: no coupling [N/m]"""
    coupling_damping: NotNegative = _S.coupling_damping
    """damping of the virtual coupling [N s/m]"""
    low_pass: NotNegative = _S.low_pass
    """cut-off of a low-pass filter of the force; 0: no filter [Hz]"""

    def following(self, stiffness: float) -> Self:
        """The section with a rate cap, unless it has one, at which the force follows a hand that taps.

        Args:
            stiffness: largest stiffness that the hand feels [N/m].
        """
        made = self.model_copy()
        if "rate_cap" not in self.model_fields_set:
            object.__setattr__(made, "rate_cap", max(_S.rate_cap, _SPEED * (stiffness - _SOFT)))  # still not given
        return made
