"""Decides which poses of a tracked tool are trusted; keeps the last good pose and says in words what is wrong."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array, rigid
from palpate.base.errors import FrameError
from palpate.sensing.trackers.tracker import Sighting
from palpate.world.frames import checks

_SLACK = (3e-3, 0.05)  # displacement that noise and jitter of the stamps explain [m, rad]
_MEMORY = 0.1  # longest interval for which motion between two poses is allowed [s]
_METRES = (0.6, 1.6)  # interval of 1000 |p| / |p_start| in which a first pose was most likely sent in metres [-]


@dataclass(frozen=True)
class Limits:
    """Limits within which the poses of a tool are trusted."""

    max_age: float = 0.2
    """age of the newest good pose above which the tool is lost [s]"""
    max_error: float = 1e-3
    """largest rms residual of the marker's spheres [m]"""
    max_speed: float = 0.25
    """largest plausible speed [m/s]"""
    max_turn: float = math.pi
    """largest plausible angular speed [rad/s]"""


class Gate:
    """Poses of one tool: the last good one, and the reason why newer ones were refused.

    A pose is refused if the tracker marks it as invalid, if it is not rigid, if the residual of its spheres is too
    large, if its stamp goes backwards, or if no plausible motion leads to it from the last good pose: the tracker may
    have confused two tools. A jump is not followed, however long it lasts, until the tool returns or `accept_jump` is
    called.

    Args:
        tool: name of the tool in messages.
        X: pose (4, 4) until the first sighting [m].
        limits: limits of trust.
    """

    def __init__(self, tool: str, X: Array, limits: Limits | None = None) -> None:
        self.tool, self.limits = tool, limits or Limits()
        self.X = X  #: last good pose (4, 4) [m]
        self.refused = 0  #: number of refused poses
        self.taken = 0  #: number of good poses
        self.began = False  #: True if the last good pose was trusted wherever it was: a new motion begins with it
        self._why = ""
        self._jumped = False  # whether the newest refused pose was a jump
        self._stamp = -math.inf
        self._good_at: float | None = None
        self._memory = _MEMORY  # interval for which motion is allowed; a jump that lasts gains no more [s]
        self._free = True  # the next valid pose is taken wherever it is

    def take(self, seen: Sighting, now: float) -> bool:
        """Take in a sighting at the session's time `now` [s]; True if it is the new good pose."""
        if seen.t == self._stamp:
            return False  # the tracker repeats a pose, which therefore ages
        self._jumped = False
        why, X = self._judged(seen)
        if why:
            self._why, self.refused = why, self.refused + 1
            return False
        self.X, self._stamp, self._good_at = X, seen.t, now
        self.taken += 1
        self._why, self.began, self._free, self._memory = "", self._free, False, _MEMORY
        return True

    @property
    def jumped(self) -> bool:
        """True while the newest pose is refused because no plausible motion leads to it."""
        return self._jumped and bool(self._why)

    def accept_jump(self) -> None:
        """Trust the next valid pose wherever it is, for example after a marker was moved on purpose."""
        self._free = True

    @property
    def seen_at(self) -> float:
        """Session's time of the last good pose [s]; -inf before the first."""
        return -math.inf if self._good_at is None else self._good_at

    def is_lost(self, now: float) -> bool:
        """True before the first good pose, and when the newest is older than `Limits.max_age` at the time `now` [s]."""
        return self._good_at is None or now - self._good_at > self.limits.max_age

    def status(self, now: float) -> str:
        """The state in words: tracked, not seen yet, or lost with the time since the last good pose and the reason."""
        reason = f": {self._why}" if self._why else ""
        if self._good_at is None:
            return f"not seen yet{reason}"
        if not self.is_lost(now):
            return f"tracked{reason}"
        return f"lost for {now - self._good_at:.1f} s{reason or ': no pose arrives'}"

    def _judged(self, seen: Sighting) -> tuple[str, Array]:
        if not seen.valid:
            return seen.why or "the tracker marks the pose as invalid", self.X
        if seen.error > self.limits.max_error:
            return f"its spheres fit within {1e3 * seen.error:.2f} mm only", self.X
        if not math.isfinite(seen.t) or seen.t < self._stamp:
            return f"its stamp goes backwards by {self._stamp - seen.t:.3f} s", self.X
        try:
            X = checks.pose(f"the pose of {self.tool}", seen.X)
        except FrameError as error:
            return "; ".join(part for part in (error.what, error.why) if part), self.X
        return self._implausible(X, seen.t), X

    def _implausible(self, X: Array, t: float) -> str:
        far, start = float(np.linalg.norm(X[:3, 3])), float(np.linalg.norm(self.X[:3, 3]))
        if self._good_at is None and start > 0.1 and _METRES[0] < 1e3 * far / start < _METRES[1]:
            return f"it lies {1e3 * far:.2f} mm from the tracker: most likely sent in metres instead of millimetres"
        if self._free:
            return ""
        xi, dt = rigid.displacement(self.X, X), min(t - self._stamp, self._memory)
        moved, turned = float(np.linalg.norm(xi[:3])), float(np.linalg.norm(xi[3:]))
        self._memory = dt
        if moved > self.limits.max_speed * dt + _SLACK[0]:
            self._jumped = True
            return f"it jumped by {1e3 * moved:.1f} mm, tools may be confused"
        if turned > self.limits.max_turn * dt + _SLACK[1]:
            self._jumped = True
            return f"it turned by {math.degrees(turned):.1f} deg at once, spheres or tools may be confused"
        return ""
