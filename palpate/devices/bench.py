"""`palpate device bench`: noise, rate, resolution, friction, mass and delay of a device, and its certificate model."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import DeviceError
from palpate.devices.certificate import DeviceModel
from palpate.devices.driver import Driver, Facts, facts
from palpate.devices.identify import AxisFit, fit_axis, noise, resolution, uneven_steps
from palpate.devices.simulated import SimulatedDevice
from palpate.devices.trace import PUSH, RESTS, Trace, command, moved_at_rest, opened, pose_of, rounds

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
_GAPS = 3.0  # 99th percentile of the time between two readings over its mean from which on they are irregular
_MISFIT, _SMALL = 3.0, 2e-3  # residual over noise, and residual [N], from which on the model is doubted


@dataclass(frozen=True)
class AxisBench:
    """Measurements along one axis of the device's base."""

    axis: str
    noise_m: float  # rms at rest
    resolution_m: float | None  # step of the measured position; None: no steps seen
    uneven: bool  # the steps lie on no grid, as those of encoders in joints: `resolution_m` is the effective step
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

    def limits(self) -> tuple[float, float]:
        """Largest stable stiffness of a wall without damping, and the same at the unsafe end of all intervals [N/m].

        A restoring force of the device adds to the stiffness of the wall, so it is taken from the limit.
        """
        from palpate.devices.certificate import certify

        def limit(model: DeviceModel, reach: float) -> float:
            springs = [f.stiffness + reach * f.student * f.deviations.stiffness for f in self._fits()]
            return max(0.0, certify(model).k_max - max(0.0, *springs))

        light, heavy = self.model(-1), self.model(1)
        return limit(self.model(0), 0.0), min(limit(light, 1.0), limit(heavy, 1.0))

    def model(self, end: int = 1) -> DeviceModel:
        """The certificate's model: mean mass; smallest damping and friction; longest delay, largest step of all axes.

        Args:
            end: 0: the values as measured. 1 or -1: damping, friction and delay at the unsafe end of their 95 %
                intervals, the mass at its upper or lower end.

        Raises:
            DeviceError: the device was not pushed along any axis, so its mass is unknown.
        """
        fits = self._fits()
        reach = abs(end)

        def worst(name: str, sign: int) -> list[float]:
            return [getattr(f, name) + sign * reach * f.student * getattr(f.deviations, name) for f in fits]

        if not fits:
            what = f"device {self.name} did not move, so its mass and friction are unknown"
            raise DeviceError(
                what, mend="switch its motors on, let go of the handle, and check force_max of the driver"
            )
        return DeviceModel(
            mass=max(1e-3, float(np.mean(worst("mass", 1 if end >= 0 else -1)))),
            damping=max(0.0, min(worst("damping", -1))),
            rate=round(self.rate_Hz, 1),
            delay=max(0.0, max(worst("delay", 1))),
            quantum=max((axis.resolution_m or 0.0) for axis in self.axes),
            friction=max(0.0, min(worst("friction", -1))),
        )

    @property
    def irregular(self) -> bool:
        """True if one in a hundred readings came so late that forces acted long after their time."""
        return self.interval_p99_us * self.rate_Hz > 1e6 * _GAPS

    @property
    def pushed(self) -> bool:
        """True if a push moved it: mass, friction and model are known."""
        return bool(self._fits())

    def _fits(self) -> list[AxisFit]:
        return [axis.fit for axis in self.axes if axis.fit is not None]

    def doubts(self) -> tuple[str, ...]:
        """What the model of the axes does not explain, in sentences."""
        found = []
        for axis in self.axes:
            f = axis.fit
            if f is not None and f.misfit > _MISFIT and f.residual > _SMALL:
                found.append(
                    f"{axis.axis}: the model leaves {1e3 * f.residual:.2g} mN rms, {f.misfit:.2g} times what noise and "
                    "steps explain: the device has another form, and the intervals do not cover that"
                )
            if f is not None and abs(f.stiffness) > max(f.student * f.deviations.stiffness, 1.0):
                found.append(f"{axis.axis}: a restoring force of {f.stiffness:.3g} N/m acts on the handle")
            if axis.uneven:
                found.append(
                    f"{axis.axis}: the steps lie on no grid, as those of encoders in joints, and are no noise: the "
                    "stated step is an effective one, and the intervals are too narrow"
                )
        return tuple(found)


