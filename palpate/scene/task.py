"""Section `task` of a scene: what the hand has to do, when it is done, and how it is scored."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated

from pydantic import Field, model_validator

from palpate.base.errors import ValueAtError
from palpate.base.values import NotNegative, Positive, Section, Vector


class PlaceSection(Section):
    """Bodies have to stand at places, in any order and each at any free one."""

    bodies: Annotated[tuple[str, ...], Field(min_length=1, max_length=48)]
    """names of the bodies"""
    targets: Annotated[tuple[Vector, ...], Field(min_length=1, max_length=48)]
    """where the bodies' origins have to rest, in W [m]"""
    back: bool = False
    """then the bodies return to their start"""
    tolerance: Positive = 0.005
    """largest distance from the place, across and along z of W [m]"""
    lift: Positive = 0.03
    """height above the targets at which a simulated operator carries the bodies [m]"""
    grasp: Annotated[tuple[Vector, ...], Field(min_length=1)] = ((0.0, 0.0, 0.0),)
    """points in the body's frame at which a simulated operator grasps; with several pairs, one for each [m]"""
    handed_over: bool = False
    """the second hand puts them down, and on the way back the first"""


class FindSection(Section):
    """A hidden lump has to be found: the tool rests on the surface above it while the pedal coag is pressed."""

    object: str
    """name of the object"""
    region: str
    """name of the region that is hidden in it"""
    within: Positive = 0.005
    """largest distance of the mark from the lump, across z of W [m]"""
    area: tuple[Vector, Vector]
    """corners of the area in which the lump is hidden by the seed, in the object's frame [m]"""
    force: Positive = 1.0
    """force with which a simulated operator presses [N]"""


class FollowSection(Section):
    """A ring has to be led along a wire to its end."""

    body: str
    """name of the ring"""
    wire: Annotated[tuple[Vector, ...], Field(min_length=2, max_length=200)]
    """points of the wire's axis, in W [m]"""
    grasp: Vector = (0.0, 0.0, 0.0)
    """point in the ring's frame at which a simulated operator grasps [m]"""
    tolerance: Positive = 0.006
    """largest distance of the ring's middle from the wire; more is off the wire [m]"""


class PassSection(Section):
    """The tip of a needle has to pass gates in their order."""

    body: str
    """name of the needle"""
    tip: Vector
    """its tip in its frame [m]"""
    gates: Annotated[tuple[Vector, ...], Field(min_length=1, max_length=24)]
    """middles of the gates, in W [m]"""
    along: Vector = (1.0, 0.0, 0.0)
    """direction in which the gates are passed, in W [-]"""
    tolerance: Positive = 0.0025
    """largest distance of the tip from the middle where it passes a gate, in each direction across [m]"""
    depth: NotNegative = 0.001
    """how far the tip must come behind the middle of a gate [m]"""
    grasp: Vector = (0.0, 0.0, 0.0)
    """point in the needle's frame at which a simulated operator grasps [m]"""


class TaskSection(Section):
    """A task: one of `place`, `find`, `follow` and `pass`. A person does it, or else a simulated operator."""

    place: PlaceSection | None = None
    """bodies have to stand at places"""
    find: FindSection | None = None
    """a hidden lump has to be found"""
    follow: FollowSection | None = None
    """a ring has to be led along a wire"""
    gates: PassSection | None = None
    """a needle has to pass gates"""
    limit: Annotated[Positive, Field(le=3600.0)] = 300.0
    """time from which the score is counted, and after which the task has failed [s]"""
    operator: bool = True
    """a simulated operator does the task while nobody moves the hand"""

    @model_validator(mode="after")
    def _one_kind(self) -> TaskSection:
        kinds = [name for name in ("place", "find", "follow", "gates") if getattr(self, name) is not None]
        if len(kinds) != 1:
            given = " and ".join(kinds) or "none"
            raise ValueError(f"a task is one of place, find, follow, gates; given: {given} | keep one")
        if self.place is not None and len(self.place.targets) < len(self.place.bodies):
            what = f"place: {len(self.place.bodies)} bodies and {len(self.place.targets)} targets"
            raise ValueError(f"{what} | give each body a target")
        if self.place is not None and len(set(self.place.bodies)) < len(self.place.bodies):
            raise ValueError("place: a body is named twice | name each body once")
        if self.gates is not None and not any(self.gates.along):
            raise ValueError("gates: along has no direction | give a vector such as [1, 0, 0]")
        return self

    def check(self, bodies: Mapping[str, bool], objects: Mapping[str, Sequence[str]]) -> None:
        """Refuse names that the scene does not have, and bodies that do not move freely (`bodies`: name to freedom;
        `objects`: name to the names of its regions).

        Raises:
            ValueAtError: the message names what is missing.
        """
        needed: list[tuple[str, tuple[str | int, ...]]] = []
        if self.place is not None:
            needed = [(name, ("place", "bodies", i)) for i, name in enumerate(self.place.bodies)]
        for kind in ("follow", "gates"):
            section = getattr(self, kind)
            if section is not None:
                needed.append((section.body, (kind, "body")))
        for name, place in needed:
            if not bodies.get(name, False):
                free = ", ".join(one for one, moves in bodies.items() if moves) or "none"
                what = f"{name!r} is not a body that moves freely | name one of: {free}"
                raise ValueAtError(what, "task", *place)
        if self.find is not None and self.find.object not in objects:
            what = f"there is no object {self.find.object!r} | name one of {', '.join(objects)}"
            raise ValueAtError(what, "task", "find", "object")
        if self.find is not None and self.find.region not in (regions := objects[self.find.object]):
            what = f"{self.find.object!r} has no region {self.find.region!r}"
            mend = f"name one of {', '.join(regions)}" if regions else "add it to regions of the object"
            raise ValueAtError(f"{what} | {mend}", "task", "find", "region")
