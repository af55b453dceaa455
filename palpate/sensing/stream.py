"""From the frames of one source to the surface of one object, beside the running loop."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.record.ticks import Ticks
from palpate.scene.clouds import CloudSection
from palpate.sensing.gate import Gate
from palpate.sensing.instrument import Instrument
from palpate.sensing.motion import SurfaceMotion
from palpate.sensing.patch import patch
from palpate.sensing.source import CloudFrame
from palpate.world.clouds.neighbourhoods import Sampling, sampling
from palpate.world.surfaces.points import Scales

if TYPE_CHECKING:
    from palpate import _tissue

_LEAST = 100  # points of a frame within the region at least
_MEASURED = 6000  # points from which spacing and noise are estimated
_SIGMA = 3.0  # margin around the tool, in standard deviations of the noise
_MARGIN = 2e-3  # and at least [m]
_HOLE = 1.6  # radius of the hole that the tip leaves, in radii of its ball
_MATCHED = 0.03  # radius around the tool within which displacements are measured [m]
_KEY = 1.0  # time for which displacements are measured from one frame [s]


@dataclass(frozen=True)
class Memory:
    """Points that were seen before, and that the instrument hides. In W at the stamp of the newest frame."""

    points: Array = field(default_factory=lambda: np.empty((0, 3)))  #: (n, 3) [m]
    normals: Array = field(default_factory=lambda: np.empty((0, 3)))  #: (n, 3)
    seen_at: Array = field(default_factory=lambda: np.empty(0))  #: stamps of the frames that saw them (n,) [s]

    def where(self, keep: npt.NDArray[np.bool_]) -> Memory:
        """A part of the points."""
        return Memory(self.points[keep], self.normals[keep], self.seen_at[keep])


@dataclass(frozen=True)
class Built:
    """A surface that is ready for the loop."""

    core: _tissue.PointSurface  #: in the object's frame O
    V: Array  #: velocity of the surface in W (3,) [m/s]
    remembered: int  #: averaged points that the instrument hides


@dataclass(frozen=True)
class _Key:
    """The frame from which displacements are measured."""

    surface: _tissue.PointSurface
    anchor: Array  # p_WO for which it is right at its stamp (3,) [m]
    t: float  # stamp [s]
    tip: Array  # position of the tool's tip in W (3,) [m]


class Stream:
    """The frames of one source as the surface of one object.

    The object's frame O only translates. `X` in the methods is the position p_WO (3,) at which the loop renders it.

    Args:
        section: the object's section `cloud`.
        instrument: the tool, whose own points are cut out.
        extrapolate: False: the surface rests between two frames, for comparison.
    """

    def __init__(self, section: CloudSection, instrument: Instrument, extrapolate: bool = True) -> None:
        self.section, self.gate = section, Gate(section.patience)
        self.counts: dict[str, int] = {}  #: points of the newest frame: used, invalid, outside, tool
        self.surface: _tissue.PointSurface | None = None
        self._instrument, self._motion, self._extrapolate = instrument, SurfaceMotion(), extrapolate
        self._scales: Scales | None = None
        self._noise = 0.0
        self._balls, self._p_WC = np.empty((0, 4)), np.zeros(3)  # at the newest surface's stamp
        self._anchor = np.zeros(3)  # p_WO for which the surface is right at its stamp [m]
        self._t = 0.0  # stamp of the surface [s]
        self._memory = Memory()
        self._key: _Key | None = None
        self._since_key = np.zeros(3)  # displacement of the surface since the key frame, at the newest stamp [m]

    @property
    def spacing(self) -> float:
        """Distance between the averaged points [m]; 0 before the first frame."""
        return 0.0 if self._scales is None else self._scales.voxel

    @property
    def remembered(self) -> Array:
        """Points (n, 3) in O that the instrument hides, and that were seen before [m]."""
        return self._memory.points - self._anchor

    def build(self, frame: CloudFrame, now: float, tick: Ticks, X: Array) -> Built | None:
        """The surface of a frame at the time `now` [s]; None if the frame cannot be used.

        Args:
            frame: the frame as it arrived.
            now: time of the session [s].
            tick: newest row of the loop, for the pose of the tool.
            X: p_WO (3,) at which the loop renders the object [m].
        """
        from palpate import _tissue

        points_C = self.gate.take(frame, now)
        if points_C is None:
            return None
        margin = _MARGIN + _SIGMA * self._noise
        balls = self._instrument.balls(tick, margin)
        tip = np.ascontiguousarray(balls[0, :3])
        X_WC = np.ascontiguousarray(frame.X_WC, dtype=np.float64)
        points, self.counts = _tissue.usable_points(points_C, X_WC, tip, self.section.region, balls)
        if len(points) < _LEAST:
            self.gate.counts.empty += 1
            return None
        p_WC = X_WC[:3, 3]
        moved = self._displacement(points, frame.t, tip)
        self._memory = self._hidden(frame.t, p_WC, balls, moved)
        made = self._surface(points, p_WC, tip, _HOLE * float(balls[0, 3]))
        V = self._motion.V
        made.translate(-X)
        self._anchor, self._t, self.surface, self._balls, self._p_WC = X, frame.t, made, balls, p_WC
        self.gate.accept(frame.t)
        return Built(made, V, len(self._memory.points))

    def rebase(self, X: Array, V: Array, now: float) -> Array:
        """Displacement (3,) [m] of the newest surface in O that makes it right when the loop renders O at X now."""
        anchor = X - V * max(now - self._t, 0.0)
        moved = self._anchor - anchor
        self._anchor = anchor
        return np.asarray(moved)

    def _hidden(self, t: float, p_WC: Array, balls: Array, moved: Array) -> Memory:
        """The points seen before that the tool hides at the time t [s], where they are now."""
        if self.surface is None:
            return Memory()
        p, n, _ = self.surface.averaged()
        seen = ~self._instrument.is_hidden(p + self._anchor, self._p_WC, self._balls)
        before = Memory(
            np.concatenate([self._memory.points, p[seen] + self._anchor]) + moved,
            np.concatenate([self._memory.normals, n[seen]]),
            np.concatenate([self._memory.seen_at, np.full(int(seen.sum()), self._t)]),
        )
        young = t - before.seen_at <= self.section.remember
        return before.where(young & self._instrument.is_hidden(before.points, p_WC, balls))

    def _surface(self, points: Array, p_WC: Array, tip: Array, hole: float) -> _tissue.PointSurface:
        """The surface in W at the stamp, with the hole under the tip closed."""
        from palpate import _tissue

        if self._scales is None:
            found = _sampled(points)
            self._noise = found.noise
            usual = Scales.of(found)
            given = self.section
            self._scales = Scales(usual.voxel, given.support or usual.support, given.bridge or usual.bridge)
        s, memory = self._scales, self._memory
        known = np.concatenate([points, memory.points])
        filled, normals = patch(known, p_WC, tip, hole, s.voxel)
        return _tissue.PointSurface(
            np.concatenate([known, filled]), np.concatenate([np.zeros_like(points), memory.normals, normals]),
            np.ascontiguousarray(p_WC), s.voxel, s.support, s.bridge, self.section.thickness, self.surface,
        )  # fmt: skip

    def _displacement(self, points: Array, t: float, tip: Array) -> Array:
        """Displacement (3,) [m] of the surface near the tool since the frame before; updates the velocity.

        It is the difference of two displacements since one key frame: those from frame to frame would add up their
        noise, by which remembered points would drift.
        """
        if self.surface is None:
            return np.zeros(3)
        key = self._key
        if key is None or t - key.t > _KEY or float(np.linalg.norm(tip - key.tip)) > 0.5 * _MATCHED:
            key = self._key = _Key(self.surface, self._anchor, self._t, tip)
            self._since_key = np.zeros(3)
        dt = t - self._t
        expected = self._motion.V * dt
        anchor = key.anchor + self._since_key + expected  # in these coordinates only the prediction's error moves
        rest = key.surface.shift_to(points - anchor, tip - anchor, _MATCHED)
        moved = expected if rest is None else expected + rest
        self._since_key = self._since_key + moved
        if rest is None:
            self._key = None
        if self._extrapolate:
            self._motion.update(None if rest is None else moved, dt)
        return moved


def _sampled(points: Array) -> Sampling:
    """Spacing and noise of the densest part of a frame: that nearest to its middle point."""
    middle = np.median(points, axis=0)
    order = np.argpartition(((points - middle) ** 2).sum(axis=1), min(_MEASURED, len(points) - 1))
    return sampling(points[order[:_MEASURED]])
