"""`palpate device bench`: noise, rate, resolution, friction, mass and delay of a device, and its certificate model."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from palpate.arrays import Array
from palpate.certificate import DeviceModel
from palpate.devices.driver import Driver, Facts, facts
from palpate.devices.identify import AxisFit, fit_axis, noise, resolution
from palpate.devices.simulated import SimulatedDevice
from palpate.devices.trace import PUSH, Trace, rounds
from palpate.errors import DeviceError

REST = 1.0
"""Duration of the measurement at rest [s]."""
_SETTLE = 0.5  # time at zero force before the measurement at rest [s]
_PILOT = 0.06  # half period of the first push, which decides how long the others are [s]
_SPREAD = (0.75, 1.0, 1.3)  # half periods of the alternating push, relative to the middle one
_HALF = (0.05, 0.3)  # range of the middle half period [s]
_STUCK = 1e-4  # range of the first motion below which the device is not pushed further [m]
_STROKE = 0.08  # range of the motion of the middle half period, as a share of the workspace
_WIDTH = 0.6  # width of the fit's test functions over the shortest half period
_REPEATS = 6


@dataclass(frozen=True)
class AxisBench:
    """Measurements along one axis of the device's base."""

    axis: str
    noise_m: float  # rms at rest
    resolution_m: float | None  # step of the measured position; None: no steps seen
    fit: AxisFit | None  # None: the device does not push, or hardly moved
    moved_m: float  # range of the motion during the push


@dataclass(frozen=True)
class Bench:
    """Measurements of a device."""

    name: str
    rate_Hz: float  # rounds of read and write per second that were reached
    interval_p99_us: float  # time between two readings
    fresh: float  # share of readings that differ from the one before
    axes: tuple[AxisBench, AxisBench, AxisBench]
    stopped: bool  # the device left a quarter of its workspace, and the push ended early

    def model(self) -> DeviceModel:
        """The certificate's model: mean mass; smallest damping and friction; longest delay, largest step of all axes.

        Raises:
            DeviceError: the device was not pushed along any axis, so its mass is unknown.
        """
        fits = [axis.fit for axis in self.axes if axis.fit is not None]
        if not fits:
            what = f"device {self.name} did not move, so its mass and friction are unknown"
            raise DeviceError(
                what, mend="switch its motors on, let go of the handle, and check force_max of the driver"
            )
        return DeviceModel(
            mass=float(np.mean([f.mass for f in fits])),
            damping=max(0.0, min(f.damping for f in fits)),
            rate=round(self.rate_Hz, 1),
            delay=max(f.delay for f in fits),
            quantum=max((axis.resolution_m or 0.0) for axis in self.axes),
            friction=max(0.0, min(f.friction for f in fits)),
        )


def measure(driver: Driver, name: str) -> Bench:
    """Open a device, measure it at rest, push it with at most `PUSH` along each axis, and close it.

    Nobody should hold the handle, and a quarter of the workspace around it should be free.

    Raises:
        DeviceError: the driver is invalid or failed.
    """
    known = facts(driver, name)
    driver.open()
    try:
        rate, interval, fresh = _timing(driver, known)
        if isinstance(driver, SimulatedDevice):
            driver.held, driver.lockstep = False, True
        rounds(driver, known, _SETTLE)
        rest = rounds(driver, known, REST)
        pushed = [_bench_axis(driver, known, axis) for axis in range(3)] if known.force_max > 0.0 else []
    finally:
        driver.write(np.zeros(6))
        driver.close()
    axes = tuple(_axis(i, rest, pushed) for i in range(3))
    return Bench(name, rate, interval, fresh, axes, any(trace.stopped for trace, _ in pushed))  # type: ignore[arg-type]


def alternating(axis: int, halves: tuple[float, ...], repeats: int) -> tuple[float, list[tuple[float, Array]]]:
    """Duration [s], and (time, force (3,) [N] from then on) of a push that moves to and fro along an axis.

    The first and the last push of each half period [s] are half as long, so that the motion returns to its start.
    """
    t, plan = 0.0, []
    direction = np.eye(3)[axis]
    for half in halves:
        for k in range(2 * repeats + 1):
            plan.append((t, (1.0 - 2.0 * (k % 2)) * PUSH * direction))
            t += 0.5 * half if k in (0, 2 * repeats) else half
        plan.append((t, np.zeros(3)))
        t += half
    return t, plan


def _push(driver: Driver, known: Facts, axis: int, halves: tuple[float, ...], repeats: int) -> Trace:
    duration, plan = alternating(axis, halves, repeats)
    starts = np.array([start for start, _ in plan])

    def force(t: float, moved: Array) -> Array:
        return plan[max(0, int(np.searchsorted(starts, t + 1e-9, side="right")) - 1)][1]

    return rounds(driver, known, duration, force)


def _bench_axis(driver: Driver, known: Facts, axis: int) -> tuple[Trace, AxisFit | None]:
    """Push along an axis, with half periods that use a share of the workspace, and fit the model."""
    pilot = _push(driver, known, axis, (_PILOT,), 1)
    stroke = float(np.ptp(pilot.p[:, axis]))
    if stroke < _STUCK:
        return pilot, None
    middle = float(np.clip(_PILOT * np.sqrt(_STROKE * known.workspace[axis] / stroke), *_HALF))
    rounds(driver, known, 0.2)
    trace = _push(driver, known, axis, tuple(middle * x for x in _SPREAD), _REPEATS)
    return trace, fit_axis(trace.t, trace.p[:, axis], trace.F[:, axis], _WIDTH * middle * _SPREAD[0])


def _axis(i: int, rest: Trace, pushed: list[tuple[Trace, AxisFit | None]]) -> AxisBench:
    readings = np.concatenate([rest.p[:, i], *(trace.p[:, i] for trace, _ in pushed)])
    step = resolution(readings)
    trace, fit = pushed[i] if pushed else (rest, None)
    return AxisBench("xyz"[i], noise(rest.t, rest.p[:, i], step), step or None, fit, float(np.ptp(trace.p[:, i])))


def _timing(driver: Driver, known: Facts) -> tuple[float, float, float]:
    """Rounds per second, 99th percentile of the interval [us], share of new readings; in real time, at zero force."""
    zero, n = np.zeros(6), max(50, round(0.5 * known.rate))
    times, last, new = np.zeros(n), None, 0
    due = time.monotonic()
    for k in range(n):
        reading = driver.read()
        driver.write(zero)
        times[k] = time.monotonic()
        X = np.asarray(reading[0] if isinstance(reading, tuple) else reading, dtype=np.float64)
        new += last is None or not np.array_equal(X, last)
        last = X
        due += 1.0 / known.rate
        time.sleep(max(0.0, due - time.monotonic()))
    gaps = np.diff(times)
    return float((n - 1) / gaps.sum()), 1e6 * float(np.percentile(gaps, 99)), new / n
