"""What hangs on an arm, from its drives' torques: the momentum observer on the identified dynamics.

The observer's torque of the loaded recording, less that of unloaded recordings of the same motion (a tare: what the
model leaves unexplained is the same in both), is that of a body of mass m,

    r_loaded - r_unloaded = filter(m J^T (g - a)) + drift,

filtered as the observer filters, with drift a constant, dry friction and a cable per joint and tare. Row by row the
tare is trusted as far as the unloaded recordings agree there; differences have heavy tails (a cable that catches),
hence Cauchy's weights. The interval is that of leaving out one sixth of the time after the other (a jackknife over
blocks: what catches stays so for seconds, rows do not repeat the experiment), and of one tare against another. How the
body hangs must be known: with gravity alone, mass and lever are one product.
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
from palpate.identify.motion import Motion, lowpass

BANDWIDTH = 5.0  # of the observer on recordings [Hz]
G = np.array([0.0, 0.0, -9.81])  # in the arm's base [m/s^2]
_SAME = 5e-3  # two recordings are of one motion when their joints differ by less, rms [rad, m]
_STRIDE = 4
_REPEATS = 5e-3  # what two recordings of one motion differ by where nothing catches [N m]
_OFF = 0.03  # load times distance from the bar's pivot, one standard deviation [kg m]
_DRIFT = 0.1  # of each part of the drift, one standard deviation [N m, N m/rad]
_BLOCKS = 6  # of the time, left out one after the other
_TUNING = 2.385  # of Cauchy's weights: 95 % efficient when nothing catches (Holland and Welsch, 1977)


@dataclass(frozen=True)
class Hang:
    """How a load hangs on a PSM: on a bar of its parallelogram, which moves without turning.

    The bar's pivot turns with the pitch joint, p_pivot in the axes of the pitch link; along the yaw axis and across it
    the load may sit anywhere on the bar.
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
    deviation: float  # one standard deviation [kg]
    explained: tuple[float, float]  # share of the tared torque's variance, yaw and pitch
    hang: Hang
    t: Array  # (k,) [s]
    tared: Array  # (k, 2) torque of yaw and pitch less the mean tare and its drift [N m]
    fitted: Array  # (k, 2) that of the load [N m]

    @property
    def interval(self) -> tuple[float, float]:
        """95 % [kg], Student's with as many degrees of freedom as blocks less one."""
        reach = float(stats.t.ppf(0.975, _BLOCKS - 1)) * self.deviation
        return self.mass - reach, self.mass + reach


def external_torque(d: Dynamics, m: Motion, bandwidth: float = BANDWIDTH) -> Array:
    """r (k, n) of the momentum observer along a motion: joint torque of the environment on the arm [N m, N]."""
    s = d.train.state(m.q, m.v, m.a)
    to_joints = np.linalg.pinv(d.train.coupling.T)  # (n, m)
    observer = _core.MomentumObserver(d.links, drive_inertia(d), bandwidth)
    return np.asarray(observer.run(s.q, s.v, (m.tau - d.terms(s, leave_out="rotor_")) @ to_joints.T, m.rate))


def estimate_load(d: Dynamics, loaded: Motion, unloaded: Sequence[Motion], hang: Hang | None = None) -> Load:
    """The load of one PSM recording, given at least two unloaded recordings of the same motion.

    Raises:
        RecordingError: fewer than two, or another motion.
    """
    hang = hang or Hang()
    _require_tares(loaded, unloaded)
    rows = slice(loaded.kept.start + round(loaded.rate), loaded.kept.stop, _STRIDE)

    def smooth(x: Array) -> Array:
        return np.asarray(lowpass(x, d.cutoff, loaded.rate)[rows])

    r = [smooth(external_torque(d, m)[:, :2]) for m in (loaded, *unloaded)]
    body, drift = _body(d, loaded, hang, smooth), _drift(d, loaded, smooth)
    share = 0.5 * d.cutoff * _STRIDE / loaded.rate  # of a row in an independent observation
    trust = 1.0 / (_REPEATS**2 + np.var(r[1:], axis=0, ddof=1) * 2.0)
    whole = _Tared(body, drift, [r[0] - x for x in r[1:]], trust, share)
    x = whole.fit()
    time = np.arange(len(body)) * _BLOCKS // len(body)
    parts = np.array([whole.only(time != b).fit()[0] for b in range(_BLOCKS)])
    tares = np.array([_Tared(body, drift, [r[0] - one], trust, share).fit()[0] for one in r[1:]])
    variance = (_BLOCKS - 1) / _BLOCKS * ((parts - parts.mean()) ** 2).sum() + tares.var(ddof=1) / len(tares)
    fitted, tared = body @ x[:3], whole.without_drift(x)
    left = np.median(np.abs(tared - fitted), axis=0) / np.median(np.abs(tared - np.median(tared, axis=0)), axis=0)
    explained = (float(1.0 - left[0] ** 2), float(1.0 - left[1] ** 2))
    t = np.arange(len(loaded))[rows] / loaded.rate
    return Load(float(x[0]), float(np.sqrt(variance)), explained, hang, t, tared, fitted)


