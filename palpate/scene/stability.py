"""The stage `stability` in a scene file: caps, passivity, virtual coupling, low-pass (docs/stability.md)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from palpate import _core
from palpate.values import NotNegative, Positive, Section

_S = _core.SimulationOptions().stability

Share = Annotated[NotNegative, Field(le=1.0)]


def _off(given: object) -> object:
    """YAML 1.1 reads a bare ``off`` as false."""
    return "off" if given is False else given


class StabilitySection(Section):
    """The last word on the force."""

    force_cap: Positive = _S.force_cap
    """largest force on the hand [N]"""
    rate_cap: Positive = _S.rate_cap
    """largest change of it [N/s]"""
    moment_cap: NotNegative = _S.moment_cap
    """largest moment on the hand; 0: forces only [N m]"""
    moment_rate_cap: Positive = _S.moment_rate_cap
    """largest change of it [N m/s]"""
    stale_after: Positive = _S.stale_after
    """states older than this are not trusted: the force ramps to zero [s]"""
    passivity: Annotated[Literal["observer", "tank", "off"], BeforeValidator(_off)] = _S.passivity
    """observer: the hand gets back no more energy than it ever put in; tank: no more than the tank holds"""
    allowance: NotNegative = _S.allowance
    """energy that may be given beyond that [J]"""
    tank_capacity: NotNegative = _S.tank_capacity
    """of the tank: what the hand put in beyond it is forgotten [J]"""
    known_delay: Annotated[NotNegative, Field(le=1.0)] | None = None
    """what the layer knows of the loop's delay; all of it when left out [s]"""
    friction_share: Share = 0.5
    """share of the arm's own friction that surely is there, beside what torque.friction_gain takes off [-]"""
    acceleration: Positive | None = None
    """the handle is snatched away no faster than this; when left out 5 m/s^2, or more where force_cap throws a handle
    that is held by 50 g of a relaxed hand faster than that [m/s^2]"""
    angular_acceleration: Positive = _S.angular_acceleration
    """nor turns it faster [rad/s^2]"""
    coupling_stiffness: NotNegative = _S.coupling_stiffness
    """of a virtual coupling between handle and virtual tool; 0: none [N/m]"""
    coupling_damping: NotNegative = _S.coupling_damping
    """beside its spring [N s/m]"""
    low_pass: NotNegative = _S.low_pass
    """cut-off of a low-pass of the force; 0: none [Hz]"""
