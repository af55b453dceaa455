"""Errors that a user can correct: each message states what failed, where, why, and how to correct it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

__all__ = [
    "ArmError",
    "CloudError",
    "DeviceError",
    "FrameError",
    "GuidanceError",
    "InvalidSceneError",
    "JournalError",
    "MeshError",
    "MissingExtraError",
    "OutputError",
    "PalpateError",
    "PalpateWarning",
    "PlanningError",
    "PortError",
    "RecordError",
    "RecordingError",
    "RegistrationError",
    "RosMissingError",
    "SceneError",
    "SurfaceError",
    "SweepError",
    "ValueAtError",
    "format_place",
    "refuse_to_overwrite",
]


def _format_message(what: str, where: str, why: str, mend: str) -> str:
    first = f"{where}: {what}" if where else what
    lines = [first, *(f"  {label}: {text}" for label, text in (("why", why), ("mend", mend)) if text)]
    return "\n".join(lines)


class PalpateError(Exception):
    """Base class of every error that a user can correct. The CLI prints it without a traceback and exits with 2.

    Args:
        what: what failed, with the value, e.g. ``unknown key 'stifness'``.
        where: file, file:line, or name of the object; empty if unknown.
        why: the cause.
        mend: how to correct it.
    """

    def __init__(self, what: str, *, where: str = "", why: str = "", mend: str = "") -> None:
        self.what, self.where, self.why, self.mend = what, str(where), why, mend
        super().__init__(_format_message(what, self.where, why, mend))


class ArmError(PalpateError, ValueError):
    """The arm does not exist, or it cannot reach a pose."""


class CloudError(PalpateError, ValueError):
    """A point cloud has invalid values, its file cannot be read, or a stream of clouds cannot be used."""


class DeviceError(PalpateError, ValueError):
    """A device or its driver cannot be used, or a loop passed a value of the wrong shape."""


class FrameError(PalpateError, ValueError):
    """A frame, a pose between two frames, or a file with a pose is invalid."""


class GuidanceError(PalpateError, ValueError):
    """A fixture, its geometry or its file is invalid."""


class SceneError(PalpateError):
    """The scene file cannot be read, or its values are invalid."""

    others: tuple[SceneError, ...] = ()  #: further errors in the same file

    def add_others(self, others: Sequence[SceneError]) -> None:
        """Append further errors of the same file to the message."""
        self.others = tuple(others)
        self.args = ("\n".join(str(e) for e in (self, *others)),)


class InvalidSceneError(SceneError, ValueError):
    """Values given in Python are no scene. A `ValueError`, as pydantic's own error is."""


class MeshError(PalpateError):
    """The mesh cannot be read, or cannot be used for contact."""


class SurfaceError(PalpateError, ValueError):
    """A primitive, distance grid or implicit surface has invalid values, or its file cannot be read."""


class OutputError(PalpateError):
    """The output folder or file cannot be written."""


class RecordError(PalpateError):
    """The record cannot be read."""


class RecordingError(PalpateError):
    """Nothing can be identified from a recording, or a model file does not belong to the arm."""


class PlanningError(PalpateError, ValueError):
    """No motion can be planned: the start or the goal is in collision, or the plan does not belong to the scene."""


class RegistrationError(PalpateError, ValueError):
    """Measured points, clouds or poses cannot be registered: too few, degenerate, or in another unit or handedness."""


class StateError(PalpateError):
    """A request has no effect in the present state of a session."""


class SweepError(PalpateError):
    """Points of a sweep failed, or its workers cannot run."""


class JournalError(SweepError):
    """The journal belongs to another sweep, or the file is not a journal."""


class PortError(PalpateError):
    """The viewer's port cannot be used."""


class MissingExtraError(PalpateError):
    """An optional part of Palpate is not installed.

    Args:
        feature: name of the missing part, e.g. ``the viewer``.
        extra: name of the extra, e.g. ``viewer``.
    """

    def __init__(self, feature: str, extra: str) -> None:
        super().__init__(
            f"{feature} is not installed",
            mend=f"run make setup in your clone, or install the wheel with its extra: palpate[{extra}]",
        )
        self.extra = extra


class PalpateWarning(UserWarning):
    """A value was corrected or looks wrong, and the run continues. Issued once, in the format of the errors."""

    def __init__(self, what: str, *, where: str = "", why: str = "", mend: str = "") -> None:
        self.what, self.where, self.why, self.mend = what, str(where), why, mend
        super().__init__(_format_message(what, self.where, why, mend))


class RosMissingError(PalpateError):
    """ROS 2, or a tool needed to compile Palpate's ROS 2 node, is missing or has the wrong version."""


class ValueAtError(ValueError):
    """An invalid value inside the value that is checked, e.g. the name of one object of a list.

    Args:
        message: ``what | mend``.
        place: keys and indices from the checked value to the invalid one.
    """

    def __init__(self, message: str, *place: str | int) -> None:
        super().__init__(message)
        self.place = place


Place = tuple[str | int, ...]
"""Keys and indices of a value in a file."""


def format_place(place: Place) -> str:
    """Path of a value in a file, as messages print it: ``objects[0].mesh``."""
    text = ""
    for part in place:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text


def where_in(name: str, lines: dict[Place, int], place: Place) -> str:
    """``file:line`` of a place, or of the nearest enclosing place that the file contains."""
    line = line_of(lines, place)
    return f"{name}:{line}" if line else name


def line_of(lines: dict[Place, int], place: Place) -> int:
    """Line of a place, or of the nearest enclosing place that the file contains; 0 for none."""
    if place and place[:1] not in lines:
        place = (str(place[0]), *place[1:])  # a key such as 1: the lines are those of texts
    return next((lines[place[:end]] for end in range(len(place), 0, -1) if place[:end] in lines), 0)


def refuse_to_overwrite(path: Path, force: bool) -> None:
    """Check that a file may be written.

    Raises:
        OutputError: the file exists and `force` is false.
    """
    if path.exists() and not force:
        raise OutputError("the file exists already", where=str(path), mend="give --force, or another name")
