"""Estimate of a payload from the drive torques, by the momentum observer on the identified dynamics.

The tare is the observer's torque in unloaded recordings of the same motion: it holds the same model error as the loaded
recording. The difference of the two torques is that of a body of mass m,

    r_loaded - r_unloaded = filter(m J^T (g - a)) + drift,

where filter is that of the observer, and drift is a constant, dry friction and a cable stiffness per joint and tare.
Each row is weighted by how well the unloaded recordings agree there. The differences have heavy tails (cables stick and
slip), hence Cauchy weights. The torque is quadratic in the place of the body on its bar, so it is linearised about the
place found. The confidence interval combines a jackknife over six blocks of time (a stuck cable stays stuck for
seconds, so rows are not independent) with the variance between recordings, of which the loaded one has its own. The
attachment of the body must be known: gravity alone determines only the product of mass and lever arm.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import signal, stats

from palpate import _core
from palpate.arm.dynamics import Dynamics
from palpate.arm.identify.motion import RecordedMotion, lowpass
from palpate.arm.observer import drive_inertia
from palpate.base.arrays import Array
from palpate.base.errors import RecordingError

BANDWIDTH = 5.0  # bandwidth of the observer on recordings [Hz]
G = np.array([0.0, 0.0, -9.81])  # gravity in the arm's base frame [m/s^2]
_SAME = 5e-3  # largest RMS difference of joint positions between recordings of the same motion [rad, m]
_STRIDE = 4
_REPEATS = 5e-3  # torque repeatability between recordings of one motion without stick-slip [N m]
_OFF = 0.03  # prior standard deviation of load times distance from the bar's pivot [kg m]
_DRIFT = 0.1  # prior standard deviation of each part of the drift [N m, N m/rad]
_ROUNDS, _STILL = 10, 1e-4  # linearisations about the load's place, and the change that ends them [m]
_LIGHT = 0.02  # lighter loads do not show their place [kg]
_LONGEST = 0.3  # largest distance of a load from its bar's pivot [m]
_BLOCKS = 6  # blocks of time of the jackknife
_MISFIT = 2.7  # F(12, 12) at 95 %: six blocks of yaw and pitch
_TUNING = 2.385  # constant of the Cauchy weights: 95 % efficient for normal errors (Holland and Welsch, 1977)


@dataclass(frozen=True)
class Hang:
    """Attachment of a load to a PSM: on a bar of its parallelogram, which does not rotate with pitch.

    The bar's pivot moves with the pitch joint: it is at p_pivot [m] in the axes of the pitch link. The position of the
    load on the bar is free.
    """

    p_pivot: tuple[float, float] = (0.04009, 0.14454)
    words: str = (
        "on the lower of the parallelogram's parallel bars, which turns with yaw and is shifted by pitch, its pivot "
        "(40.1, 144.5) mm from the pitch axis (the published geometry of Wang et al.); where on the bar is free"
    )


@dataclass(frozen=True)
class Load:
    """An estimated load."""

    mass: float  # [kg]
    deviation: float  # standard deviation [kg]
    freedom: float  # degrees of freedom of the deviation
    place: tuple[float, float]  # of the load along and across its bar, from the bar's pivot [m]
    explained: tuple[float, float]  # of the variance that drift leaves, in unfitted blocks, yaw and pitch
    hang: Hang
    t: Array  # (k,) [s]
    tared: Array  # (k, 2) torque of yaw and pitch minus the mean tare and its drift [N m]
    fitted: Array  # (k, 2) torque of the fitted load [N m]
    by_tare: tuple[float, ...]  # mass with each unloaded recording alone as the tare [kg]
    misfit: float  # variance that the load leaves over that between unloaded recordings, each of one recording

    @property
    def doubts(self) -> tuple[str, ...]:
        """Why the interval may be wrong: the load leaves more than recordings differ by, so it hangs otherwise."""
        if self.misfit < _MISFIT:
            return ()
        return (
            f"the load leaves {self.misfit:.1f} times the variance by which unloaded recordings differ (below "
            f"{_MISFIT:g} in 99 % of right ones): it hangs otherwise, or something else has changed; do not believe "
            "the interval",
        )

    @property
    def interval(self) -> tuple[float, float]:
        """95 % confidence interval [kg], from Student's t."""
        reach = float(stats.t.ppf(0.975, self.freedom)) * self.deviation
        return self.mass - reach, self.mass + reach