def _require_tares(loaded: Motion, unloaded: Sequence[Motion]) -> None:
    if len(unloaded) < 2:
        raise RecordingError(
            f"{len(unloaded)} unloaded recording of the motion", where=loaded.file,
            why="how far two of them differ tells what an estimate is worth", mend="record the motion twice without it",
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
    """Body and drift, linear in x = (m, m times its place on the bar (2), drift of each tare (6))."""

    body: Array  # (k, 2, 3)
    drift: Array  # (k, 2, 6)
    tared: list[Array]  # (k, 2) per tare
    trust: Array  # (k, 2) of a row
    share: float

    def only(self, rows: NDArray[np.bool_]) -> _Tared:
        """Some of the rows."""
        return _Tared(self.body[rows], self.drift[rows], [y[rows] for y in self.tared], self.trust[rows], self.share)

    def without_drift(self, x: Array) -> Array:
        """(k, 2), mean over the tares."""
        drifts = x[3:].reshape(len(self.tared), -1)
        return np.asarray(np.mean([y - self.drift @ x for y, x in zip(self.tared, drifts, strict=True)], axis=0))

    def fit(self) -> Array:
        """x, most probable under Cauchy's likelihood, by reweighing."""
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


def _body(d: Dynamics, m: Motion, hang: Hang, smooth: Callable[[Array], Array]) -> Array:
    """(k, 2, 3): observed torque of 1 kg at the pivot, and of 1 kg m along and across the bar."""
    bar, pivot, none = _Bar(d, m), np.array([*hang.p_pivot, 0.0]), np.zeros(3)
    places = ((none, pivot), (np.eye(3)[0], none), (np.eye(3)[1], none))
    parts = [bar.torque(p_yaw, p_pitch) for p_yaw, p_pitch in places]
    return np.stack([smooth(_observed(part, m.rate)) for part in parts], axis=2)


class _Bar:
    """Yaw and pitch along a motion, for what rides on the parallelogram."""

    def __init__(self, d: Dynamics, m: Motion) -> None:
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
    """A torque as the momentum observer tells it: a first-order filter, discrete as the observer is."""
    k = 2.0 * np.pi * BANDWIDTH / rate
    half = 0.5 * k / (1.0 + k)  # r' = (r + k (tau + tau')/2) / (1 + k)
    return np.asarray(signal.lfilter([half, half], [1.0, -1.0 / (1.0 + k)], torque, axis=0))


def _drift(d: Dynamics, m: Motion, smooth: Callable[[Array], Array]) -> Array:
    """(k, 2, 6): constant, dry friction and cable of yaw, then of pitch."""
    s = d.train.state(m.q, m.v, m.a)
    columns = {t.name: t.column(s) for t in d.train.terms if t.name in ("coulomb_1", "coulomb_2")}
    parts = []
    for j in range(2):
        for f in (np.ones(len(m)), columns[f"coulomb_{j + 1}"][:, j], m.q[:, j] - m.q[:, j].mean()):
            part = np.zeros((len(m), 2))
            part[:, j] = f
            parts.append(smooth(part))
    return np.stack(parts, axis=2)
