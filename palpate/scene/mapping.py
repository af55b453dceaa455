"""The section `mapping` of a scene: how motion of the hand becomes motion of the tool, and force becomes force."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from palpate import _core
from palpate.base.errors import SceneError
from palpate.base.values import NotNegative, Number, Positive, Section, Vector

_C = _core.MappingOptions()
_R = _C.recentring
LAWS = ("indexed", "scaled", "rate", "drift")
"""Laws of the mapping; those after the first need the workspace of a device."""


class MappingSection(Section):
    """Mapping of motion from hand to tool, and of force from tool to hand; a word alone is the law."""

    law: Literal["indexed", "scaled", "rate", "drift"] = "indexed"
    """indexed: the tool follows the hand by scale, and the clutch moves the hand alone; the others are for devices with
    a small workspace: scaled: as indexed, with a scale that covers all objects; rate: near the rim of the workspace the
    tool continues outwards; drift: the tool drifts while the hand moves, so that the hand comes back to the centre"""
    scale: Positive = _C.scale
    """tool motion per hand motion; the felt stiffness is force_scale * scale * stiffness [-]"""
    force_scale: Positive = _C.force_scale
    """force on the hand per force on the tool [-]"""
    align_rate: NotNegative = _C.align_rate
    """rate at which the tool turns to the orientation of the handle after engaging, while no force acts on it; 0 keeps
    the offset [rad/s]"""
    align_tolerance: Annotated[NotNegative, Field(le=3.2)] = _C.align_tolerance
    """orientation error between handle and tool up to which the tool begins to follow; 0: it begins at any [rad]"""
    ratchet: bool = _C.ratchet
    """true: when the tool begins to follow, the jaw does not open before the pinch has closed to its angle"""
    workspace: tuple[Positive, Positive, Positive] | None = None
    """lengths of the device's workspace along the axes of its base; those of the driver when left out [m]"""
    centre: Vector | None = None
    """centre of the workspace in the device's base; with the lengths of the driver its origin, otherwise the first
    position of the handle when left out [m]"""
    rim: Annotated[Number, Field(ge=0.0, lt=1.0)] = _R.rim
    """rate: distance from the centre at which the tool starts to continue; 1: the edge of the workspace [-]"""
    rim_speed: Annotated[Positive, Field(le=1.0)] = _R.rim_speed
    """rate: speed of the tool at the edge of the workspace [m/s]"""
    drift: Annotated[Positive, Field(lt=1.0)] = _R.drift
    """drift: speed of the drift at the edge of the workspace over the speed that the hand gives the tool [-]"""

    @model_validator(mode="before")
    @classmethod
    def _word_is_law(cls, value: Any) -> Any:
        return {"law": value} if isinstance(value, str) else value

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """The schema of the section, or of the law alone."""
        whole = handler.resolve_ref_schema(handler(core))
        return {**whole, "type": ["object", "string"], "anyOf": [{"type": "object"}, {"enum": list(LAWS)}]}

    def with_device(self, workspace: Vector | None) -> MappingSection:
        """The section with the workspace of a driver [m], unless the scene names its own."""
        if self.workspace is not None or workspace is None:
            return self
        return self.model_copy(update={"workspace": workspace, "centre": self.centre or (0.0, 0.0, 0.0)})

    def covering(self, low: Any, high: Any, R_WL: Any) -> MappingSection:
        """The section with the scale for which the workspace covers a box in W; R_WL (3, 3): axes of the device.

        Args:
            low, high: corners (3,) of the box in W [m].
            R_WL: orientation of the device's base in W.
        """
        extents = np.abs(np.asarray(R_WL)).T @ (np.asarray(high) - np.asarray(low))
        return self.model_copy(update={"scale": float((extents / np.array(self.workspace)).max())})

    def fill(self, o: _core.MappingOptions) -> _core.MappingOptions:
        """Write the section into the options of the core; returns them."""
        o.scale, o.force_scale, o.align_rate = self.scale, self.force_scale, self.align_rate
        o.align_tolerance, o.ratchet = self.align_tolerance, self.ratchet
        if self.law in ("rate", "drift") and self.workspace is not None:
            r = o.recentring
            r.law = getattr(_core.MappingLaw, self.law)
            r.workspace, r.rim, r.rim_speed, r.drift = np.array(self.workspace), self.rim, self.rim_speed, self.drift
            r.centre = None if self.centre is None else np.array(self.centre)
            o.recentring = r
        return o

    def require_device(self, driven: bool, where: str) -> None:
        """Refuse a law that needs the workspace of a device, without one.

        Args:
            driven: the scene has a device, or a program that calls `palpate.Haptics`, in place of the simulated arm.
            where: file and line for the message.

        Raises:
            SceneError: there is no device.
        """
        if self.law != "indexed" and not driven:
            mend = "use indexed, or add arms: {leader: {driver: ...}} (loop for a program that calls palpate.Haptics)"
            what = f"mapping law {self.law} is for a device, and the leader of this scene is a simulated arm"
            raise SceneError(what, where=where, mend=mend)