def external_torque(d: Dynamics, m: RecordedMotion, bandwidth: float = BANDWIDTH) -> Array:
    """Joint torque (k, n) of the environment on the arm along a motion, by the momentum observer [N m, N]."""
    s = d.train.state(m.q, m.v, m.a)
    to_joints = np.linalg.pinv(d.train.coupling.T)  # (n, m)
    observer = _core.MomentumObserver(d.links, drive_inertia(d), bandwidth)
    return np.asarray(observer.run(s.q, s.v, (m.tau - d.terms(s, leave_out="rotor_")) @ to_joints.T, m.rate))


def estimate_load(
    d: Dynamics, loaded: RecordedMotion, unloaded: Sequence[RecordedMotion], hang: Hang | None = None
) -> Load:
    """Estimate the load of one PSM recording, given at least two unloaded recordings of the same motion.

    Raises:
        RecordingError: fewer than two unloaded recordings, or recordings of another motion.
    """
    hang = hang or Hang()
    _require_tares(loaded, unloaded)
    rows = slice(loaded.kept.start + round(loaded.rate), loaded.kept.stop, _STRIDE)

    def smooth(x: Array) -> Array:
        return np.asarray(lowpass(x, d.cutoff, loaded.rate)[rows])

    r = [smooth(external_torque(d, m)[:, :2]) for m in (loaded, *unloaded)]
    bar, drift = _Bar(d, loaded), _drift(d, loaded, smooth)
    share = 0.5 * d.cutoff * _STRIDE / loaded.rate  # independent observations per row
    trust = 1.0 / (_REPEATS**2 + np.var(r[1:], axis=0, ddof=1) * 2.0)
    place = np.zeros(2)
    for _ in range(_ROUNDS):
        whole = _Tared(_body(bar, loaded, hang, place, smooth), drift, [r[0] - x for x in r[1:]], trust, share, place)
        x = whole.fit()
        moved = _place(x, place) - place
        if np.abs(moved).max() < _STILL:
            break
        place = place + moved
    time = np.arange(len(drift)) * _BLOCKS // len(drift)
    blocks = [whole.only(time != b).fit() for b in range(_BLOCKS)]
    parts = np.array([one[0] for one in blocks])
    tares = np.array([replace(whole, tared=[r[0] - one]).fit()[0] for one in r[1:]])
    variance, freedom = _variance(parts, tares)
    fitted, tared = whole.body @ x[:3], whole.without_drift(x)
    t = np.arange(len(loaded))[rows] / loaded.rate
    return Load(
        float(x[0]), float(np.sqrt(variance)), freedom, (float(place[0]), float(place[1])),
        _explained(whole, blocks, time), hang, t, tared, fitted, tuple(map(float, tares)),
        _misfit(tared - fitted, r[1:], drift),
    )  # fmt: skip


def _explained(whole: _Tared, blocks: list[Array], time: NDArray[np.int64]) -> tuple[float, float]:
    """Robust share of the variance of yaw and pitch that the load explains in blocks that it was not fitted to.

    Fitted to the same rows, the load's three parameters would explain up to a quarter of recordings without any load.
    """
    left, alone = [], []
    for b, x in enumerate(blocks):
        rest, own = whole.only(time != b), whole.only(time == b)
        left.append(own.without_drift(x) - own.body @ x[:3])
        alone.append(own.without_drift(np.concatenate([np.zeros(3), rest.fit(without_load=True)])))
    ratio = np.median(np.abs(np.concatenate(left)), axis=0) / np.median(np.abs(np.concatenate(alone)), axis=0)
    return float(1.0 - ratio[0] ** 2), float(1.0 - ratio[1] ** 2)


def _misfit(residual: Array, tares: list[Array], drift: Array) -> float:
    """Variance of one recording by what the load leaves (k, 2), over that by the unloaded ones less their drift.

    Recordings that differ by friction, noise and drift alone give 1; the mean of the ratios of yaw and pitch.
    """
    u, mean, between = len(tares), np.mean(tares, axis=0), np.zeros(2)
    columns = drift.reshape(-1, drift.shape[2])
    for tare in tares:
        apart = (tare - mean).ravel()
        left = apart - columns @ np.linalg.lstsq(columns, apart, rcond=None)[0]
        between += np.square(left.reshape(-1, 2)).mean(axis=0) / (u - 1)
    return float(np.mean(np.square(residual).mean(axis=0) / (1.0 + 1.0 / u) / np.maximum(between, 1e-18)))


