"""Converts a recorded motion of the tool to a smoothed, thinned path, and measures the path's deviation from it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation, Slerp

from palpate.base.arrays import Array
from palpate.base.arrays.so3 import matrices
from palpate.base.errors import GuidanceError
from palpate.scene.guidance.plot import query

if TYPE_CHECKING:
    from palpate import _guidance

SPACING = 2e-3  #: spacing of the places of the path [m]
SMOOTH = 1e-3  #: standard deviation of the Gaussian along the path: removes shorter tremor and noise [m]
_SAMPLING = 1e-4  # maximum spacing of the samples along the path before smoothing [m]


@dataclass(frozen=True)
class Shown:
    """A recorded motion of the tool."""

    t: Array
    """(n,) time [s]"""
    p_WT: Array
    """(n, 3) position in W [m]"""
    R_WT: Array
    """(n, 3, 3) attitude in W"""


@dataclass(frozen=True)
class Deviation:
    """Distance of a demonstration from a path."""

    rms: float
    """root mean square [m]"""
    worst: float
    """maximum [m]"""


def read(record: Path, span: tuple[float, float] | None = None) -> Shown:
    """The motion of the tool in a record of Palpate, within the time `span` [s] if given.

    Raises:
        RecordError: the record cannot be read. GuidanceError: the record has no motion of a tool in that time.
    """
    from palpate.record import Record

    file = record / "record.mcap" if record.is_dir() else record
    found = Record.open(file)
    missing = [name for name in ("p_WT", "quat_WT") if name not in found.signals]
    if missing:
        raise GuidanceError(f"{' and '.join(missing)} not recorded", where=str(file), mend="use the record of a run")
    ticks = found.read(["t", "p_WT", "quat_WT"])
    t = np.asarray(ticks["t"])
    keep = np.isfinite(np.asarray(ticks["p_WT"])).all(axis=1)
    if span is not None:
        keep &= (t >= span[0]) & (t <= span[1])
    if not keep.any():
        during = "" if span is None else f" from {span[0]:g} to {span[1]:g} s"
        raise GuidanceError(
            f"no tick{during}", where=str(file), mend=f"the record covers {t[0]:.3g} to {t[-1]:.3g} s" if len(t) else ""
        )
    return Shown(t[keep], np.asarray(ticks["p_WT"])[keep], matrices(np.asarray(ticks["quat_WT"])[keep]))


def simplified(shown: Shown, spacing: float = SPACING, smooth: float = SMOOTH) -> tuple[Array, Array]:
    """Places (n, 3) about `spacing` apart along the motion [m], and attitudes (n, 3, 3) at the places.

    The motion is sampled evenly along its arc length, so that pauses have no weight, and smoothed by a Gaussian of
    standard deviation `smooth` [m]. The ends keep their positions.

    Raises:
        GuidanceError: the tool moved less than twice `spacing`.
    """
    step = np.linalg.norm(np.diff(shown.p_WT, axis=0), axis=1)
    moved = np.r_[True, step > 1e-9]
    along = np.r_[0.0, np.cumsum(step)][moved]
    if along[-1] < 2.0 * spacing:
        raise GuidanceError(
            f"the tool moved {1e3 * along[-1]:.3g} mm in all",
            why=f"a path with a place every {1e3 * spacing:g} mm needs more",
            mend="a longer motion, or a smaller spacing",
        )
    even = np.linspace(0.0, along[-1], int(np.ceil(along[-1] / min(_SAMPLING, spacing / 4.0))) + 1)
    p = np.stack([np.interp(even, along, column) for column in shown.p_WT[moved].T], axis=1)
    if smooth > 0.0:
        # Extending the samples by point reflection at both ends keeps the ends in place.
        p = _smoothed(p, smooth / even[1])
    n = max(2, round(along[-1] / spacing) + 1)
    places = np.linspace(0.0, along[-1], n)
    kept = np.stack([np.interp(places, even, column) for column in p.T], axis=1)
    rotations = Slerp(along, Rotation.from_matrix(shown.R_WT[moved]))(places).as_matrix()
    return kept, rotations


def deviation(path: _guidance.Geometry, shown: Shown) -> Deviation:
    """Deviation of a demonstration from a path."""
    d = query(path, shown.p_WT)["distance"]
    return Deviation(float(np.sqrt((d**2).mean())), float(d.max()))


def _smoothed(p: Array, sigma: float) -> Array:
    n = min(len(p) - 1, int(4.0 * sigma) + 1)
    before, after = 2.0 * p[0] - p[n:0:-1], 2.0 * p[-1] - p[-2 : -n - 2 : -1]
    return np.asarray(gaussian_filter1d(np.vstack([before, p, after]), sigma, axis=0)[n : n + len(p)])
