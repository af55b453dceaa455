"""Reads and commands an open device at its rate, for measurements without a scene."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import DeviceError
from palpate.devices.driver import Driver, Facts, as_reading, limited
from palpate.devices.simulated import SimulatedDevice

PUSH = 0.5
"""Largest force of a measurement [N]."""
RESTS = 1e-3
"""Largest motion without a force of a handle that rests [m]."""
_CATCH_UP = 0.1  # lateness that is caught up, so that a busy machine does not lower the mean rate [s]
_REACH = 0.25  # share of the workspace that a measurement may use, from where it starts


@dataclass(frozen=True)
class Trace:
    """What was read and commanded in n rounds."""

    t: Array  # (n,) time of the readings [s]
    X: Array  # (n, 4, 4) poses [m]
    F: Array  # (n, 3) force commanded after each reading [N]
    stopped: bool = False  # the device left the range of the measurement, and the force was set to zero

    @property
    def p(self) -> Array:
        """Positions (n, 3) [m]."""
        return np.asarray(self.X[:, :3, 3])


def moved_at_rest(trace: Trace) -> float:
    """Largest distance of a reading from the first one [m]."""
    return float(np.linalg.norm(trace.p - trace.p[0], axis=1).max())


def rounds(
    driver: Driver,
    facts: Facts,
    seconds: float,
    force: Callable[[float, Array], Array] | None = None,
    most: float = PUSH,
) -> Trace:
    """Read and write at the driver's rate; ends with zero force, also after an error.

    No force exceeds the driver's ``force_max``.

    Args:
        driver: an open driver. A `SimulatedDevice` with ``lockstep`` runs as fast as possible.
        facts: its facts.
        seconds: duration [s].
        force: the force (3,) [N] at a time [s] from the start and displacement (3,) [m]; none when left out. It is cut
            to `most`. A displacement beyond a quarter of the workspace ends the measurement.
        most: largest force along each axis [N].

    Raises:
        DeviceError: the driver failed, or returned something that is no pose.
    """
    n = max(2, round(seconds * facts.rate))
    t, X, F = np.zeros(n), np.zeros((n, 4, 4)), np.zeros((n, 3))
    reach = _REACH * np.array(facts.workspace)
    lockstep = isinstance(driver, SimulatedDevice) and driver.lockstep
    begin = due = time.monotonic()
    with _zero_after(driver):
        for k in range(n):
            X[k] = pose_of(driver)
            t[k] = k / facts.rate if lockstep else time.monotonic() - begin
            moved = X[k, :3, 3] - X[0, :3, 3]
            if force is not None and not (np.abs(moved) <= reach).all():
                return Trace(t[: k + 1], X[: k + 1], F[: k + 1], stopped=True)
            if force is not None:
                wrench = np.zeros(6)
                wrench[:3] = np.minimum(np.maximum(force(t[k], moved), -most), most)
                wrench = limited(wrench, facts)
                F[k] = wrench[:3]
                command(driver, wrench)
            if not lockstep:
                due = max(due + 1.0 / facts.rate, time.monotonic() - _CATCH_UP)
                time.sleep(max(0.0, due - time.monotonic()))
    return Trace(t, X, F)


@contextmanager
def opened(driver: Driver) -> Iterator[None]:
    """Open a device; at the end it is closed after a zero force, and also if that cannot be written.

    Raises:
        DeviceError: one of these calls failed.
    """
    with _call("open"):
        driver.open()
    try:
        with _zero_after(driver):
            yield
    finally:
        with _call("close"):
            driver.close()


@contextmanager
def _zero_after(driver: Driver) -> Iterator[None]:
    """Zero force at the end; after an error it is that one which is told."""
    try:
        yield
    except BaseException:
        with suppress(DeviceError):
            command(driver, np.zeros(6))
        raise
    command(driver, np.zeros(6))


def pose_of(driver: Driver) -> Array:
    """X_LH (4, 4) as a driver reads it [m].

    Raises:
        DeviceError: the driver failed, or returned something that is no pose.
    """
    with _call("read"):
        return np.asarray(as_reading(driver.read()).X, dtype=np.float64)


def command(driver: Driver, wrench: Array) -> None:
    """Write a wrench (6,) [N, N m].

    Raises:
        DeviceError: the driver failed.
    """
    with _call("write"):
        driver.write(wrench)


@contextmanager
def _call(name: str) -> Iterator[None]:
    """What a function of a driver raises becomes an error that names this function."""
    try:
        yield
    except DeviceError:
        raise
    except Exception as error:
        mend = f"check cable and power; else correct {name}() of the driver"
        raise DeviceError(f"{name}() raised {type(error).__name__}: {error}", mend=mend) from None
