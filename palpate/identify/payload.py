"""Estimate of a payload from the drive torques, by the momentum observer on the identified dynamics.

The tare is the observer's torque in unloaded recordings of the same motion: it holds the same model error as the loaded
recording. The difference of the two torques is that of a body of mass m,

    r_loaded - r_unloaded = filter(m J^T (g - a)) + drift,

where filter is that of the observer, and drift is a constant, dry friction and a cable stiffness per joint and tare.
Each row is weighted by how well the unloaded recordings agree there. The differences have heavy tails (cables stick and
slip), hence Cauchy weights. The confidence interval combines a jackknife over six blocks of time (a stuck cable stays
stuck for seconds, so rows are not independent) with the variance between tares. The attachment of the body must be
known: gravity alone determines only the product of mass and lever arm.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal, stats

from palpate import _core
from palpate.arm.dynamics import Dynamics
from palpate.arm.observer import drive_inertia
from palpate.arrays import Array
from palpate.errors import RecordingError
from palpate.identify.motion import RecordedMotion, lowpass

BANDWIDTH = 5.0  # bandwidth of the observer on recordings [Hz]
G = np.array([0.0, 0.0, -9.81])  # gravity in the arm's base frame [m/s^2]
_SAME = 5e-3  # largest RMS difference of joint positions between recordings of the same motion [rad, m]
_STRIDE = 4
_REPEATS = 5e-3  # torque repeatability between recordings of one motion without stick-slip [N m]
_OFF = 0.03  # prior standard deviation of load times distance from the bar's pivot [kg m]
_DRIFT = 0.1  # prior standard deviation of each part of the drift [N m, N m/rad]
_BLOCKS = 6  # blocks of time of the jackknife
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
    explained: tuple[float, float]  # explained fraction of the tared torque's variance (robust), yaw and pitch
    hang: Hang
    t: Array  # (k,) [s]
    tared: Array  # (k, 2) torque of yaw and pitch minus the mean tare and its drift [N m]
    fitted: Array  # (k, 2) torque of the fitted load [N m]
    by_tare: tuple[float, ...]  # mass with each unloaded recording alone as the tare [kg]

    @property
    def interval(self) -> tuple[float, float]:
        """95 % confidence interval [kg], from Student's t with `_BLOCKS` - 1 degrees of freedom."""
        reach = float(stats.t.ppf(0.975, _BLOCKS - 1)) * self.deviation
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
    body, drift = _body(d, loaded, hang, smooth), _drift(d, loaded, smooth)
    share = 0.5 * d.cutoff * _STRIDE / loaded.rate  # independent observations per row
    trust = 1.0 / (_REPEATS**2 + np.var(r[1:], axis=0, ddof=1) * 2.0)
    whole = _Tared(body, drift, [r[0] - x for x in r[1:]], trust, share)
    x = whole.fit()
    time = np.arange(len(body)) * _BLOCKS // len(body)
    parts = np.array([whole.only(time != b).fit()[0] for b in range(_BLOCKS)])
    tares = np.array([_Tared(body, drift, [r[0] - one], trust, share).fit()[0] for one in r[1:]])
    variance = (_BLOCKS - 1) / _BLOCKS * ((parts - parts.mean()) ** 2).sum() + tares.var(ddof=1) / len(tares)
    fitted, tared = body @ x[:3], whole.without_drift(x)
    ratio = np.median(np.abs(tared - fitted), axis=0) / np.median(np.abs(tared - np.median(tared, axis=0)), axis=0)
    explained = (float(1.0 - ratio[0] ** 2), float(1.0 - ratio[1] ** 2))
    t = np.arange(len(loaded))[rows] / loaded.rate
    return Load(float(x[0]), float(np.sqrt(variance)), explained, hang, t, tared, fitted, tuple(map(float, tares)))


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
    """Linear model of the tared torques; x = (m, m times position on the bar (2), drift of each tare (6))."""

    body: Array  # (k, 2, 3)
    drift: Array  # (k, 2, 6)
    tared: list[Array]  # (k, 2) per tare [N m]
    trust: Array  # (k, 2) weight: inverse variance [1/(N m)^2]
    share: float  # independent observations per row

    def only(self, rows: NDArray[np.bool_]) -> _Tared:
        """The model restricted to some rows."""
        return _Tared(self.body[rows], self.drift[rows], [y[rows] for y in self.tared], self.trust[rows], self.share)

    def without_drift(self, x: Array) -> Array:
        """Tared torque (k, 2) minus its drift, mean over the tares [N m]."""
        drifts = x[3:].reshape(len(self.tared), -1)
        return np.asarray(np.mean([y - self.drift @ x for y, x in zip(self.tared, drifts, strict=True)], axis=0))

    def fit(self) -> Array:
        """The most probable x under a Cauchy likelihood, by iterative reweighting."""
        u = len(self.tared)
        drifts = [np.concatenate([self.drift if i == k else 0.0 * self.drift for i in range(u)], axis=2)
                  for k in range(u)]  # fmt: skip
        A = np.concatenate([np.concatenate([self.body, part], axis=2).reshape(-1, 3 + 6 * u) for part in drifts])
        y, root = np.concatenate([y.ravel() for y in self.tared]), np.sqrt(np.tile(self.trust.ravel(), u))
        A, y = A * root[:, None], y * root
        prior = np.concatenate([[0.0], np.full(2, _OFF**-2.0), np.full(6 * u, _DRIFT**-2.0)]) * u / self.share
        w, size = np.ones(len(y)), float(np.sqrt((y**2).mean()))
        for _ in range(40):
            Aw = A * w[:, None]
            x = np.linalg.solve(A.T @ Aw + np.diag(prior) * size**2, Aw.T @ y)
            e = y - A @ x
            size = 1.4826 * float(np.median(np.abs(e)))
            w = 1.0 / (1.0 + (e / (_TUNING * size)) ** 2)
        return np.asarray(x)


def _body(d: Dynamics, m: RecordedMotion, hang: Hang, smooth: Callable[[Array], Array]) -> Array:
    """(k, 2, 3): observed torque of 1 kg at the pivot, and of 1 kg m along and across the bar."""
    bar, pivot, zero = _Bar(d, m), np.array([*hang.p_pivot, 0.0]), np.zeros(3)
    places = ((zero, pivot), (np.eye(3)[0], zero), (np.eye(3)[1], zero))
    parts = [bar.torque(p_yaw, p_pitch) for p_yaw, p_pitch in places]
    return np.stack([smooth(_observed(part, m.rate)) for part in parts], axis=2)


class _Bar:
    """Kinematics of yaw and pitch along a motion, for a body on the parallelogram."""

    def __init__(self, d: Dynamics, m: RecordedMotion) -> None:
        links = list(d.arm.link_names)
        poses = np.array([[d.arm.link_poses_array(q)[links.index(n)] for n in ("yaw_link", "pitch_link")]
                          for q in m.q[:, :6]])  # fmt: skip
        self.R1, self.R2 = poses[:, 0, :3, :3], poses[:, 1, :3, :3]
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
