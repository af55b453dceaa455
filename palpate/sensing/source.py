"""Interface of sources of clouds: a depth camera, a recording, a topic, or a simulation."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.world.clouds.table import Colors


@dataclass(frozen=True)
class CloudFrame:
    """One frame of a depth camera as it arrives, not yet checked."""

    points: npt.NDArray[np.floating]
    """(N, 3) or (rows, columns, 3) in the camera's frame C [m]; not finite where the camera saw nothing"""
    t: float
    """stamp: time of the measurement, by the session's clock [s]"""
    X_WC: Array = field(default_factory=lambda: np.eye(4))
    """pose (4, 4) of the camera in W at that time [m]; C has its origin at the sensor"""
    colors: Colors | None = None
    """(N, 3) red, green, blue of the points; None: unknown"""


class CloudSource(Protocol):
    """A source of frames. It is asked by a thread beside the loop."""

    def latest(self, now: float) -> CloudFrame | None:
        """The newest frame since the last call, None if there is none; never waits. now: time of the session [s]."""
        ...

    def close(self) -> None:
        """End the connection."""
        ...


@runtime_checkable
class Hearing(Protocol):
    """A source that says why no frame comes."""

    def heard(self) -> str:
        """What is known of its connection and of the last frame that could not be used, in words; may be empty."""
        ...


class IteratorSource:
    """The clouds of a Python iterator, one at a time.

    Args:
        clouds: arrays (N, 3) in the camera's frame [m], or whole frames.
        rate: rate at which the iterator is asked [Hz]; 0: whenever the session asks.
        X_WC: pose (4, 4) of the camera in W [m], for arrays.
        clock: time of an array when it is taken from the iterator, from the session's time; that time when None.
    """

    def __init__(
        self,
        clouds: Iterable[npt.ArrayLike | CloudFrame],
        rate: float = 30.0,
        X_WC: npt.ArrayLike | None = None,
        clock: Callable[[float], float] | None = None,
    ) -> None:
        self._clouds: Iterator[npt.ArrayLike | CloudFrame] = iter(clouds)
        self._period = 1.0 / rate if rate > 0 else 0.0
        self._X_WC = np.eye(4) if X_WC is None else np.asarray(X_WC, dtype=np.float64)
        self._clock = clock
        self._next = -np.inf

    def latest(self, now: float) -> CloudFrame | None:
        """The next frame of the iterator once its time has come."""
        if now < self._next - 1e-9:
            return None
        cloud = next(self._clouds, None)
        if cloud is None:
            return None
        self._next = now + self._period if now - self._next > self._period else self._next + self._period
        if isinstance(cloud, CloudFrame):
            return cloud
        return CloudFrame(
            np.asarray(cloud, dtype=np.float64), now if self._clock is None else self._clock(now), self._X_WC
        )

    def close(self) -> None:
        """Nothing is open."""


Clouds = Mapping[str, CloudSource | Iterable[npt.ArrayLike | CloudFrame]]
"""Sources by name; an iterable of arrays (N, 3) [m] in W, or of frames, is asked at 30 Hz."""


def as_sources(clouds: Clouds | None) -> dict[str, CloudSource]:
    """The same with every iterable as a source."""
    given = clouds or {}
    return {
        name: source if hasattr(source, "latest") else IteratorSource(source)  # type: ignore[misc]
        for name, source in given.items()
    }
