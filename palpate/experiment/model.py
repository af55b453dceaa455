"""The experiment file: what is compared, by whom, in which order, and what counts as the end of a trial."""

from __future__ import annotations

import difflib
import os
import re
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, PrivateAttr, ValidationError, field_validator, model_validator

from palpate.base.errors import Place, SceneError, where_in
from palpate.base.values import NotNegative, Number, Positive, Section, Vector
from palpate.base.values.wording import explain
from palpate.scene import text
from palpate.scene.guidance.lists import FixtureList

Count = Annotated[int, Field(strict=True, ge=0, le=1000)]
Score = Annotated[Number, Field(ge=0.0, le=100.0)]
Gain = Annotated[NotNegative, Field(le=10.0)]
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+-]{0,39}")


def _name(value: str) -> str:
    if not _NAME.fullmatch(value):
        what = f"{value!r} is no name: at most 40 letters, digits and _ . + - only, a letter or digit first"
        raise ValueError(f"{what} | e.g. P01 or felt_late: names are folders and columns")
    return value


Name = Annotated[str, AfterValidator(_name)]

MEASURES = {
    "time_s": ("time", "s"),
    "force_error_N": ("mean error of the force", "N"),
    "path_error_m": ("rms distance from the path", "m"),
    "mean_force_N": ("mean force in contact", "N"),
    "peak_50ms_N": ("largest mean force over 50 ms", "N"),
    "above_threshold_s": ("time above the needed force", "s"),
    "impulse_Ns": ("impulse", "N s"),
    "force_per_path_N_per_m": ("force per path", "N/m"),
    "force_sensitivity": ("force sensitivity, 0 to 100", ""),
    "path_tool_m": ("path of the tool", "m"),
    "path_hand_m": ("path of the hand", "m"),
    "sparc": ("spectral arc length", ""),
    "log_dimensionless_jerk": ("log dimensionless jerk", ""),
    "clutches": ("clutch presses", ""),
    "touches": ("touches", ""),
    "margin_entries": ("entries into margins", ""),
    "drops": ("drops", ""),
    "success": ("share of successful trials", ""),
}
"""Measures of a trial, all of `palpate.metrics` but the last: name in words, and unit."""


class CuesSection(Section):
    """Force that is shown instead of, or beside, the felt one: the gain of each cue, 0 without it."""

    displaced: Gain = 0.0
    """the drawn tool stays above its true place; 1: on the surface [-]"""
    dimple: Gain = 0.0
    """depth of the drawn dent over the true depth; 0: the dent is drawn as in every condition, 1 to 1 [-]"""
    colour: Gain = 0.0
    """halo that grows and reddens with the force; 1: full at the force cap [-]"""
    bar: Gain = 0.0
    """bar beside the picture; 1: full at the force cap [-]"""
    tone: Gain = 0.0
    """tone that rises by an octave at the force cap, for 1 [-]"""

    @property
    def any(self) -> bool:
        """True if a cue is on."""
        return any(getattr(self, name) > 0.0 for name in type(self).model_fields)


class ConditionSection(Section):
    """What one condition changes in the scene of a task."""

    words: str = ""
    """description for the report"""
    scene: str | None = None
    """scene file, or shipped scene, instead of that of the task"""
    felt: bool = True
    """false: the contact force is not rendered on the hand"""
    cues: CuesSection = CuesSection()
    """visual and audible force cues"""
    guidance: Literal["path", "none"] | FixtureList | None = None
    """virtual fixtures: a list as in a scene; path: one that pulls to the task's path; none: without those of the
    scene; left out: those of the scene"""
    delay: Annotated[NotNegative, Field(le=1.0)] = 0.0
    """delay of the felt force [s]"""
    network: Annotated[str, Field(min_length=1)] | None = None
    """network between the hand and a simulated instrument, by name or as a measured trace (docs/network.md), whose far
    tool is judged"""
    changes: dict[str, Any] = Field(default_factory=dict)
    """any values of the scene, by their path, e.g. mapping.scale: 0.3"""

    @model_validator(mode="after")
    def _check_felt(self) -> ConditionSection:
        if not self.felt and self.delay > 0.0:
            raise ValueError("delay has no effect with felt: false | leave one of them out")
        if not self.felt and "mapping.force_scale" in self.changes:
            raise ValueError("changes: mapping.force_scale contradicts felt: false | leave one of them out")
        if self.network is not None and self.delay > 0.0:
            raise ValueError("a network has its own delay | leave delay or network out")
        return self