def measure(driver: Driver, name: str, before_push: Callable[[], None] = lambda: None) -> Bench:
    """Open a device, measure it at rest, push it with at most `PUSH` along each axis, and close it.

    Nobody should hold the handle, and a quarter of the workspace around it should be free.

    Args:
        driver: the driver, not yet open.
        name: its name.
        before_push: called after the rest of a device that pushes; what it raises ends the measurement.

    Raises:
        DeviceError: the driver is invalid or failed, the handle does not rest, or moves against its force.
    """
    known = facts(driver, name)
    with opened(driver):
        rate, interval, fresh = _timing(driver, known)
        if isinstance(driver, SimulatedDevice):
            driver.held, driver.lockstep = False, True
        rounds(driver, known, _SETTLE)
        rest = rounds(driver, known, REST)
        if known.force_max > 0.0:
            _require_rest(name, rest)
            before_push()
        pushed = [_bench_axis(driver, known, axis) for axis in range(3)] if known.force_max > 0.0 else []
    axes = tuple(_axis(i, rest, pushed) for i in range(3))
    wrong = ", ".join(axis.axis for axis in axes if axis.fit is not None and axis.fit.backwards)
    if wrong:
        mend = f"reverse the sign of this axis in the force, or in the pose and the force; palpate device test {name}"
        raise DeviceError(f"device {name} moves against the force along {wrong}", mend=mend)
    return Bench(name, rate, interval, fresh, axes, any(trace.stopped for trace, _ in pushed))  # type: ignore[arg-type]


def _require_rest(name: str, rest: Trace) -> None:
    moved = moved_at_rest(rest)
    if moved >= RESTS:
        what = f"the handle of {name} moved by {1e3 * moved:.2g} mm in {REST:g} s without a force"
        mend = "let go of it and lay it down; the stand-in moves its own unless it is started with --free"
        raise DeviceError(what, mend=mend)


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


def _bench_axis(driver: Driver, known: Facts, axis: int) -> tuple[Trace, float]:
    """Push along an axis by a share of the workspace: the trace, and the width of the fit's bumps, 0 if it is stuck."""
    pilot = _push(driver, known, axis, (_PILOT,), 1)
    stroke = float(np.ptp(pilot.p[:, axis]))
    if stroke < _STUCK:
        return pilot, 0.0
    middle = float(np.clip(_PILOT * np.sqrt(_STROKE * known.workspace[axis] / stroke), *_HALF))
    rounds(driver, known, 0.2)
    trace = _push(driver, known, axis, tuple(middle * x for x in _SPREAD), _REPEATS)
    return trace, _WIDTH * middle * _SPREAD[0]


def _axis(i: int, rest: Trace, pushed: list[tuple[Trace, float]]) -> AxisBench:
    readings = np.concatenate([rest.p[:, i], *(trace.p[:, i] for trace, _ in pushed)])
    trace, width = pushed[i] if pushed else (rest, 0.0)
    step = resolution(readings)
    uneven = 0.0 if step else uneven_steps(rest.p[:, i], trace.p[:, i])
    still = noise(rest.t, rest.p[:, i], step)
    error = float(np.hypot(still, (step or uneven) / np.sqrt(12.0)))
    try:
        fit = fit_axis(trace.t, trace.p[:, i], trace.F[:, i], width, error) if width else None
    except np.linalg.LinAlgError:
        what = f"the pushes along {'xyz'[i]} do not tell mass, friction and delay apart"
        why = "the handle did not follow the force: somebody held it, or readings and forces were late"
        raise DeviceError(what, why=why, mend="let go of the handle, end other programs, and measure again") from None
    if width and fit is None and _irregular(trace):
        what = f"the readings came up to {1e3 * float(np.diff(trace.t).max()):.2g} ms apart during the pushes"
        raise DeviceError(what, mend="end other programs, or lower the rate of the driver, and measure again")
    return AxisBench("xyz"[i], still, step or uneven or None, uneven > 0.0, fit, float(np.ptp(trace.p[:, i])))


def _irregular(trace: Trace) -> bool:
    gaps = np.diff(trace.t)
    return float(np.percentile(gaps, 99)) > _GAPS * float(trace.t[-1] - trace.t[0]) / len(gaps)


def _timing(driver: Driver, known: Facts) -> tuple[float, float, float]:
    """Rounds per second, 99th percentile of the interval [us], share of new readings; in real time, at zero force."""
    zero, n = np.zeros(6), max(50, round(0.5 * known.rate))
    times, last, new = np.zeros(n), None, 0
    due = time.monotonic()
    for k in range(n):
        X = pose_of(driver)
        command(driver, zero)
        times[k] = time.monotonic()
        new += last is None or not np.array_equal(X, last)
        last = X
        due += 1.0 / known.rate
        time.sleep(max(0.0, due - time.monotonic()))
    gaps = np.diff(times)
    return float((n - 1) / gaps.sum()), 1e6 * float(np.percentile(gaps, 99)), new / n
