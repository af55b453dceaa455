"""What can go wrong before a run, told so that the reader can mend it: what, where, why, how to mend."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

__all__ = [
    "ArmError",
    "GuidanceError",
    "JournalError",
    "MeshError",
    "MissingExtraError",
    "OutputError",
    "PalpateError",
    "PalpateWarning",
    "PortError",
    "RecordError",
    "RecordingError",
    "RosMissingError",
    "SceneError",
    "SurfaceError",
    "SweepError",
    "refuse_to_overwrite",
    "spell",
]


def _tell(what: str, where: str, why: str, mend: str) -> str:
    first = f"{where}: {what}" if where else what
    lines = [first, *(f"  {label}: {text}" for label, text in (("why", why), ("mend", mend)) if text)]
    return "\n".join(lines)


class PalpateError(Exception):
    """The base of every error that a user can mend. The CLI prints it without a traceback and exits with 2.

    Args:
        what: the thing and its value, e.g. ``unknown key 'stifness'``.
        where: file, or file:line, or the name of the object; empty when there is no place to name.
        why: the cause.
        mend: what to do about it.
    """

    def __init__(self, what: str, *, where: str = "", why: str = "", mend: str = "") -> None:
        self.what, self.where, self.why, self.mend = what, str(where), why, mend
        super().__init__(_tell(what, self.where, why, mend))


class ArmError(PalpateError, ValueError):
    """An arm that does not exist, or a pose it cannot reach."""


class GuidanceError(PalpateError, ValueError):
    """A fixture, its geometry or its file that cannot be."""


class SceneError(PalpateError):
    """The scene file cannot be read, or asks for something impossible."""

    others: tuple[SceneError, ...] = ()  #: further mistakes in the same file

    def add_others(self, others: Sequence[SceneError]) -> None:
        """Tell further mistakes of the same file in the same message."""
        self.others = tuple(others)
        self.args = ("\n".join(str(e) for e in (self, *others)),)


class MeshError(PalpateError):
    """The mesh cannot be read or cannot be touched."""


class SurfaceError(PalpateError, ValueError):
    """A primitive, distance grid or implicit surface with impossible values, or its file cannot be read."""


class OutputError(PalpateError):
    """The output folder or file cannot be written."""


class RecordError(PalpateError):
    """The record cannot be read."""


class RecordingError(PalpateError):
    """A recording of an arm that nothing can be identified from, or a model file that does not fit."""


class SweepError(PalpateError):
    """Points of a sweep failed, or its workers cannot work."""


class JournalError(SweepError):
    """The journal belongs to another sweep, or is none."""


class PortError(PalpateError):
    """The viewer's port cannot be used."""


class MissingExtraError(PalpateError):
    """An optional part of Palpate is not installed.

    Args:
        feature: what the part is for, e.g. ``the viewer``.
        extra: name of the extra, e.g. ``viewer``.
    """

    def __init__(self, feature: str, extra: str) -> None:
        super().__init__(f"{feature} is not installed", mend=f"pip install 'palpate[{extra}]'")
        self.extra = extra


class PalpateWarning(UserWarning):
    """Something was mended or looks wrong, and the run goes on. Told once, in the words of the errors."""

    def __init__(self, what: str, *, where: str = "", why: str = "", mend: str = "") -> None:
        self.what, self.where, self.why, self.mend = what, str(where), why, mend
        super().__init__(_tell(what, self.where, why, mend))


class RosMissingError(PalpateError):
    """ROS 2, or what its part of Palpate is compiled with, is not here or does not fit."""


def spell(place: tuple[str | int, ...]) -> str:
    """The place of a value in a file, as messages write it: ``objects[0].mesh``."""
    text = ""
    for part in place:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text


def refuse_to_overwrite(path: Path, force: bool) -> None:
    """Refuse to write over a file that exists.

    Raises:
        OutputError: the file exists and `force` is not given.
    """
    if path.exists() and not force:
        raise OutputError("the file exists already", where=str(path), mend="give --force, or another name")