class TaskSection(Section):
    """Move the tool along a path, on a surface with a force or in free space; done after dwelling at its end."""

    words: str = ""
    """instruction that a participant reads"""
    scene: str = "palpation"
    """scene file, relative to the experiment file, or shipped scene"""
    changes: dict[str, Any] = Field(default_factory=dict)
    """values of the scene, by their path"""
    path: Annotated[tuple[Vector, ...], Field(min_length=1, max_length=200)]
    """way points in W, reached in this order [m]"""
    object: str | None = None
    """object on whose surface the way points are put; the first one when left out and a force is given"""
    force: Positive | None = None
    """force to hold on the surface; left out: the task is a motion in free space [N]"""
    within: Annotated[Positive, Field(lt=1.0)] = 0.3
    """error of the force that counts as held, over the force [-]"""
    near: Positive = 0.004
    """distance from a way point that counts as reached, along the surface where a force is held [m]"""
    dwell: NotNegative = 0.3
    """time at the last way point, with the force where there is one, without a break [s]"""
    time_limit: Annotated[Positive, Field(le=600.0)] = 10.0
    """time after which the trial has failed [s]"""
    harm: Positive = 3.0
    """force above which tissue is harmed, for the score of force sensitivity [N]"""
    fail_above: Positive | None = None
    """force at which the trial has failed at once; left out: at none [N]"""
    start: Positive = 0.006
    """height of the start above the first way point, or distance from it for a single one [m]"""

    @model_validator(mode="after")
    def _check_possible(self) -> TaskSection:
        if self.dwell >= self.time_limit:
            raise ValueError(
                f"nobody can dwell {self.dwell:g} s within {self.time_limit:g} s | a dwell below the time_limit"
            )
        if self.force is not None and self.fail_above is not None and self.fail_above <= self.force:
            what = f"a force of {self.force:g} N fails above {self.fail_above:g} N"
            raise ValueError(f"{what} | a larger fail_above, or leave it out")
        return self

    @property
    def need(self) -> float:
        """Force that the task needs [N]."""
        return 1.0 if self.force is None else self.force


class BreaksSection(Section):
    """Breaks."""

    every: Count = 0
    """trials between two breaks; 0: none"""
    seconds: NotNegative = 60.0
    """shortest length of a break of a person [s]"""


_COLUMNS = ("participant", "condition", "task", "tlx")  # of the table of answers


class QuestionSection(Section):
    """A statement to agree with, or a scale."""

    name: Name
    """column in the data"""
    words: Annotated[str, Field(min_length=1, max_length=300)]
    """what is asked"""
    low: str = "strongly disagree"
    """words at the lower end"""
    high: str = "strongly agree"
    """words at the upper end"""
    steps: Annotated[int, Field(strict=True, ge=2, le=101)] = 7
    """number of answers, 1 to this"""


class QuestionnairesSection(Section):
    """What is asked after the last trial of each condition, and at the end."""

    tlx: bool = False
    """raw NASA-TLX after each condition: six scales from 0 to 100"""
    likert: tuple[QuestionSection, ...] = ()
    """own items after each condition"""
    preference: bool = False
    """at the end: which of the conditions, named by their order, was preferred"""

    @field_validator("likert")
    @classmethod
    def _columns(cls, value: tuple[QuestionSection, ...]) -> tuple[QuestionSection, ...]:
        names = [one.name for one in value]
        for name in names:
            if names.count(name) > 1:
                raise ValueError(f"item {name} is asked twice | rename one of them")
            if name in _COLUMNS or name.startswith("tlx_"):
                raise ValueError(f"an item cannot be named {name}, since another column is | rename it")
        return value


