"""Motion plans in a scene file: clearance, speed, named joint positions, other instruments, grasped objects."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, field_validator

from palpate.base.values import NotNegative, Number, Pose, Positive, Section

Joints = Annotated[tuple[Number, ...], Field(min_length=1, max_length=12)]


class InstrumentSection(Section):
    """Another instrument or endoscope in the scene, which stays at rest."""

    name: str
    """name in plans and messages, e.g. PSM2 or ECM"""
    model: str = "psm_lnd"
    """arm model: a name (psm_lnd, ecm, six_axis), or the path of a model file relative to the scene file"""
    base: Pose = Pose()
    """X_WB: pose of its base; of its remote centre of motion for a PSM and an ECM"""
    joints: Joints | None = None
    """its joint positions; home when left out [rad, m]"""
    jaw: Number = 0.0
    """opening angle of its jaws [rad]"""


class AttachedSection(Section):
    """An object of the scene that the instrument holds: it moves with the instrument."""

    object: str
    """name of the object"""
    link: str = "tool"
    """link that carries it"""


class PlanningSection(Section):
    """Motion plans of the follower (docs/planning.md)."""

    arm: str = "PSM1"
    """name of the follower in plans"""
    clearance: NotNegative = 3e-3
    """smallest distance of the whole instrument from all objects [m]"""
    speed: Annotated[Positive, Field(le=1.0)] = 0.2
    """fraction of the joints' speed limits that plans use [-]"""
    jaw: Number | tuple[Number, Number] | None = None
    """angle of the jaws during the motion, or its range [low, high]; arms.follower.jaw.start when left out [rad]"""
    states: dict[str, Joints] = Field(default_factory=dict)
    """named joint positions, for starts and goals; home and current exist always [rad, m]"""
    instruments: Annotated[tuple[InstrumentSection, ...], Field(max_length=8)] = ()
    """other instruments, which plans avoid"""
    attached: Annotated[tuple[AttachedSection, ...], Field(max_length=8)] = ()
    """objects that the instrument holds"""
    allowed: Annotated[tuple[tuple[str, str], ...], Field(max_length=256)] = ()
    """pairs that may touch: a link of the instrument, or its name, and an object, another instrument or another link"""

    @field_validator("jaw")
    @classmethod
    def _rising(cls, jaw: float | tuple[float, float] | None) -> float | tuple[float, float] | None:
        if isinstance(jaw, tuple) and not jaw[0] <= jaw[1]:
            raise ValueError(f"jaw: [{jaw[0]:g}, {jaw[1]:g}] falls | write the smaller angle first")
        return jaw
