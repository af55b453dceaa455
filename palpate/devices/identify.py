"""Identifies a device from traces: noise, resolution, mass, friction and delay along one axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.base.errors import DeviceError

LONGEST = 0.06
"""Longest delay that is searched [s]."""
_SLOW = 0.15  # share of the peak velocity below which the sign of the velocity is not trusted
_NOISY = [0, 1, 3]  # columns of the fit that contain the position: mass, damping and stiffness
_REFINED = 3  # steps of Gauss and Newton from the best mixture of two delays
_LOCAL = 9  # readings of a local cubic, whose residual shows steps that lie on no grid


@dataclass(frozen=True)
class Deviations:
    """Standard deviations of the parameters of `AxisFit`, in their units."""

    mass: float
    damping: float
    friction: float
    stiffness: float
    bias: float
    delay: float


@dataclass(frozen=True)
class AxisFit:
    """Model of one axis: ``mass x'' + damping x' + friction sign(x') + stiffness x = F(t - delay) + bias``."""

    mass: float  # [kg]
    damping: float  # [N s/m]
    friction: float  # [N]
    stiffness: float  # restoring force of springs, cables or uncompensated weight [N/m]
    bias: float  # constant force at the start of the motion, for example weight that is not compensated [N]
    delay: float  # from the command to its force [s]
    residual: float  # rms of the force that the model does not explain [N]
    noise: float  # the same that the noise and the steps of the position explain [N]
    windows: int  # number of equations
    deviations: Deviations
    freedom: int  # degrees of freedom of the deviations

    @property
    def misfit(self) -> float:
        """Residual over what the noise explains; much more than 1 for a device of another form."""
        return self.residual / self.noise if self.noise > 0.0 else float("inf")

    @property
    def backwards(self) -> bool:
        """True if the whole 95 % interval of the mass is below 0: the axis moves against its force."""
        return self.mass + self.student * self.deviations.mass < 0.0

    @property
    def student(self) -> float:
        """Student's factor of a 95 % interval."""
        from scipy.special import stdtrit

        return float(stdtrit(self.freedom, 0.975))


def resolution(x: Array) -> float:
    """Step of a quantised signal x (n,), or 0.0 if its values lie on no grid of equal steps.

    The smallest difference of two values is a first guess; the step is then fitted to the whole numbers of steps.
    """
    values = np.unique(x)
    gaps = np.diff(values)
    gaps = gaps[gaps > 1e-6 * max(float(np.ptp(x)), 1e-12)]
    if len(gaps) < 3:
        return 0.0
    step = float(gaps.min())
    for _ in range(3):
        counts = np.round((values - values[0]) / step)
        if counts[-1] > 1e7:
            return 0.0
        step = float(counts @ (values - values[0]) / (counts @ counts))
    error = (values - values[0]) / step - np.round((values - values[0]) / step)
    return step if float(np.abs(error).max()) < 0.1 else 0.0


def noise(t: Array, x: Array, step: float) -> float:
    """Noise of a signal x (n,) at rest, rms: without a linear drift, and without the share of its steps."""
    residual = x - np.polyval(np.polyfit(t - t.mean(), x, 1), t - t.mean())
    return float(np.sqrt(max(float(residual @ residual) / (len(x) - 2) - step**2 / 12.0, 0.0)))


def uneven_steps(rest: Array, x: Array) -> float:
    """Effective step of a signal quantised elsewhere, as by encoders in joints; 0.0 if noise hides or explains it.

    Such a signal repeats exactly while it rests (n,), and its error while it moves, x (m,), is that of a step: rms
    step / sqrt(12) about a smooth motion.
    """
    if len(np.unique(rest)) > max(3, len(rest) // 50) or len(x) < 4 * _LOCAL:
        return 0.0
    windows = np.lib.stride_tricks.sliding_window_view(x, _LOCAL)
    windows = windows[np.ptp(windows, axis=1) > 0.0]
    if len(windows) < _LOCAL:
        return 0.0
    basis = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, _LOCAL), 4))[0]
    rest_of = windows - windows @ basis @ basis.T
    typical = float(np.median(np.square(rest_of).sum(axis=1)))  # not where dry friction changes its sign
    return float(np.sqrt(12.0 * typical / (_LOCAL - 4)))


