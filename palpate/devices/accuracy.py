"""How true is the force of a device? It is compared with a known weight, or with a spring of known stiffness.

The handle moves slowly up and down along z under a position servo, once as it is, once with the weight or the spring.
Friction acts against both directions: the servo commands the force ``a + s x + f sign(v)``, and a and s are free of
friction. A weight m adds m g to a, a spring K adds K to s, so that the true force over the commanded one is m g over
the change of a, or K over the change of s.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import DeviceError
from palpate.devices.driver import Driver, Facts, facts
from palpate.devices.simulated import GRAVITY, SimulatedDevice
from palpate.devices.trace import PUSH, Trace, opened, rounds

STROKE, PERIOD, CYCLES = 0.008, 2.0, 4
"""Way from end to end [m], time of a way up and down [s], and their number after the first."""
_K, _I, _B = 250.0, 900.0, 4.0  # of the servo: stiffness [N/m], integral [N/m/s], damping [N s/m]
_STEADY = (0.4, 0.95)  # share of each way that counts: the speed has settled after the reversal
_FILTER = 0.02  # time constant of the velocity [s]
_SETTLING = {"weight": 0.0, "spring": 0.005}
"""Standard deviation of the gain over simulated devices of 0.1 to 0.4 kg with a friction of 0.02 to 0.15 N [-]: after a
reversal the servo still settles, which counts as a slope and not as a weight."""
UNITS = {"weight": "kg", "spring": "N/m"}
"""Units of what the force is compared with."""
_BINS = 8  # of the way, in which forces are compared
_ODD_SHAPE = 0.04  # misfit from which on the result is doubted; devices of `_SETTLING` have up to 0.025 [-]
_ODD = 3.0  # factor by which no force is wrong: the weight or the spring is another one, or is not fastened [-]
_MARGIN = 1.6  # largest force of the servo over the force that it must hold [-]


@dataclass(frozen=True)
class Slow:
    """Force of the servo, ``offset + slope x + friction sign(v)``, of each cycle of a slow motion."""

    offset: Array  # (n,) [N]
    slope: Array  # (n,) [N/m]
    friction: Array  # (n,) [N]
    place: Array  # (k,) middles of k parts of the way [m]
    force: Array  # (n, k) mean force in each, of both directions: free of friction [N]


@dataclass(frozen=True)
class Accuracy:
    """Force on the handle over the commanded force."""

    by: str  # weight or spring
    given: float  # mass [kg] or stiffness [N/m] that was given
    gain: float  # 1: the force is true [-]
    deviation: float  # standard deviation of `gain` [-]
    freedom: float  # degrees of freedom of `deviation`
    friction_N: float  # of the axis, by the two directions
    misfit: float  # rms change of the force that neither a weight nor a spring explains, over the mean change [-]

    @property
    def reach(self) -> float:
        """Half width of the 95 % interval [-]."""
        from scipy.special import stdtrit

        return float(stdtrit(self.freedom, 0.975)) * self.deviation

    def in_words(self) -> str:
        """The result in a sentence."""
        low, high = self.gain - self.reach, self.gain + self.reach
        verdict = "true within the interval" if low <= 1.0 <= high else "too weak" if high < 1.0 else "too strong"
        words = f"{100 * self.gain:.1f} +-{100 * self.reach:.1f} % of what is commanded: {verdict}"
        return "; ".join([words, *self.doubts])

    @property
    def doubts(self) -> tuple[str, ...]:
        """Why the interval does not hold, in words."""
        if self.misfit <= _ODD_SHAPE:
            return ()
        return (f"doubted: the {self.by} does not act everywhere, the change of the force varies along the way by "
                f"{100 * self.misfit:.2g} % rms",)  # fmt: skip


def by_weight(driver: Driver, name: str, mass: float, ready: Callable[[str], None]) -> Accuracy:
    """Accuracy by a weight.

    Args:
        driver: the driver, not yet open; z of its base must be vertical.
        name: its name.
        mass: of the weight [kg].
        ready: asks the user to prepare something, and returns when that is done; called before each motion.

    Raises:
        DeviceError: the weight is not above 0, too heavy or too light for the device, or the driver failed.
    """
    return _compare(
        driver, name, "weight", mass, mass * GRAVITY, f"hang the weight of {1e3 * mass:g} g on the handle", ready
    )


def by_spring(driver: Driver, name: str, stiffness: float, ready: Callable[[str], None]) -> Accuracy:
    """Accuracy by a spring of known stiffness [N/m] along z, between handle and a fixed point; else as `by_weight`."""
    words = f"fasten the spring of {stiffness:g} N/m to the handle, relaxed, along the vertical"
    return _compare(driver, name, "spring", stiffness, 0.5 * STROKE * stiffness, words, ready)


def _compare(
    driver: Driver, name: str, by: str, given: float, force: float, words: str, ready: Callable[[str], None]
) -> Accuracy:
    if not 0.0 < given < np.inf:
        raise DeviceError(f"a {by} of {given:g} {UNITS[by]} is none", mend="give a number above 0")
    known = facts(driver, name)
    most = _MARGIN * force + PUSH
    if known.force_max <= 0.0:
        raise DeviceError(f"device {name} renders no force", mend="there is nothing to compare")
    if not 0.0 < most <= known.force_max:
        what = f"a {by} of {given:g} {UNITS[by]} needs up to {most:.2g} N of {name}"
        raise DeviceError(what, why=f"it may be commanded {known.force_max:g} N", mend=f"take a smaller {by}")
    with opened(driver):
        if isinstance(driver, SimulatedDevice):
            driver.held, driver.lockstep = False, True
            driver.load = driver.attached = 0.0
        ready(f"take everything off the handle, which moves up and down by {1e3 * STROKE:g} mm with up to {most:.2g} N")
        bare = slow(driver, known, min(most, PUSH + 0.5 * most))
        ready(words)
        if isinstance(driver, SimulatedDevice):
            setattr(driver, "load" if by == "weight" else "attached", given)
        loaded = slow(driver, known, most)
    if by == "weight":
        change, expected = loaded.offset - bare.offset, given * GRAVITY
    else:
        change, expected = loaded.slope - bare.slope, given
    mean, error = float(change.mean()), float(np.hypot(_error(loaded, by), _error(bare, by)))
    if not mean > 4.0 * error:
        what = f"the {by} changes the force of the servo by {mean:.2g} +-{error:.1g}: nothing to compare"
        raise DeviceError(what, mend=f"fasten it along z of the base, or take a larger {by}")
    gain = expected / mean
    if not 1.0 / _ODD < gain < _ODD:
        unit = {"weight": "N", "spring": "N/m"}[by]
        what = f"the {by} changes the force of the servo by {mean:.2g} {unit} in place of {expected:.2g} {unit}"
        mend = (
            f"fasten it along z of the base, take all else off the handle, and see that {given:g} {UNITS[by]} is right"
        )
        raise DeviceError(what, mend=mend)
    friction = float(np.concatenate([bare.friction, loaded.friction]).mean())
    deviation = gain * float(np.hypot(error / mean, _SETTLING[by]))
    return Accuracy(by, given, gain, deviation, _freedom(loaded, bare, by), friction, _misfit(loaded, bare))


def _error(found: Slow, by: str) -> float:
    """Standard error of the mean over the cycles."""
    values = found.offset if by == "weight" else found.slope
    return float(np.std(values, ddof=1) / np.sqrt(len(values)))


def _freedom(loaded: Slow, bare: Slow, by: str) -> float:
    """Degrees of freedom of the sum of both squared errors (Welch 1947)."""
    squares = np.square([_error(loaded, by), _error(bare, by)])
    return float((CYCLES - 1) * squares.sum() ** 2 / max(float(squares @ squares), 1e-300))


def _misfit(loaded: Slow, bare: Slow) -> float:
    """Rms of the change of the force over the place, without a straight line, over its mean [-]."""
    change = (loaded.force - bare.force).mean(axis=0)
    line = np.polynomial.Polynomial.fit(loaded.place, change, 1)
    return float(np.sqrt(np.mean(np.square(change - line(loaded.place)))) / np.abs(change).mean())


def slow(driver: Driver, known: Facts, most: float) -> Slow:
    """Move the handle slowly up and down, with at most `most` [N].

    Raises:
        DeviceError: the handle does not follow: somebody holds it, or the force does not suffice.
    """
    servo = _Servo(1.0 / known.rate)
    trace = rounds(driver, known, (CYCLES + 1) * PERIOD, servo, most)
    if trace.stopped:
        raise DeviceError("the handle left a quarter of the workspace", mend="check that the weight is not too heavy")
    return _fit(trace)


class _Servo:
    """A position servo along z, which follows a triangle; the other axes are held where they are."""

    def __init__(self, dt: float) -> None:
        self._dt, self._sum, self._v, self._last = dt, np.zeros(3), np.zeros(3), np.zeros(3)

    def __call__(self, t: float, moved: Array) -> Array:
        self._v = self._v + (moved - self._last - self._v * self._dt) / _FILTER
        self._last = moved.copy()
        error = np.array([0.0, 0.0, wanted(t)]) - moved
        self._sum = np.clip(self._sum + _I * error * self._dt, -20.0, 20.0)
        return np.asarray(_K * error + self._sum - _B * self._v)


def wanted(t: float) -> float:
    """Height of the triangle at a time: it begins in the middle, upwards [m]."""
    share = (t / PERIOD + 0.25) % 1.0
    return STROKE * (2.0 * share - 0.5 if share < 0.5 else 1.5 - 2.0 * share)


def _fit(trace: Trace) -> Slow:
    """Least squares for each cycle after the first."""
    x, F, t = trace.p[:, 2] - trace.p[0, 2], trace.F[:, 2], trace.t
    share = (t / PERIOD + 0.25) % 1.0
    way = (2.0 * share) % 1.0
    up, steady = share < 0.5, (way > _STEADY[0]) & (way < _STEADY[1])
    if np.ptp(x[steady]) < 0.4 * STROKE:
        raise DeviceError(
            "the handle does not follow", mend="let go of it; switch the motors on; take a smaller weight"
        )
    ways = [steady & (up == upwards) & (t >= (k + 0.75) * PERIOD) & (t < (k + 1.75) * PERIOD)
            for k in range(CYCLES) for upwards in (True, False)]  # fmt: skip
    ends = np.quantile(np.array([np.quantile(x[way], [0.01, 0.99]) for way in ways]), [0.0, 1.0], axis=0)
    edges = np.linspace(ends[1, 0], ends[0, 1], _BINS + 1)  # what all ways have in common
    parts = [(x >= low) & (x < high) for low, high in itertools.pairwise(edges)]
    force = np.array([[F[way & part].mean() for part in parts] for way in ways]).reshape(CYCLES, 2, _BINS).mean(axis=1)
    found = []
    for k in range(CYCLES):
        rows = ways[2 * k] | ways[2 * k + 1]
        A = np.column_stack([np.ones(int(rows.sum())), x[rows], np.where(up[rows], 1.0, -1.0)])
        found.append(np.linalg.lstsq(A, F[rows], rcond=None)[0])
    a, s, f = np.array(found).T
    return Slow(a, s, f, 0.5 * (edges[1:] + edges[:-1]), force)
