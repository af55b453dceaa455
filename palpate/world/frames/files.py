"""Reads the edges of a list ``frames``: sections with poses, and files with registration results."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from palpate.base.arrays import Array
from palpate.base.arrays.yaml_loader import read_yaml
from palpate.base.errors import FrameError
from palpate.base.values import NotNegative, Number, Section
from palpate.base.values.wording import describe, place_in_file
from palpate.world.frames import checks
from palpate.world.frames.edge import Edge, isotropic
from palpate.world.frames.graph import FrameGraph
from palpate.world.frames.section import EdgePose, FrameSection, Row, seconds_of


class _Result(Section):
    """Content of a registration result, or of a file that holds one pose."""

    model_config = ConfigDict(extra="ignore")  # a result also names its method, points and outliers

    X: Annotated[tuple[Row, ...], Field(min_length=4, max_length=4)] | None = None
    """X_parent_child, four rows of four numbers [m]"""
    pose: EdgePose | None = None
    covariance: Annotated[tuple[tuple[Number, ...], ...], Field(min_length=6, max_length=6)] | None = None
    sigma_mm: NotNegative | None = None
    sigma_deg: NotNegative | None = None
    source: str = ""
    date: str | Number | None = None
    method: str = ""
    sources: tuple[str, ...] = ()
    fre: NotNegative | None = None
    """rms residual of the fiducials [m]"""
    tre: tuple[NotNegative | None, ...] | None = None
    """predicted rms error at each target [m]"""
    trusted: bool | None = None
    """False if the registration judged itself as wrong or ambiguous"""
    accepted: str = ""
    """why somebody uses it although it is not trusted"""

    @property
    def origin(self) -> str:
        """The source, or method and measurements of a registration."""
        names = ", ".join(Path(name).name for name in self.sources)
        return self.source or (f"{self.method} of {names}" if names else self.method)

    @property
    def largest_tre(self) -> float | None:
        """Predicted error at the worst target [m]; None without targets."""
        return max((x for x in self.tre or () if x is not None), default=None)


def load(path: str | os.PathLike[str]) -> FrameGraph:
    """The graph of a YAML file with a list ``frames``, in the format of a scene.

    Raises:
        FrameError: the file cannot be read, or an entry is invalid; the message names the frame.
    """
    data = _content(Path(path))
    try:
        sections = [FrameSection.validated(entry) for entry in data.get("frames", ())]
    except ValidationError as error:
        raise _refusal(Path(path), error, FrameSection) from None
    return FrameGraph(edges(sections, lambda name: Path(path).parent / name))


def edges(sections: Iterable[FrameSection], file: Callable[[str], Path] = Path) -> list[Edge]:
    """The edges of sections; `file` returns the path of a file that a section names.

    Raises:
        FrameError: a pose or its file is invalid.
    """
    return [edge(section, file) for section in sections]


def edge(section: FrameSection, file: Callable[[str], Path] = Path) -> Edge:
    """The edge of one section.

    Raises:
        FrameError: the pose or its file is invalid.
    """
    name = f"X_{section.parent}_{section.child}"
    path = None if section.file is None else file(section.file)
    found = _Result(pose=section.pose) if path is None else _result(path, section.accept)
    X = _pose(found, name)
    given = (_covariance(section), _covariance(found))
    covariance = next((C for C in given if C is not None), None)
    kind: Literal["live", "measured", "known"] = "known"
    source = section.source or found.origin or section.file or ""
    if found.trusted is False:
        source += f"; not trusted, accepted: {section.accept or found.accepted}"
    if section.tracker is not None:
        kind, source = "live", section.source or f"tracker {section.tracker}"
    elif path is not None or covariance is not None:
        kind = "measured"
    stamp = seconds_of(section.stamp if section.stamp is not None else found.date)
    C = np.zeros((6, 6)) if covariance is None else covariance
    errors = (found.fre, found.largest_tre)
    try:
        return Edge(section.parent, section.child, X, C, source, kind, stamp, section.check, *errors)
    except FrameError as error:
        where = str(path) if path else error.where
        raise FrameError(error.what, where=where, why=error.why, mend=error.mend) from None


def pose(path: Path) -> Array:
    """The pose X_parent_child (4, 4) [m] of a file with a registration result or a pose.

    Raises:
        FrameError: the file cannot be read, holds no pose, or its registration marks itself as not trusted.
    """
    return checks.pose(f"the pose of {path}", _pose(_result(path), str(path)))


def _pose(found: _Result, name: str) -> Array:
    return found.pose.to_matrix(name) if found.pose is not None else np.array(found.X)


def _covariance(given: FrameSection | _Result) -> Array | None:
    if given.covariance is not None:
        try:
            return np.array(given.covariance, dtype=np.float64)
        except ValueError:
            raise FrameError(
                "a covariance must have six rows of six numbers", mend="order: dx dy dz rx ry rz"
            ) from None
    if given.sigma_mm is None and given.sigma_deg is None:
        return None
    return isotropic(1e-3 * (given.sigma_mm or 0.0), float(np.radians(given.sigma_deg or 0.0)))


def _result(path: Path, accept: str = "") -> _Result:
    data = _content(path)
    try:
        found = _Result.validated(data)
        seconds_of(found.date)
    except ValidationError as error:
        raise _refusal(path, error, _Result) from None
    except ValueError as error:
        what, _, mend = str(error).partition(" | ")
        raise FrameError(what, where=str(path), mend=mend) from None
    if (found.X is None) == (found.pose is None):
        what = "it holds neither X nor pose" if found.X is None else "it holds both X and pose"
        raise FrameError(what, where=str(path), mend="X: four rows of four numbers [m]; or pose with its unit")
    if found.trusted is False and not (accept or found.accepted):
        what = "the registration marks its own result as not trusted"
        raise FrameError(
            what, where=str(path), mend="register again, or accept it by a reason: accept: REASON in the frame's entry"
        )
    return found


def _content(path: Path) -> dict[str, Any]:
    try:
        data = read_yaml(path)
    except FileNotFoundError:
        mend = "check the path, or write the file: palpate register ... --out, palpate register session"
        raise FrameError("file with a pose not found", where=str(path), mend=mend) from None
    except (OSError, UnicodeDecodeError) as error:
        raise FrameError("the file cannot be read", where=str(path), why=str(error), mend="name a YAML file") from None
    except yaml.YAMLError as error:
        why = " ".join(str(error).split())
        raise FrameError("not valid YAML", where=str(path), why=why, mend="check the file") from None
    if not isinstance(data, dict):
        raise FrameError(
            f"the file holds a {type(data).__name__}", where=str(path), mend="it must hold X, or a list frames"
        )
    return data


def _refusal(path: Path, error: ValidationError, model: type[BaseModel]) -> FrameError:
    first = error.errors(include_url=False)[0]
    place, _ = place_in_file(tuple(first["loc"]), model, keep_last=first["type"] == "extra_forbidden")
    what, why, mend = describe(first, place, model)
    return FrameError(f"{what} ({why})" if why else what, where=str(path), mend=mend)
