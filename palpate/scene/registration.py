"""Section of the scene file for the registration of an organ: targets, accuracy, sensors, and the simulated truth."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from palpate.base.values import NotNegative, Pose, Positive, Section, Vector


class CameraSection(Section):
    """A depth camera that sees a part of the organ: simulated, or a file with its points."""

    frame: str
    """frame of the scene's frames: the camera's optical frame, z forward, x right, y down"""
    cloud: str | None = None
    """points of the organ in that frame (.csv, .npy, .pcd), relative to the scene file; simulated when left out [m]"""
    cloud_after: str | None = None
    """the same after the last touch: tells whether the organ moved meanwhile [m]"""
    noise_mm: Positive = 1.0
    """simulated: standard deviation along the ray [mm]"""
    outliers: Annotated[NotNegative, Field(le=0.3)] = 0.02
    """simulated: share of points at a wrong range [-]"""

    @property
    def looks_again(self) -> bool:
        """True if the camera also sees the organ after the last touch."""
        return self.cloud is None or self.cloud_after is not None


class PointerSection(Section):
    """A tracked tool whose tip touches the organ; without it, the arm's tool is the pointer."""

    frame: str
    """tracked frame of the scene's frames: the tool's marker"""
    tip: Vector = (0.0, 0.0, 0.0)
    """tip in that frame, as palpate register pivot finds it [m]"""
    radius: NotNegative = 0.0
    """radius of the sphere on the tip [m]"""


class TruthSection(Section):
    """True pose of the organ in a simulated session, from which its errors are reported."""

    pose: Pose
    """X_world_frame"""


class RegistrationSection(Section):
    """Registration of a frame by palpate register session (docs/registration-session.md)."""

    frame: str
    """frame to register: child of an entry of frames with a file, which the session writes"""
    object: str = ""
    """name of the organ, an object in that frame; the first object when left out"""
    targets: Annotated[dict[str, Vector], Field(min_length=1, max_length=32)]
    """places in that frame at which the error counts, by name [m]"""
    accuracy: Positive = 1e-3
    """error that no target may exceed with a probability of 95 % [m]"""
    motion: Positive | None = None
    """touch on until a motion of the organ by this much, half-way through the touches, would be told in nine of ten
    sessions; no such demand when left out [m]"""
    landmarks: dict[str, Vector] = Field(default_factory=dict)
    """places on the surface that an operator finds and touches first, where no camera sees the organ [m]"""
    landmark_mm: Positive = 2.0
    """standard deviation with which a landmark is found, on each axis [mm]"""
    touch_mm: Positive = 0.3
    """standard deviation of a touching tip on each axis, independent from touch to touch [mm]"""
    tip_mm: Positive = 0.2
    """standard deviation of the tip's calibrated offset on each axis, common to all touches [mm]"""
    touches: Annotated[int, Field(strict=True, ge=6, le=200)] = 40
    """largest number of touches [-]"""
    camera: CameraSection | None = None
    """camera that gives the first pose"""
    pointer: PointerSection | None = None
    """tracked pointer; the arm's tool when left out"""
    simulated: TruthSection | None = None
    """truth of a simulated session"""

    @model_validator(mode="after")
    def _check(self) -> RegistrationSection:
        if self.camera is None and len(self.landmarks) < 4:
            raise ValueError(
                f"there is no camera and {len(self.landmarks)} landmarks, so that no first pose can be found | "
                "give camera, or four or more landmarks that do not lie in one plane"
            )
        return self
