"""The simulated operator in a scene file: what the hand wants, and how it holds the handle."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, Field, ValidationInfo, WithJsonSchema, model_validator

from palpate import _core, hands
from palpate.errors import RecordingError
from palpate.values import NotNegative, Number, Positive, Section, Vector

_C = _core.SimulationOptions()


def _known(name: str) -> str:
    if name in hands.PRESETS or name.endswith((".yaml", ".yml")):
        return name
    raise ValueError(f"there is no hand {name!r} | hands: {', '.join(hands.PRESETS)}; or a file, my_hand.yaml")


#: A hand of `palpate.hands`, or the path of a file, relative to the scene file.
HandName = Annotated[
    str,
    AfterValidator(_known),
    WithJsonSchema({"anyOf": [{"enum": list(hands.PRESETS)}, {"type": "string", "pattern": r"\.ya?ml$"}]}),
]


def hand_of(name: str, folder: Path) -> hands.Hand:
    """By its name, or from its file.

    Raises:
        ValueError: in the words of a scene file's mistakes.
    """
    if name in hands.PRESETS:
        return hands.PRESETS[name]
    _known(name)
    try:
        return hands.load(folder / Path(name).expanduser())
    except RecordingError as error:
        raise ValueError(f"{error.what}: {error.where}, {error.why} | {error.mend or 'check the path'}") from None


class WayPoint(Section):
    """Where the hand wants the tool at a time."""

    t: NotNegative
    """time from the start [s]"""
    xyz: Vector
    """intended position of the tool tip in W [m]"""


Phase = Annotated[Positive, Field(ge=0.01, le=600.0)]
Near = Annotated[Number, Field(ge=-1e3, le=1e3)]


class PalpateSection(Section):
    """A path made from the surface: approach, press, slide, leave, again and again, each time in another direction."""

    object: str = ""
    """name of the object; the first one when left out"""
    at: tuple[Near, Near, Near] | None = None
    """about where, in W: the nearest surface point is taken; the top of the object when left out [m]"""
    direction: Vector = (1.0, 0.0, 0.0)
    """first direction of the slide, in W; turned about the surface normal by 60 degrees each time [-]"""
    force: Positive = 1.5
    """intended force on the tool [N]"""
    hover: Annotated[Positive, Field(le=1.0)] = 0.02
    """height of the start above the surface [m]"""
    length: Annotated[Positive, Field(le=1.0)] = 0.03
    """of the slide [m]"""
    approach: Phase = 1.5
    """duration [s]"""
    press: Phase = 1.0
    """duration [s]"""
    slide: Phase = 5.5
    """duration, there and back [s]"""
    leave: Phase = 2.0
    """duration [s]"""


class OperatorSection(Section):
    """The simulated hand: what it wants, and how it yields."""

    palpate: PalpateSection = PalpateSection()
    """automatic path over an object"""
    path: tuple[WayPoint, ...] | None = None
    """instead: way points of the tool, passed without a stop; the hand rests at both ends, where one is repeated,
    and where the path turns by a right angle or more"""
    hand: HandName = "normal"
    """how it holds the handle: relaxed, light, normal, firm, rigid; or a file of `palpate calibrate hand`, relative to
    the scene file"""
    mass: Positive = _C.hand.mass
    """moves with the handle; as hand says when left out [kg]"""
    damping: NotNegative = _C.hand.damping
    """between the hand and its intended path; as hand says when left out [N s/m]"""
    stiffness: Positive = _C.hand.stiffness
    """between the hand and its intended path; as hand says when left out [N/m]"""
    grip_force_max: Positive = _C.hand.grip_force_max
    """the hand slips above it [N]"""
    tremor: Annotated[NotNegative, Field(lt=0.01)] = _C.tremor
    """8-12 Hz trembling, rms per axis [m]"""

    @model_validator(mode="before")
    @classmethod
    def _held(cls, data: Any, info: ValidationInfo) -> Any:
        """What the hand says, below what the file says itself."""
        if not isinstance(data, dict) or not isinstance(data.get("hand"), str):
            return data
        keys = [key for key in ("mass", "damping", "stiffness") if key not in data]
        hand = hand_of(data["hand"], (info.context or {}).get("folder", Path())) if keys else None
        return {**{key: getattr(hand, key) for key in keys}, **data}

    @model_validator(mode="after")
    def _rising(self) -> OperatorSection:
        for before, after in zip(self.path or (), (self.path or ())[1:], strict=False):
            if after.t <= before.t:
                raise ValueError(f"path: times must rise: {after.t:g} s follows {before.t:g} s | sort the way points")
        if self.path is not None and len(self.path) == 0:
            raise ValueError("path is empty | give at least one way point, or leave path out")
        return self
