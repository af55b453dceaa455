"""Full dynamics of an arm from moving recordings: physically consistent links, friction, rotors and springs.

    tau_drive = A^T (M(q) a + C(q, v) v + G(q)) + terms(q, v, a) . theta,     q = A q_drive

is linear in the links' inertial parameters pi and in theta. Both sides are filtered by the same zero-phase filter. The
estimate of pi and theta is the maximum of the posterior: the noise level is estimated from the residual, the prior is
broad and centred on the arm's model file, and every link must be physically consistent (inertia.py). `drives.py` lists
the terms.

The relative RMS of a joint is rms(filter(tau) - filter(prediction)) / rms(filter(tau)), both low-passed at `cutoff`
without phase lag. It is the measure of Wang, Gondokaryono, Munawar and Fischer (2019); PUBLISHED holds their figures
for the da Vinci arms. Their data do not state the cutoff they used.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from palpate.arm import Arm
from palpate.arm.drives import At, DriveTrain, drive_train
from palpate.arm.dynamics import CUTOFF, Dynamics
from palpate.arm.identify.inertia import Problem, pseudo_inertia, solve
from palpate.arm.identify.motion import RecordedMotion, lowpass, motion
from palpate.arm.identify.recordings import check_joints, read_moving
from palpate.base.arrays import Array
from palpate.base.errors import RecordingError

MISFIT = 2.0  # residual over the noise of the torque from which on the arm has another form
SPREAD = 3.0  # prior standard deviation of a link from its first guess, in the metric of inertia.py
ROUNDS = 3  # iterations of weighting each joint by the RMS of its residual
KNOWN = 1.3  # a parameter is known if a prior twice as wide widens its deviation by less than this factor

#: Relative RMS per drive on the validation trajectory, as published with their recordings (Wang et al., IROS 2019).
PUBLISHED = {
    "mtm": (0.077, 0.149, 0.170, 0.223, 0.280, 0.234, 0.340),
    "psm": (0.093, 0.178, 0.191, 0.134, 0.239, 0.213, 0.264),
}


def relative_rms(d: Dynamics, m: RecordedMotion, *cutoffs: float) -> Array:
    """Relative RMS (m,) of the prediction, defined in the module; (c, m) if c cutoffs [Hz] are given."""
    error, rows = m.tau - d.torque(m.q, m.v, m.a), []
    for cutoff in cutoffs or (d.cutoff,):
        residual, measured = (lowpass(x, cutoff, m.rate)[m.kept] for x in (error, m.tau))
        rows.append(np.sqrt((residual**2).mean(axis=0) / (measured**2).mean(axis=0)))
    return np.array(rows) if cutoffs else rows[0]


def read_motion(path: str, arm: Arm, rate: float = 200.0, at: At = "drives") -> RecordedMotion:
    """Read a moving recording of this arm, in drive or joint coordinates (`at`).

    Raises:
        RecordingError: wrong columns, NaN, wrong units, another arm, too short, or a drive that does not move. The
            message names the file.
    """
    train = drive_train(arm, at)
    recording = read_moving(path, train.coupling.shape[1], rate)
    check_joints(recording.q @ train.coupling.T, arm, path, margin=0.2)
    span = np.ptp(recording.q, axis=0)
    still = [str(j + 1) for j in np.flatnonzero(span < 1e-6)]
    if still:
        raise RecordingError(
            f"drive {', '.join(still)} does not move", where=path, why="its position is constant from end to end",
            mend="excite every joint at once, over most of its range and at several speeds; parameters of a joint "
            "at rest cannot be identified: " + ", ".join(t.name for t in train.terms if t.name.split("_")[-1] in still),
        )  # fmt: skip
    m = motion(recording)
    _check_rates(m, path)
    return m


def identify(motions: Sequence[RecordedMotion], arm: Arm, cutoff: float = CUTOFF, at: At = "drives") -> Dynamics:
    """The most probable dynamics of `arm`, given motions in drive or joint coordinates (`at`).

    Raises:
        RecordingError: no motion is given, or the torque of a drive is zero in all recordings.
    """
    if not motions:
        raise RecordingError("no recording given", mend="name at least one CSV file")
    train = drive_train(arm, at)
    blocks = [_regressor(m, arm, train, cutoff) for m in motions]
    tau = np.concatenate([tau for _, tau in blocks])
    W = np.concatenate([W for W, _ in blocks])
    size = np.sqrt((tau**2).mean(axis=0))
    if not (size > 0).all():
        raise RecordingError(
            f"drive {int(np.argmin(size)) + 1} has no torque in any recording", where=motions[0].file,
            why="its torque column is zero", mend="record the efforts of all drives",
        )  # fmt: skip
    pi0 = arm.inertial_parameters
    columns = W[:, :, len(pi0) :]
    effect = np.sqrt(((columns / size[:, None]) ** 2).mean(axis=0)).max(axis=0)
    deviation = np.array([term.share for term in train.terms]) / np.maximum(effect, 1e-12)
    positive = np.array([term.positive for term in train.terms])
    # A residual below `cutoff` [Hz] has 2 cutoff independent values per second. Motions repeat: only half are counted.
    share = cutoff * _STRIDE / motions[0].rate
    noise = 0.1 * size
    for _ in range(ROUNDS):
        R = (W / noise[:, None]).reshape(-1, W.shape[2]) * np.sqrt(share)
        y = (tau / noise).reshape(-1) * np.sqrt(share)
        x, std, wider = solve(Problem(R, y, pi0, SPREAD, deviation, positive))
        noise = np.sqrt(((tau - W @ x) ** 2).mean(axis=0))
    n = len(pi0)
    dynamics = Dynamics(arm, x[:n], x[n:], at, cutoff, tuple(m.file for m in motions))
    dynamics.rank, dynamics.condition = _rank(R[:, :n])
    dynamics.deviation = std[n:]
    dynamics.misfit = noise / _noise_below(motions, cutoff)
    dynamics.unknown = tuple(t.name for t, s in zip(train.terms, wider[n:] / std[n:], strict=True) if s > KNOWN)
    return dynamics


_STRIDE = 4  # every fourth row is fitted: the filtered signals hold no more information


def _regressor(m: RecordedMotion, arm: Arm, train: DriveTrain, cutoff: float) -> tuple[Array, Array]:
    """Filtered regressor (k, m, p) and torque (k, m)."""
    s = train.state(m.q, m.v, m.a)
    links = np.array([train.coupling.T @ arm.torque_regressor(*row) for row in zip(s.q, s.v, s.a, strict=True)])
    terms = np.stack([term.column(s) for term in train.terms], axis=2)
    W = np.concatenate([links, terms], axis=2)
    shape = W.shape
    W = lowpass(W.reshape(len(m), -1), cutoff, m.rate).reshape(shape)
    rows = slice(m.kept.start, m.kept.stop, _STRIDE)
    return W[rows], lowpass(m.tau, cutoff, m.rate)[rows]


def _noise_below(motions: Sequence[RecordedMotion], cutoff: float) -> Array:
    """Noise (m,) of the recorded torques below the cutoff, if it is white: from their second differences [N m, N]."""
    rate = motions[0].rate
    passed = lowpass(np.random.default_rng(0).normal(size=4000), cutoff, rate)[500:-500].std()
    differences = np.concatenate([np.diff(m.tau[m.kept], 2, axis=0) for m in motions])
    return np.asarray(np.maximum(passed * np.sqrt(np.square(differences).mean(axis=0) / 6.0), 1e-12))


def _rank(R: Array) -> tuple[int, float]:
    scale = np.sqrt((R**2).mean(axis=0))
    values = np.linalg.svd(R[:, scale > 0] / scale[scale > 0], compute_uv=False)
    rank = int((values > 1e-7 * values[0]).sum())
    return rank, float(values[0] / values[rank - 1])


def _check_rates(m: RecordedMotion, path: str) -> None:
    """Compare recorded velocities with differentiated positions; a mismatch shows wrong units, order or rate."""
    v = np.gradient(m.q, 1.0 / m.rate, axis=0)[m.kept]
    ratio = (m.v[m.kept] * v).sum(axis=0) / (v**2).sum(axis=0)
    worst = int(np.argmax(np.abs(np.log(np.maximum(ratio, 1e-6)))))
    if not 0.7 < ratio[worst] < 1.4:
        raise RecordingError(
            f"the velocity of drive {worst + 1} is {ratio[worst]:.3g} times that of its positions", where=path,
            why=f"positions are differentiated at {m.rate:g} Hz; columns are q, v, tau of all drives",
            mend="give the rate it was recorded at, rad and rad/s, and the columns in this order",
        )  # fmt: skip


def consistency(d: Dynamics) -> Array:
    """(n,) smallest over largest eigenvalue of each link's pseudo-inertia: positive if physically consistent."""
    eigen = [np.linalg.eigvalsh(pseudo_inertia(p)) for p in d.pi.reshape(-1, 10)]
    return np.array([e[0] / e[-1] for e in eigen])
