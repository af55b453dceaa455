"""Scene keys of the leader's gripper and the follower's jaws, and the simulated hand's pinch over time."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from palpate import _core
from palpate.base.values import NotNegative, Number, Positive, Section

_M = _core.MappingOptions()
_Angle = Annotated[Number, Field(ge=-3.2, le=3.2)]
_MEND = "the pinch angle maps linearly from closed to open"


class GripPoint(Section):
    """Pinch angle of the simulated hand at a time."""

    t: NotNegative
    """time from the start [s]"""
    angle: _Angle
    """angle of the leader's gripper, 0: closed [rad]"""


class _Range(Section):
    @model_validator(mode="after")
    def _check(self) -> _Range:
        low, high = getattr(self, "closed"), getattr(self, "open")  # noqa: B009
        if not low < high:
            raise ValueError(f"closed: {low:g} rad is not below open: {high:g} rad | {_MEND}")
        return self


class GripperSection(_Range):
    """The leader's gripper: the range of its angle that moves the jaws, and the torque that its fingers feel."""

    closed: _Angle = _M.gripper_min
    """angle that closes the jaws [rad]"""
    open: _Angle = _M.gripper_max
    """angle that opens the jaws fully [rad]"""
    torque: Annotated[NotNegative, Field(le=2.0)] = 0.0
    """largest torque of the gripper on the operator's fingers, for a device whose driver has a function grip; the
    gripper of the dVRK's MTM has no motor [N m]"""


class JawSection(_Range):
    """The follower's jaws: the range of their angle, and their speed."""

    start: _Angle = _M.jaw_start
    """angle at the start, of a simulated follower [rad]"""
    closed: _Angle = _M.jaw_min
    """angle of the closed jaws; below 0 they press on each other [rad]"""
    open: _Angle = _M.jaw_max
    """angle of the open jaws [rad]"""
    rate: Annotated[Positive, Field(le=12.0)] = _M.jaw_rate
    """largest speed of the jaws [rad/s]"""


def check_times(grip: tuple[GripPoint, ...] | None) -> None:
    """Refuse a pinch program that is empty or whose times do not rise.

    Raises:
        ValueError: the message is "what | mend".
    """
    if grip is not None and not grip:
        raise ValueError("grip is empty | give at least one angle, or leave grip out")
    for before, after in zip(grip or (), (grip or ())[1:], strict=False):
        if after.t <= before.t:
            raise ValueError(f"grip: times must rise: {after.t:g} s follows {before.t:g} s | sort the angles by time")
