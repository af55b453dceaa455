"""The work of ``palpate study force``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict

import numpy as np

from palpate import _core
from palpate.arm import Arm
from palpate.base.arrays import Array

if TYPE_CHECKING:
    from palpate.arm.dynamics import Dynamics
    from palpate.arm.identify.payload import Load


class Score(TypedDict):
    """Errors of the estimated force over a motion."""

    nrmse: float
    nrmse_axis: list[float]
    error_rms_N: float
    force_max_N: float


class StudyResult(Score):
    """Result of the simulation. The keys are the documented contract of ``--json``."""

    simulated: bool
    samples_Hz: float
    torque_noise: float


class Weight(TypedDict):
    """The weight on the recorded arm."""

    mass_kg: float
    deviation_kg: float
    degrees_of_freedom: float
    interval_kg: list[float]
    true_kg: float
    error: float
    explained: list[float]
    misfit: float
    assumed: str
    mass_by_tare_kg: list[float]
    mass_by_filter_kg: dict[str, float]


OTHER_CUTOFFS = (1.0, 4.0)  # cutoffs of variants of the filter [Hz]
WEIGHT = 0.105  # true mass of the weight on the recorded arm [kg]
SERVO = 1e-4  # period of the simulated drives [s]
SAMPLES, TICKS = 200.0, 1000.0  # rates of a recording and of the cycle [Hz]
LEARN, PRESS = 30.0, 12.0  # durations of the motions [s]
NOISE = 0.005  # rms noise of a measured drive torque, relative to the drive's limit [-]
FLOOR = (600.0, 2.0)  # stiffness and damping of the floor [N/m, N s/m]
DEEP = 0.03  # depth of the floor below the middle of the motion [m]
PUSH = 2.0  # largest lateral force per axis [N]
#: Middle and amplitude of the simulated arm's joint motion [rad, m].
MIDDLE = np.array([0.0, 0.0, 0.12, 0.0, 0.0, 0.0])
SWING = np.array([0.45, 0.45, 0.06, 0.8, 0.5, 0.5])


def words(load: Load | None, recordings: Path) -> list[str]:
    """The result of the weight as lines of text."""
    if load is None:
        return [f"no recordings in {recordings}: the study of the weight is skipped"]
    low, high = load.interval
    error = 100 * (load.mass / WEIGHT - 1.0)
    return [
        f"weight on the recorded PSM: {1e3 * load.mass:.0f} g, 95 % {1e3 * low:.0f} to {1e3 * high:.0f} g; "
        f"on the scale {1e3 * WEIGHT:.0f} g, {error:+.0f} %",
        f"it is taken to hang {load.hang.words}",
        *(f"warning: {doubt}" for doubt in load.doubts),
    ]


def in_words(found: StudyResult) -> str:
    """The result of the simulated arm as a line of text."""
    axes = ", ".join(f"{axis} {100 * x:.1f}" for axis, x in zip("xyz", found["nrmse_axis"], strict=True))
    return (
        f"simulated PSM: NRMSE {100 * found['nrmse']:.1f} % (by axis {axes} %) over {PRESS:g} s of a motion it was "
        f"not identified from, force to {found['force_max_N']:.1f} N"
    )


def weight(folder: Path, cutoff: float | None = None) -> Load:
    """Estimate the weight on the recorded PSM; the dynamics are identified from recordings without the weight.

    ``cutoff``: of the filter [Hz]; None: that of `palpate calibrate dynamics`.
    """
    from palpate.arm.dynamics import CUTOFF
    from palpate.arm.identify.dynamics import identify, read_motion
    from palpate.arm.identify.payload import estimate_load

    arm = Arm.psm()
    one, two, again, loaded = (
        read_motion(str(folder / f"psm__{name}_results.csv"), arm)
        for name in ("one", "two", "one_no_weight", "one_105_grams_parallel")
    )
    return estimate_load(identify([one, two, again], arm, cutoff or CUTOFF), loaded, [one, again])


def weight_json(load: Load, filtered: dict[float, Load]) -> Weight:
    """The weight as JSON values; ``filtered``: estimates by the cutoff of another filter [Hz]."""
    return {
        "mass_kg": load.mass,
        "deviation_kg": load.deviation,
        "degrees_of_freedom": load.freedom,
        "interval_kg": list(load.interval),
        "true_kg": WEIGHT,
        "error": load.mass / WEIGHT - 1.0,
        "explained": list(load.explained),
        "misfit": load.misfit,
        "assumed": load.hang.words,
        "mass_by_tare_kg": list(load.by_tare),
        "mass_by_filter_kg": {f"{cutoff:g}": one.mass for cutoff, one in filtered.items()},
    }


@dataclass(frozen=True)
class Trace:
    """True and estimated force on the simulated tool."""

    t: Array  # (k,) [s]
    truth: Array  # (k, 3) true F_T_B [N]
    estimate: Array  # (k, 3) estimated F_T_B [N]


def simulated() -> tuple[StudyResult, Trace]:
    """Identify a simulated PSM from one motion, estimate forces in another. Fixed seeds."""
    arm = Arm.psm()
    trace = press(arm, identified(arm))
    return {"simulated": True, "samples_Hz": SAMPLES, "torque_noise": NOISE, **score(trace)}, trace


def identified(arm: Arm) -> Dynamics:
    """The dynamics of the simulated arm, from its encoders and drive torques in free motion."""
    from palpate.arm.identify.dynamics import identify
    from palpate.arm.identify.motion import motion
    from palpate.arm.identify.recordings import Moving

    follower, path, noise = _follower(arm), _path(1), _noise(arm, 1)
    rows = []
    for k in range(round(LEARN * SAMPLES)):
        follower.command(path(k / SAMPLES))
        follower.step(SERVO, round(1.0 / SAMPLES / SERVO))
        rows.append(np.concatenate([follower.q, follower.v, follower.tau + noise()]))
    q, v, tau = np.split(np.array(rows), 3, axis=1)
    return identify([motion(Moving(q, v, tau, SAMPLES, "simulated PSM"))], arm, at="joints")


def press(arm: Arm, model: Dynamics) -> Trace:
    """Another motion, in which the tool touches a floor and is pushed from the sides."""
    from palpate.arm.observer import estimate_options

    follower, path, noise, push = _follower(arm), _path(2), _noise(arm, 2), _waves(3, 2)
    estimate = _core.Estimate(arm, estimate_options(model))
    follower.reset(path(0.0))
    height = float(arm.fk(MIDDLE)[2, 3]) - DEEP
    F, estimated, truth, last = np.zeros(6), [], [], height
    for k in range(round(PRESS * TICKS)):
        follower.command(path(k / TICKS))
        follower.step(SERVO, round(1.0 / TICKS / SERVO), F)
        z = float(arm.fk(follower.q)[2, 3])
        estimated.append(estimate.step(k / TICKS, follower.q, follower.v, follower.tau + noise()))
        truth.append(F[:3].copy())
        depth = height - z
        F[:2] = PUSH * push(k / TICKS)
        F[2] = max(FLOOR[0] * depth - FLOOR[1] * (z - last) * TICKS, 0.0) if depth > 0.0 else 0.0
        last = z
    return Trace(np.arange(len(estimated)) / TICKS, np.array(truth), np.array(estimated))


def score(trace: Trace) -> Score:
    """NRMSE: rms of the error vector over the largest force; of an axis: rms of its error over its force's range."""
    settled = slice(round(TICKS), None)
    truth, error = trace.truth[settled], (trace.estimate - trace.truth)[settled]
    rms, largest = float(np.sqrt((error**2).sum(axis=1).mean())), float(np.linalg.norm(truth, axis=1).max())
    by_axis = np.sqrt((error**2).mean(axis=0)) / np.ptp(truth, axis=0)
    return {"nrmse": rms / largest, "nrmse_axis": by_axis.tolist(), "error_rms_N": rms, "force_max_N": largest}


def _follower(arm: Arm) -> _core.Follower:
    options = arm.follower_options()
    options.driven = True
    follower = _core.Follower(arm, options)
    follower.reset(MIDDLE)
    return follower


def _noise(arm: Arm, seed: int) -> Callable[[], Array]:
    rng, size = np.random.default_rng(seed), NOISE * arm.tau_max
    return lambda: size * rng.normal(size=arm.n)


def _path(seed: int) -> Callable[[float], Array]:
    """Joint positions as a function of time, starting at rest in the middle."""
    wave = _waves(seed, 6)
    return lambda t: np.asarray(MIDDLE + SWING * wave(t) * min(t, 1.0))


def _waves(seed: int, n: int) -> Callable[[float], Array]:
    """n sums of five harmonics of about 0.1 Hz, with magnitudes up to 1."""
    rng = np.random.default_rng(seed)
    frequency = 0.1 * rng.permutation(np.arange(1, 9))[:5][:, None] * rng.uniform(0.9, 1.1, (5, n))
    phase = rng.uniform(0.0, 2.0 * np.pi, (5, n))
    share = rng.dirichlet(np.ones(5), n).T
    return lambda t: np.asarray((share * np.sin(2.0 * np.pi * frequency * t + phase)).sum(axis=0))
