"""`palpate device test`: checks a driver, with and without a push of 0.5 N, and says what is wrong with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import DeviceError, PalpateError
from palpate.devices.driver import Driver, Facts, facts
from palpate.devices.simulated import SimulatedDevice
from palpate.devices.trace import PUSH, RESTS, Trace, moved_at_rest, rounds

_READ = 1.0  # duration of the readings at rest [s]
_PUSH_TIME = 0.15  # longest push in one direction [s]
_FAR = 0.004  # displacement that ends a push [m]
_MOVED = 2e-4  # displacement that counts as motion [m]
_FARTHEST = 3.0  # larger coordinates are probably millimetres [m]


@dataclass(frozen=True)
class Check:
    """Result of one check."""

    name: str
    passed: bool
    value: str  # what was found
    mend: str = ""  # what to do if the check failed


def judge_driver(driver: Driver, name: str, push: bool) -> list[Check]:
    """Open a driver, check it, and close it.

    Args:
        driver: the driver, not yet open.
        name: its name, for messages.
        push: also push with 0.5 N along each axis; nobody should hold the handle, which moves by some millimetres.

    Raises:
        DeviceError: facts of the driver are missing or out of range.
    """
    known = facts(driver, name)
    try:
        driver.open()
    except PalpateError as error:
        what = f"{error.what} ({error.why})" if error.why else error.what
        return [Check("open", False, what, error.mend)]
    except Exception as error:
        what = f"{type(error).__name__}: {error}"
        return [Check("open", False, what, "check cable, power and permissions; `palpate device list`")]
    try:
        if isinstance(driver, SimulatedDevice):
            driver.held = False
        trace = rounds(driver, known, _READ)
        found = [Check("open", True, "ok"), *check_readings(trace), check_rate(trace, known)]
        if push and known.force_max > 0.0 and _sound(found):
            found.append(check_rest(trace))
            found += [check_push(driver, known, axis) for axis in range(3)] if _sound(found) else []
        return found
    except DeviceError as error:
        return [Check("open", True, "ok"), Check("readings", False, error.what, error.mend)]
    finally:
        driver.close()


def _sound(found: list[Check]) -> bool:
    """True if nothing but the rate is wrong."""
    return all(check.passed for check in found if check.name != "rate")


def check_readings(trace: Trace) -> list[Check]:
    """Checks of the numbers: finite, rigid and right-handed, in metres."""
    X = trace.X
    if not np.isfinite(X).all():
        return [
            Check("finite", False, "a number is NaN or infinite", "check the connection; return the last good pose")
        ]
    R = X[:, :3, :3]
    error = float(np.abs(R @ np.swapaxes(R, 1, 2) - np.eye(3)).max())
    last = float(np.abs(X[:, 3] - [0.0, 0.0, 0.0, 1.0]).max())
    hand = float(np.linalg.det(R).min())
    farthest = float(np.abs(trace.p).max())
    return [
        Check("finite", True, "all numbers are finite"),
        Check(
            "rigid", error < 1e-3 and last < 1e-3, f"error of the rotation {error:.2g}, of the last row {last:.2g}",
            "X[:3, :3] must be a rotation matrix; a transposed pose has its position in the last row",
        ),
        Check("right-handed", hand > 0.0, f"determinant {hand:+.2f}", "reverse the sign of one axis"),
        Check("metres", farthest < _FARTHEST, f"largest coordinate {farthest:.3g} m", "divide millimetres by 1000"),
    ]  # fmt: skip


def check_rate(trace: Trace, known: Facts) -> Check:
    """The driver keeps its rate within 10 %."""
    rate = (len(trace.t) - 1) / max(float(trace.t[-1] - trace.t[0]), 1e-9)
    mend = "state the rate that the device reaches, or make read() return without waiting"
    return Check("rate", rate >= 0.9 * known.rate, f"{rate:.0f} Hz of {known.rate:g} Hz", mend)


def check_rest(trace: Trace) -> Check:
    """The handle rests without a force, so that what a push moves is its own."""
    moved = moved_at_rest(trace)
    mend = "let go of the handle and lay it down; the stand-in moves its own unless it is started with --free"
    return Check(
        "rest", moved < RESTS, f"the handle moved by {1e3 * moved:.2g} mm in {_READ:g} s without a force", mend
    )


def check_push(driver: Driver, known: Facts, axis: int) -> Check:
    """A push along an axis moves the handle along this axis, and in its direction. The push is then taken back."""
    direction = np.eye(3)[axis]
    trace = rounds(driver, known, _PUSH_TIME, _Push(PUSH * direction))
    moved = trace.p[-1] - trace.p[0]
    rounds(driver, known, _PUSH_TIME, _Push(-PUSH * direction))
    rounds(driver, known, 0.2)
    along, across = float(moved @ direction), float(np.linalg.norm(moved - (moved @ direction) * direction))
    name, words = f"push {'xyz'[axis]}", "({:+.2f}, {:+.2f}, {:+.2f}) mm".format(*(1e3 * moved))
    if max(abs(along), across) < _MOVED:
        return Check(name, False, f"{PUSH:g} N moved the handle by {words}", "motors off, brakes on, or much friction?")
    if across > abs(along):
        return Check(name, False, f"moved by {words}, along another axis", "exchange the axes of the pose or the force")
    mend = "reverse the sign of this axis in the force (or in the pose and the force)"
    return Check(name, along > 0.0, f"moved by {words}", mend)


class _Push:
    """A constant force until the device has moved far enough."""

    def __init__(self, F: Array) -> None:
        self._F, self._done = F, False

    def __call__(self, t: float, moved: Array) -> Array:
        self._done = self._done or float(np.abs(moved).max()) > _FAR
        return np.zeros(3) if self._done else self._F
