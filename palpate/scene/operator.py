"""The simulated operator in a scene file: the intended path, and the impedance of the hand."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, Field, ValidationInfo, WithJsonSchema, model_validator

from palpate import _core
from palpate.arm import hands
from palpate.base.errors import RecordingError
from palpate.base.values import NotNegative, Number, Positive, Section, Vector
from palpate.scene.jaws import GripPoint, check_times

_C = _core.SimulationOptions()


def _known(name: str) -> str:
    if name in hands.PRESETS or name.endswith((".yaml", ".yml")):
        return name
    raise ValueError(f"there is no hand {name!r} | use one of {', '.join(hands.PRESETS)}; or a file, my_hand.yaml")


#: Name of a hand of `palpate.arm.hands`, or the path of a hand file relative to the scene file.
HandName = Annotated[
    str,
    AfterValidator(_known),
    WithJsonSchema({"anyOf": [{"enum": list(hands.PRESETS)}, {"type": "string", "pattern": r"\.ya?ml$"}]}),
]


def load_hand(name: str, folder: Path) -> hands.Hand:
    """The hand with a preset name, or from a file relative to `folder`.

    Raises:
        ValueError: the hand is unknown or its file is invalid; the message is "what | mend".
    """
    if name in hands.PRESETS:
        return hands.PRESETS[name]
    _known(name)
    try:
        return hands.load(folder / Path(name).expanduser())
    except RecordingError as error:
        raise ValueError(f"{error.what}: {error.where}, {error.why} | {error.mend or 'check the path'}") from None


class WayPoint(Section):
    """Intended position of the tool at a time."""

    t: NotNegative
    """time from the start [s]"""
    xyz: Vector
    """intended position of the tool tip in W [m]"""


Phase = Annotated[Positive, Field(ge=0.01, le=600.0)]
Near = Annotated[Number, Field(ge=-1e3, le=1e3)]


class PalpateSection(Section):
    """Automatic path over a surface: approach, press, slide, leave; each repetition slides in another direction."""

    object: str = ""
    """name of the object; the first object when left out"""
    at: tuple[Near, Near, Near] | None = None
    """position in W, replaced by the nearest surface point; the top of the object when left out [m]"""
    direction: Vector = (1.0, 0.0, 0.0)
    """first direction of the slide, in W; each repetition turns it by 60 degrees about the surface normal [-]"""
    force: Positive = 1.5
    """intended force on the tool [N]"""
    hover: Annotated[Positive, Field(le=1.0)] = 0.02
    """height of the start above the surface [m]"""
    length: Annotated[Positive, Field(le=1.0)] = 0.03
    """length of the slide [m]"""
    approach: Phase = 1.5
    """duration of the approach [s]"""
    press: Phase = 1.0
    """duration of the press [s]"""
    slide: Phase = 5.5
    """duration of the slide, there and back [s]"""
    leave: Phase = 2.0
    """duration of the departure [s]"""


class OperatorSection(Section):
    """The simulated hand: its intended path and its impedance."""

    palpate: PalpateSection = PalpateSection()
    """automatic path over an object"""
    path: tuple[WayPoint, ...] | None = None
    """instead of palpate: way points of the tool. The hand passes them without a stop; it stops at both ends, at
    repeated way points, and where the path turns by 90 degrees or more"""
    grip: tuple[GripPoint, ...] | None = None
    """pinch angle over time, from one to the next by minimum jerk; half open when left out"""
    hand: HandName = "normal"
    """grip of the handle: relaxed, light, normal, firm, rigid; or a file of `palpate calibrate hand`, relative to the
    scene file"""
    mass: Positive = _C.hand.mass
    """mass that moves with the handle; from hand when left out [kg]"""
    damping: NotNegative = _C.hand.damping
    """damping between the hand and its intended path; from hand when left out [N s/m]"""
    stiffness: Positive = _C.hand.stiffness
    """stiffness between the hand and its intended path; from hand when left out [N/m]"""
    grip_force_max: Positive = _C.hand.grip_force_max
    """force above which the hand slips [N]"""
    tremor: Annotated[NotNegative, Field(lt=0.01)] = _C.tremor
    """tremor at 8 to 12 Hz, rms per axis [m]"""

    @model_validator(mode="before")
    @classmethod
    def _fill_from_hand(cls, data: Any, info: ValidationInfo) -> Any:
        """Fill in values of the hand for keys that the file leaves out."""
        if not isinstance(data, dict) or not isinstance(data.get("hand"), str):
            return data
        keys = [key for key in ("mass", "damping", "stiffness") if key not in data]
        hand = load_hand(data["hand"], (info.context or {}).get("folder", Path())) if keys else None
        return {**{key: getattr(hand, key) for key in keys}, **data}

    @model_validator(mode="after")
    def _check_path(self) -> OperatorSection:
        check_times(self.grip)
        for before, after in zip(self.path or (), (self.path or ())[1:], strict=False):
            if after.t <= before.t:
                raise ValueError(f"path: times must rise: {after.t:g} s follows {before.t:g} s | sort the way points")
        if self.path is not None and len(self.path) == 0:
            raise ValueError("path is empty | give at least one way point, or leave path out")
        if self.path is not None and self.palpate != PalpateSection():
            raise ValueError("path and palpate are given: the hand follows one of them | keep one of them")
        return self