class ExperimentFile(Section):
    """An experiment. Values are in SI units."""

    title: Annotated[str, Field(min_length=1, max_length=120)]
    """what is asked"""
    seed: Annotated[int, Field(strict=True, ge=0, lt=2**63)] = 1
    """seed of the order and of all trials"""
    participants: Annotated[int, Field(strict=True, ge=1, le=1000)] | tuple[str, ...] = 12
    """pseudonyms; a number n stands for P01 to Pn"""
    conditions: Annotated[dict[Name, ConditionSection], Field(min_length=1, max_length=26)]
    """by name; the first one is the reference of all comparisons"""
    tasks: Annotated[dict[Name, TaskSection], Field(min_length=1, max_length=26)]
    """by name"""
    order: Literal["latin-square", "seeded"] = "latin-square"
    """order of the conditions: balanced for first-order carry-over (Williams), or drawn for each participant"""
    familiarisation: Count = 1
    """trials of each task before those that count, in the first condition of the participant"""
    repetitions: Annotated[int, Field(strict=True, ge=1, le=1000)] = 2
    """trials of each task in each condition"""
    breaks: BreaksSection = BreaksSection()
    """breaks between trials"""
    questionnaires: QuestionnairesSection = QuestionnairesSection()
    """questions after the trials"""
    measures: Annotated[tuple[str, ...], Field(min_length=1)] = ("force_error_N", "peak_50ms_N", "time_s")
    """what is compared, declared beforehand; the first one is the primary measure"""

    _file: str = PrivateAttr(default="")
    _lines: dict[Place, int] = PrivateAttr(default_factory=dict)

    @field_validator("participants")
    @classmethod
    def _once(cls, value: tuple[str, ...] | int) -> tuple[str, ...] | int:
        if isinstance(value, int):
            return value
        for name in value:
            _name(name)
        twice = sorted({name for name in value if value.count(name) > 1})
        if twice:
            raise ValueError(f"participant {twice[0]} is listed twice | each takes part once: remove one, or rename it")
        folders = [name.lower() for name in value]
        alike = sorted({name for name in value if folders.count(name.lower()) > 1})
        if alike:
            what = f"participants {' and '.join(alike[:2])} differ by capitals alone"
            raise ValueError(f"{what} | rename one: their folders are one where capitals do not count")
        if not value:
            raise ValueError("nobody takes part | list pseudonyms, or give a number")
        return value

    @field_validator("measures")
    @classmethod
    def _known(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        for name in value:
            if name not in MEASURES:
                near = difflib.get_close_matches(name, MEASURES, n=1)
                mend = f"did you mean {near[0]}?" if near else f"measures: {', '.join(MEASURES)}"
                raise ValueError(f"there is no measure {name} | {mend}")
        return tuple(dict.fromkeys(value))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> ExperimentFile:
        """Read an experiment file.

        Raises:
            SceneError: the file is invalid; the message gives file and line of every error, and how to correct it.
        """
        file = Path(path)
        if not file.is_file():
            mend = "check the path; examples/experiment_haptics.yaml is one"
            raise SceneError("experiment file not found", where=str(file), mend=mend)
        data, lines = text.parse(text.read(file), str(file), "experiment", "title: Does a felt force help?")
        try:
            made = cls.validated(data, {"folder": file.parent})
        except ValidationError as error:
            raise explain.scene_error(error, cls, str(file), lines) from None
        made._file, made._lines = str(file), lines
        return made

    @property
    def file(self) -> str:
        """Path of the file; empty for an experiment made in Python."""
        return self._file

    @property
    def stem(self) -> str:
        """Short name for folders."""
        return Path(self._file).stem or "experiment"

    def where(self, *place: str | int) -> str:
        """``file:line`` of a value."""
        return where_in(self._file or "experiment", self._lines, place)

    @property
    def people(self) -> tuple[str, ...]:
        """Pseudonyms of all participants."""
        if isinstance(self.participants, int):
            width = max(2, len(str(self.participants)))
            return tuple(f"P{i:0{width}d}" for i in range(1, self.participants + 1))
        return self.participants
