"""Sections of a scene's list ``frames``: one edge each, with the pose as matrix, quaternion or angles, or in a file."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from palpate.base.arrays import Array, so3
from palpate.base.values import NotNegative, Number, Pose, Section, Vector
from palpate.base.values.units import FILE_UNITS
from palpate.world.frames import checks

Row = tuple[Number, Number, Number, Number]
_ROTATIONS = ("rpy_deg", "quat_wxyz", "quat_xyzw")


class EdgePose(Section):
    """Pose of a frame in another: a matrix, or a position with angles or with a quaternion in a stated order."""

    xyz: Vector = (0.0, 0.0, 0.0)
    """origin of the child in the parent [unit]"""
    rpy_deg: Vector | None = None
    """roll, pitch, yaw about the parent's fixed x, then y, then z [deg]"""
    quat_wxyz: Row | None = None
    """instead: unit quaternion with the scalar first, as in Eigen's constructor and MuJoCo [-]"""
    quat_xyzw: Row | None = None
    """instead: unit quaternion with the scalar last, as in ROS and SciPy [-]"""
    matrix: tuple[Row, Row, Row, Row] | None = None
    """instead of all: homogeneous matrix, four rows of four numbers [unit]"""
    unit: Literal["mm", "cm", "m", "in"] = "m"
    """unit of xyz, and of the translation in matrix"""

    @model_validator(mode="after")
    def _check(self) -> EdgePose:
        given = [key for key in (*_ROTATIONS, "matrix") if getattr(self, key) is not None]
        if len(given) > 1:
            raise ValueError(f"{' and '.join(given)} are given | keep one of them")
        if self.matrix is not None and any(self.xyz):
            raise ValueError("matrix and xyz are given | the last column of matrix is the position: remove xyz")
        return self

    def to_matrix(self, name: str) -> Array:
        """X_parent_child (4, 4) [m].

        Raises:
            FrameError: the matrix is not rigid, the quaternion is not of unit norm, or the translation is too large.
        """
        if self.matrix is not None:
            X = np.array(self.matrix)
        else:
            X = Pose(xyz=self.xyz, rpy_deg=self.rpy_deg or (0.0, 0.0, 0.0)).matrix()
            wxyz = self.quat_wxyz
            if self.quat_xyzw is not None:
                wxyz = (self.quat_xyzw[3], *self.quat_xyzw[:3])
            if wxyz is not None:
                X[:3, :3] = so3.matrices(checks.quaternion(f"the quaternion of {name}", wxyz))
        X[:3, 3] *= FILE_UNITS[self.unit]
        return checks.pose(name, X)


class FrameSection(Section):
    """An edge of the graph of frames: the frame `child` in the frame `parent`."""

    parent: str = "world"
    """frame in which the pose is given: world, or the child of another entry"""
    child: str
    """name of the frame that this entry places"""
    pose: EdgePose | None = None
    """X_parent_child; of a tracked frame, its pose until the tracker sees it"""
    file: str | None = None
    """instead: a registration result, as palpate register --out writes it, relative to the scene file"""
    covariance: Annotated[tuple[tuple[Number, ...], ...], Field(min_length=6, max_length=6)] | None = None
    """covariance (6, 6) of the pose error [dp; dtheta], both in the parent frame [m, rad]"""
    sigma_mm: NotNegative | None = None
    """instead: standard deviation of the position on each axis [mm]"""
    sigma_deg: NotNegative | None = None
    """instead: standard deviation of the orientation about each axis [deg]"""
    stamp: str | Number | None = None
    """time of the measurement: 2026-11-22T10:15:00Z, or seconds since 1970"""
    source: str = ""
    """origin of the pose; the file's name when left out"""
    accept: str = ""
    """why a registration is used although its file marks it as not trusted; told wherever the frame's source is"""
    check: bool = False
    """true: a second path to child, compared with the first; it places nothing"""
    tracker: str | None = None
    """tracker of the scene that moves this frame while a session runs; parent is the tracker's own frame"""
    tool: str = ""
    """name of the frame at the tracker, such as StylusToTracker; child when left out"""

    @model_validator(mode="after")
    def _check(self) -> FrameSection:
        if (self.pose is None) == (self.file is None):
            both = self.pose is not None
            what = "pose and file are given" if both else "neither pose nor file is given"
            mend = "keep one of them" if both else "give e.g. pose: {xyz: [0, 0, 0.5]}"
            raise ValueError(f"frame {self.child!r}: {what} | {mend}")
        if self.covariance is not None and (self.sigma_mm is not None or self.sigma_deg is not None):
            raise ValueError(f"frame {self.child!r}: covariance and sigma are given | keep one of them")
        if self.check and self.tracker is not None:
            raise ValueError(f"frame {self.child!r}: a check is not live | remove tracker or check")
        seconds_of(self.stamp)
        return self


def seconds_of(stamp: str | float | None) -> float | None:
    """Seconds since 1970 of a stamp; a date without a time zone is UTC.

    Raises:
        ValueError: the text is not a date in the form of ISO 8601.
    """
    if stamp is None or not isinstance(stamp, str):
        return stamp
    try:
        date = datetime.fromisoformat(stamp)
    except ValueError:
        raise ValueError(f"stamp {stamp!r} is not a date | write e.g. 2026-11-22T10:15:00Z") from None
    return (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp()