def fit_axis(t: Array, x: Array, F: Array, width: float = 0.05, error: float = 0.0) -> AxisFit | None:
    """Fit of the model to positions x (n,) [m] and forces F (n,) [N] commanded at times t (n,) [s].

    The equation is multiplied by bumps that vanish with two derivatives at their ends and is integrated by parts
    (modulating functions, Shinbrot 1957), so that x is never differentiated: noise and steps of x average out. Only
    bumps, `width` [s] wide, during which the velocity keeps its sign are used. The delay is the one with the smallest
    residual, between periods too. The deviations come from leaving out one push at a time (jackknife), as bumps
    overlap. `error`: rms error of a position [m]. None if the device hardly moved.

    Raises:
        DeviceError: the residual still falls at the longest delay that is searched.
        LinAlgError: motion and force do not tell the parameters apart.
    """
    dt = float(np.median(np.diff(t)))
    half = max(4, round(0.5 * width / dt))
    phi, phi1, phi2 = _bump(half, dt)
    v = np.convolve(np.gradient(x, dt), np.ones(half) / half, mode="same")
    centres = np.arange(half, len(x) - half - 1, max(1, half // 3))
    rows = centres[:, None] + np.arange(-half, half + 1)
    sign = np.sign(v[centres])
    steady = (np.abs(v[rows]) > _SLOW * np.abs(v).max()).all(axis=1) & (np.sign(v[rows]) == sign[:, None]).all(axis=1)
    centres, rows, sign = centres[steady], rows[steady], sign[steady]
    if len(centres) < 12 or float(np.ptp(x)) < 1e-4:
        return None
    area = dt * phi.sum()
    local = x[rows] - x[centres, None]
    place = dt * (x[rows] - x[0]) @ phi
    A = np.column_stack(
        [dt * local @ phi2, -dt * local @ phi1, sign * area, place, -np.full(len(sign), area)]
    ) / area  # fmt: skip
    b = np.stack([_delayed(F, centres, half, periods) for periods in range(round(LONGEST / dt) + 2)])
    shapes = np.stack([phi2, -phi1, phi]) * dt / area  # of mass, damping and stiffness
    periods, part, found = _best_delay(A, b, shapes)
    if periods + part > len(b) - 2:
        raise DeviceError(
            f"the force follows its command later than {1e3 * LONGEST:g} ms, the longest delay that is searched",
            mend="look for a queue between write() and the motors; check the sign of the force",
        )
    delay, change = periods + part, b[periods + 1] - b[periods]
    for _ in range(_REFINED):
        target = _delayed(F, centres, half, delay)
        change = _delayed(F, centres, half, delay + 0.5) - _delayed(F, centres, half, delay - 0.5)
        step = _unattenuated(np.column_stack([A, -change]), target, error**2 * len(sign) * shapes @ shapes.T)
        delay, found = delay + float(np.clip(step[-1], -1.0, 1.0)), step[:-1]
    target = _delayed(F, centres, half, delay)
    rest = A @ found - target
    J = np.column_stack([A, -change / dt])
    push = np.r_[0, np.cumsum((np.diff(sign) != 0) | (np.diff(centres) > 2 * half))]
    std, freedom = _jackknife(J, rest, push)
    mass, damping, friction, stiffness, bias = found.tolist()
    weight = np.array([mass, damping, stiffness]) @ shapes
    return AxisFit(
        mass, damping, friction, stiffness, bias, delay * dt, float(np.sqrt(np.mean(rest**2))),
        error * float(np.linalg.norm(weight)), len(sign), Deviations(*std.tolist()), freedom,
    )  # fmt: skip


def _delayed(F: Array, centres: NDArray[np.intp], half: int, periods: float) -> Array:
    """Mean of the force (n,), weighted by the bumps, at a delay in periods; it is held from one sample to the next.

    The integral is exact. A sum of samples, with a mixture of two delays between them, took 0.05 % off the mass.
    """
    whole = int(np.floor(periods))
    edges = np.clip((np.arange(-half - 1, half + 2) + periods - whole) / half, -1.0, 1.0)
    area = edges - 4.0 / 3.0 * edges**3 + 6.0 / 5.0 * edges**5 - 4.0 / 7.0 * edges**7 + edges**9 / 9.0
    before = half + 1 + max(whole, 0)
    padded = np.concatenate([np.zeros(before), F, np.zeros(half + 2)])
    held = padded[centres[:, None] + before - whole + np.arange(-half - 1, half + 1)]
    return np.asarray(held @ np.diff(area) / (area[-1] - area[0]))


def _best_delay(A: Array, b: Array, shapes: Array) -> tuple[int, float, Array]:
    """Whole periods, the part of the next one, and the parameters with the smallest residual over its noise.

    Between two delays the force is their mixture, so the residual is linear in the part. The noise of the position
    enters by mass, damping and stiffness: without the division, a delay at which the command is in phase with the
    velocity would pass for dry friction alone, which needs no position.
    """
    Q, R = np.linalg.qr(A)
    rest = b - (b @ Q) @ Q.T
    change = np.diff(rest, axis=0)
    part = -np.einsum("pn,pn->p", rest[:-1], change) / np.maximum(np.einsum("pn,pn->p", change, change), 1e-300)
    part = np.clip(part, 0.0, 1.0)
    targets = b[:-1] + part[:, None] * np.diff(b, axis=0)
    found = np.linalg.solve(R, (targets @ Q).T).T
    noise = np.maximum(np.square(found[:, _NOISY] @ shapes).sum(axis=1), 1e-300)
    cost = np.square(rest[:-1] + part[:, None] * change).sum(axis=1) / noise
    best = int(np.argmin(cost))
    return best, float(part[best]), found[best]


def _unattenuated(A: Array, b: Array, noise: Array) -> Array:
    """Least squares with noise in the columns of mass, damping and stiffness, whose sums of squares `noise` (3, 3) are.

    Plain least squares takes the noise for motion, so mass and damping come out too small (errors in variables;
    Fuller, Measurement Error Models, 1987).

    Raises:
        LinAlgError: the columns do not tell the parameters apart.
    """
    size = np.linalg.norm(A, axis=0)
    if not (size > 0.0).all():
        raise np.linalg.LinAlgError("no force while the device moved")
    H = A.T @ A
    H[np.ix_(_NOISY, _NOISY)] -= noise
    return np.asarray(np.linalg.solve(H / np.outer(size, size), A.T @ b / size) / size)


def _jackknife(J: Array, rest: Array, group: Array) -> tuple[Array, int]:
    """Standard deviations of least-squares parameters by leaving out one group of rows at a time, and their freedom."""
    H = np.linalg.inv(J.T @ J)
    moved = []
    for k in range(int(group.max()) + 1):
        rows = group == k
        K = J[rows] @ H
        leverage = np.eye(int(rows.sum())) - K @ J[rows].T
        moved.append(K.T @ np.linalg.lstsq(leverage, rest[rows], rcond=None)[0])
    n = len(moved)
    out = np.array(moved)
    variance = (n - 1) / n * np.square(out - out.mean(axis=0)).sum(axis=0)
    return np.sqrt(variance), max(n - J.shape[1], 1)


def _bump(half: int, dt: float) -> tuple[Array, Array, Array]:
    """The bump (1 - s^2)^4 over 2 half + 1 samples, and its first two derivatives by time."""
    s = np.linspace(-1.0, 1.0, 2 * half + 1)
    w = half * dt
    u = 1.0 - s**2
    return u**4, -8.0 * s * u**3 / w, (-8.0 * u**3 + 48.0 * s**2 * u**2) / w**2