def _place(x: Array, about: Array) -> Array:
    """Place (2,) of the load on its bar [m]; near the pivot where the mass is too small to show it."""
    mass = float(x[0])
    return np.asarray(np.clip(mass * (x[1:3] + mass * about) / (mass**2 + _LIGHT**2), -_LONGEST, _LONGEST))


def _variance(parts: Array, tares: Array) -> tuple[float, float]:
    """Variance of the mass and its degrees of freedom (Satterthwaite, Biometrics Bulletin 2(6), 1946).

    Args:
        parts: masses without one block of time each [kg].
        tares: masses with one unloaded recording each [kg]; the loaded recording varies as an unloaded one does.
    """
    n, u = len(parts), len(tares)
    within = (n - 1) / n * float(np.square(parts - parts.mean()).sum())
    between = (1.0 + 1.0 / u) * float(tares.var(ddof=1))
    freedom = (within + between) ** 2 / max(within**2 / (n - 1) + between**2 / (u - 1), 1e-300)
    return within + between, float(max(freedom, 1.0))


def _require_tares(loaded: RecordedMotion, unloaded: Sequence[RecordedMotion]) -> None:
    if len(unloaded) < 2:
        raise RecordingError(
            f"{len(unloaded)} unloaded recording of the motion", where=loaded.file,
            why="at least two are needed: their difference gives the uncertainty of the estimate",
            mend="record the motion twice without the load",
        )  # fmt: skip
    for other in unloaded:
        n = min(len(loaded), len(other))
        apart = float(np.sqrt(((loaded.q[:n, :3] - other.q[:n, :3]) ** 2).mean()))
        if len(other) != len(loaded) or apart > _SAME:
            raise RecordingError(
                f"its joints are {apart:.2g} rad away from those of {loaded.file}, rms, its rows {len(other)} "
                f"for {len(loaded)}", where=other.file,
                why="a tare needs the same motion", mend="repeat the motion without the load",
            )  # fmt: skip


@dataclass(frozen=True)
class _Tared:
    """Linear model of the tared torques about a place of the load on its bar.

    x = (m, m times the load's position from that place (2), drift of each tare (6)).
    """

    body: Array  # (k, 2, 3)
    drift: Array  # (k, 2, 6)
    tared: list[Array]  # (k, 2) per tare [N m]
    trust: Array  # (k, 2) weight: inverse variance [1/(N m)^2]
    share: float  # independent observations per row
    place: Array  # (2,) [m]

    def only(self, rows: NDArray[np.bool_]) -> _Tared:
        """The model restricted to some rows."""
        return replace(
            self, body=self.body[rows], drift=self.drift[rows], tared=[y[rows] for y in self.tared],
            trust=self.trust[rows],
        )  # fmt: skip

    def without_drift(self, x: Array) -> Array:
        """Tared torque (k, 2) minus its drift, mean over the tares [N m]."""
        drifts = x[3:].reshape(len(self.tared), -1)
        return np.asarray(np.mean([y - self.drift @ x for y, x in zip(self.tared, drifts, strict=True)], axis=0))

    def fit(self, without_load: bool = False) -> Array:
        """The most probable x, or its drift alone, under a Cauchy likelihood, by iterative reweighting."""
        u = len(self.tared)
        drifts = [np.concatenate([self.drift if i == k else 0.0 * self.drift for i in range(u)], axis=2)
                  for k in range(u)]  # fmt: skip
        A = np.concatenate([np.concatenate([self.body, part], axis=2).reshape(-1, 3 + 6 * u) for part in drifts])
        y, root = np.concatenate([y.ravel() for y in self.tared]), np.sqrt(np.tile(self.trust.ravel(), u))
        A, y = A * root[:, None], y * root
        prior = self._prior()
        if without_load:
            A, prior = A[:, 3:], prior[3:, 3:]
        w, size = np.ones(len(y)), float(np.sqrt((y**2).mean()))
        for _ in range(40):
            Aw = A * w[:, None]
            x = np.linalg.solve(A.T @ Aw + prior * size**2, Aw.T @ y)
            e = y - A @ x
            size = 1.4826 * float(np.median(np.abs(e)))
            w = 1.0 / (1.0 + (e / (_TUNING * size)) ** 2)
        return np.asarray(x)

    def _prior(self) -> Array:
        """Information of x known beforehand; that of the load is about its bar's pivot, not about `place`."""
        u = len(self.tared)
        prior = np.diag(np.concatenate([np.zeros(3), np.full(6 * u, _DRIFT**-2.0)]))
        moments = np.column_stack([self.place, np.eye(2)])
        prior[:3, :3] = moments.T @ moments * _OFF**-2.0
        return np.asarray(prior * u / self.share)


