"""Judges the frames of a source by their stamps and their content before they become a surface."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from palpate.base.errors import CloudError
from palpate.sensing.source import CloudFrame

Points = npt.NDArray[np.floating]

_FUTURE = 0.05  # stamps further ahead of the session's clock are wrong [s]
_CHECKED = 997  # points of a frame that are compared with the previous frame's


@dataclass
class FrameCounts:
    """Number of frames by what became of them, since the session began."""

    used: int = 0
    doubled: int = 0  #: the stamp of the frame before
    backwards: int = 0  #: a stamp before that of the frame before
    late: int = 0  #: older than the patience when it arrived
    future: int = 0  #: a stamp ahead of the session's clock
    frozen: int = 0  #: a new stamp on exactly the same points
    empty: int = 0  #: no valid point within the region
    invalid: int = 0  #: not an array of points, or the pose of the camera is not a pose

    def refused(self) -> str:
        """Frames that were not used, by their number and reason, in words; empty without any."""
        words = {
            "doubled": "with the stamp of the frame before", "backwards": "with stamps that go backwards",
            "late": "older than the patience", "future": "with stamps ahead of the clock",
            "frozen": "with the points of the frame before", "empty": "without a valid point within the region",
            "invalid": "that are no points, or whose camera has no pose",
        }  # fmt: skip
        return ", ".join(f"{getattr(self, name)} frames {why}" for name, why in words.items() if getattr(self, name))


@dataclass
class Gate:
    """The stamps and the content of one stream."""

    patience: float  #: age above which a frame is too old to use [s]
    counts: FrameCounts = field(default_factory=FrameCounts)
    last: float = -np.inf  #: stamp of the newest frame that was used [s]
    _sample: Points | None = None

    def take(self, frame: CloudFrame, now: float) -> Points | None:
        """The points (N, 3) of a frame that can be used, None for every other; now: time of the session [s]."""
        counts = self.counts
        if not np.isfinite(frame.t) or frame.t > now + _FUTURE:
            counts.future += 1
        elif frame.t == self.last:
            counts.doubled += 1
        elif frame.t < self.last:
            counts.backwards += 1
        elif now - frame.t > self.patience:
            counts.late += 1
        else:
            return self._content(frame)
        return None

    def accept(self, t: float) -> None:
        """Note that the frame with the stamp t [s] became the surface."""
        self.last = t
        self.counts.used += 1

    def _content(self, frame: CloudFrame) -> Points | None:
        try:
            points = points_of(frame)
        except CloudError:
            self.counts.invalid += 1
            return None
        sample = points[:: max(1, len(points) // _CHECKED)]
        if self._sample is not None and np.array_equal(sample, self._sample, equal_nan=True) and len(sample) > 1:
            self.counts.frozen += 1
            return None
        self._sample = sample.copy()
        return points


def points_of(frame: CloudFrame) -> Points:
    """The points (N, 3) of a frame in its camera's frame, invalid ones included; float32 and float64 are not copied.

    Raises:
        CloudError: the points have a wrong shape, or X_WC is not a pose.
    """
    given = np.asarray(frame.points)
    points = np.ascontiguousarray(given, dtype=given.dtype if given.dtype in (np.float32, np.float64) else np.float64)
    if points.ndim not in (2, 3) or points.shape[-1] != 3:
        raise CloudError(f"points of a frame must have shape (N, 3), got {points.shape}")
    X = np.asarray(frame.X_WC, dtype=np.float64)
    rigid = X.shape == (4, 4) and np.isfinite(X).all() and np.allclose(X[:3, :3] @ X[:3, :3].T, np.eye(3), atol=1e-6)
    if not rigid:
        raise CloudError("X_WC of a frame must be a pose (4, 4)")
    return points.reshape(-1, 3)
