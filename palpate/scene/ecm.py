"""The section `ecm` of a scene: the endoscope arm and its stereo endoscope."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from palpate.base.values import Number, Pose, Positive, Section


class EndoscopeSection(Section):
    """A stereo endoscope."""

    tilt_deg: Literal[-30, 0, 30] = 0
    """angle by which it looks up from its axis; 0: straight, 30: 30 degrees up, -30: down [deg]"""
    baseline: Annotated[Positive, Field(le=0.02)] = 0.005
    """distance between both eyes [m]"""
    width_deg: Annotated[Positive, Field(ge=10.0, le=120.0)] = 70.0
    """horizontal angle of view [deg]"""


class EcmSection(Section):
    """The endoscope arm (ECM): its base, its joints or the pose of its camera, and the endoscope."""

    base: Pose | None = None
    """X_WB: pose of its base, which is its remote centre; when left out, the camera sees the start of the path"""
    joints: tuple[Number, Number, Number, Number] | None = None
    """yaw, pitch, insertion and roll at the start; the arm's home when left out [rad, m]"""
    camera: Pose | None = None
    """instead of joints: X_WC, pose of the camera at the start, x right and y down in its picture; needs base"""
    endoscope: EndoscopeSection = EndoscopeSection()
    """the endoscope"""
    follow_picture: bool = True
    """true: motions of the hand follow the picture, also after the camera has moved; an arms.leader.base of the scene
    keeps its orientation at the start"""

    @model_validator(mode="after")
    def _check(self) -> EcmSection:
        if self.joints is not None and self.camera is not None:
            raise ValueError("joints and camera are given | keep one of them")
        if self.camera is not None and self.base is None:
            raise ValueError("camera needs base, through which the endoscope goes | give base: {xyz: [..]}")
        return self
