"""Converts pydantic's errors to scene errors with file and line or class, the nearest key and the unit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ValidationError

from palpate.base.errors import InvalidSceneError, Place, SceneError, line_of, where_in
from palpate.base.values.wording.keys import place_in_file
from palpate.base.values.wording.message import describe


@dataclass(frozen=True)
class _Problem:
    """An error of pydantic with its place in the file."""

    place: Place
    union: int  # length of the place up to the first alternative of a union; the whole length without a union
    error: Any

    @property
    def root(self) -> Place:
        """Place of the value that has several alternatives, or one number of a list."""
        count_is_wrong = self.error["type"] == "missing" and isinstance(self.place[-1], int)
        return self.place[:-1] if count_is_wrong else self.place[: self.union]


def scene_error(error: ValidationError, model: type[BaseModel], name: str, lines: dict[Place, int]) -> SceneError:
    """One SceneError whose message lists all errors of the file, one for each problem; it describes the first."""
    found = sorted(_problems(error, model), key=lambda problem: line_of(lines, problem.place))
    errors = [_to_scene_error(problem, model, name, lines) for problem in found]
    unique = list({str(e): e for e in errors}.values())
    first = unique[0]
    first.add_others(unique[1:])
    return first


def invalid(error: ValidationError, model: type[BaseModel]) -> InvalidSceneError:
    """The error for values of a section that are given in Python; it names the class, as there are no lines."""
    found = scene_error(error, model, model.__name__, {})
    made = InvalidSceneError(found.what, where=found.where, why=found.why, mend=found.mend)
    made.add_others(found.others)
    return made


def _problems(error: ValidationError, model: type[BaseModel]) -> Iterator[_Problem]:
    """The problems of a file. Of alternatives that all fail, the one that got furthest is kept."""
    by_root: dict[Place, _Problem] = {}
    for e in error.errors(include_url=False):
        place, union = place_in_file(tuple(e["loc"]), model, keep_last=e["type"] == "extra_forbidden")
        if e["type"] == "value_error":
            place += getattr(e["ctx"]["error"], "place", ())
            union = len(place)
        problem = _Problem(place, union, e)
        known = by_root.get(problem.root)
        if known is None or (len(place) > len(known.place) and known.error["type"] != "missing"):
            by_root[problem.root] = problem
    roots = list(by_root)
    for root, problem in by_root.items():
        # pydantic also reports lists with invalid entries as too short: keep only the errors of the entries
        inside = any(len(other) > len(root) and other[: len(root)] == root for other in roots)
        if not (inside and problem.error["type"] in ("too_short", "missing")):
            yield problem


def _to_scene_error(problem: _Problem, model: type[BaseModel], name: str, lines: dict[Place, int]) -> SceneError:
    what, why, mend = describe(problem.error, problem.place, model)
    return SceneError(what, where=where_in(name, lines, problem.place), why=why, mend=mend)