def _body(bar: _Bar, m: RecordedMotion, hang: Hang, place: Array, smooth: Callable[[Array], Array]) -> Array:
    """(k, 2, 3): observed torque of 1 kg at a place on the bar, and its derivatives along and across the bar."""
    pivot, p = np.array([*hang.p_pivot, 0.0]), np.array([*place, 0.0])

    def torque(dx: float = 0.0, dy: float = 0.0) -> Array:
        return bar.torque(p + np.array([dx, dy, 0.0]), pivot)

    h = 0.01  # [m]; central differences of a quadratic are exact
    parts = [torque(), (torque(h) - torque(-h)) / (2.0 * h), (torque(0.0, h) - torque(0.0, -h)) / (2.0 * h)]
    return np.stack([smooth(_observed(part, m.rate)) for part in parts], axis=2)


class _Bar:
    """Kinematics of yaw and pitch along a motion, for a body on the parallelogram."""

    def __init__(self, d: Dynamics, m: RecordedMotion) -> None:
        poses = d.arm.link_poses(m.q[:, :6])
        self.R1, self.R2 = poses["yaw_link"][:, :3, :3], poses["pitch_link"][:, :3, :3]
        self.z1, self.z2 = self.R1[:, :, 2], self.R2[:, :, 2]
        v, a = m.v, m.a
        self.w1 = self.z1 * v[:, :1]
        self.w2 = self.w1 + self.z2 * v[:, 1:2]
        self.alpha1 = self.z1 * a[:, :1]
        self.alpha2 = self.alpha1 + self.z2 * a[:, 1:2] + np.cross(self.w1, self.z2 * v[:, 1:2])

    def torque(self, p_yaw: Array, p_pitch: Array) -> Array:
        """J^T (g - a) (k, 2) of 1 kg at p_yaw in the yaw link's axes plus p_pitch in the pitch link's."""
        x1, x2 = self.R1 @ p_yaw, self.R2 @ p_pitch
        turn1 = np.cross(self.alpha1, x1) + np.cross(self.w1, np.cross(self.w1, x1))
        turn2 = np.cross(self.alpha2, x2) + np.cross(self.w2, np.cross(self.w2, x2))
        f = G - turn1 - turn2
        return np.column_stack([(np.cross(self.z1, x1 + x2) * f).sum(axis=1), (np.cross(self.z2, x2) * f).sum(axis=1)])


def _observed(torque: Array, rate: float) -> Array:
    """A torque after the momentum observer: the same discrete first-order filter."""
    k = 2.0 * np.pi * BANDWIDTH / rate
    half = 0.5 * k / (1.0 + k)  # r' = (r + k (tau + tau')/2) / (1 + k)
    return np.asarray(signal.lfilter([half, half], [1.0, -1.0 / (1.0 + k)], torque, axis=0))


def _drift(d: Dynamics, m: RecordedMotion, smooth: Callable[[Array], Array]) -> Array:
    """Drift columns (k, 2, 6): constant, dry friction and cable stiffness of yaw, then of pitch."""
    s = d.train.state(m.q, m.v, m.a)
    columns = {t.name: t.column(s) for t in d.train.terms if t.name in ("coulomb_1", "coulomb_2")}
    parts = []
    for j in range(2):
        for f in (np.ones(len(m)), columns[f"coulomb_{j + 1}"][:, j], m.q[:, j] - m.q[:, j].mean()):
            part = np.zeros((len(m), 2))
            part[:, j] = f
            parts.append(smooth(part))
    return np.stack(parts, axis=2)
