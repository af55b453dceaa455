"""Recordings of a known arm in motion, as reference data."""

from pathlib import Path

import numpy as np

from palpate.arm import Arm
from palpate.arm.drives import dahl
from palpate.arm.identify.recordings import Moving

RATE = 200.0


def excitation(seed: int, middle: np.ndarray, swing: np.ndarray, seconds: float = 20.0) -> tuple[np.ndarray, ...]:
    """q, v, a (k, m) [rad, rad/s, rad/s^2] of sums of sines of 0.1 to 0.9 Hz."""
    rng = np.random.default_rng(seed)
    m = len(middle)
    w = 2 * np.pi * rng.uniform(0.1, 0.9, (5, m))
    phase, share = rng.uniform(0, 2 * np.pi, (5, m)), rng.dirichlet(np.ones(5), m).T * swing
    t = np.arange(round(seconds * RATE))[:, None, None] / RATE
    q = middle + (share * np.sin(w * t + phase)).sum(axis=1)
    v = (share * w * np.cos(w * t + phase)).sum(axis=1)
    a = -(share * w**2 * np.sin(w * t + phase)).sum(axis=1)
    return q, v, a


def torques(arm: Arm, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Drive torques (k, m) [N m] of an arm without coupling: links, friction and rotors of its model file."""
    o = arm.leader_options()
    links = np.array([arm.inverse_dynamics(*row) for row in zip(q, v, a, strict=True)])
    dry = np.column_stack([dahl(q[:, j], 0.01) for j in range(arm.n)])
    return links + o.rotor_inertia * a + o.viscous * v + o.coulomb * dry


def six_axis(seed: int, noise: float = 0.0, seconds: float = 20.0) -> tuple[Arm, Moving]:
    """The generic arm and a recording of its motion."""
    arm = Arm.model("six_axis")
    q, v, a = excitation(seed, np.array([0, 0.3, 1.5, 0, 1.2, 0.0]), np.array([1.0, 0.5, 0.5, 1.0, 0.6, 1.0]), seconds)
    tau = torques(arm, q, v, a)
    tau += noise * np.random.default_rng(seed).normal(size=tau.shape) * tau.std(axis=0)
    return arm, Moving(q, v, tau, RATE, f"six_axis {seed}")


def write(recording: Moving, file: Path) -> Path:
    """Write a recording as a CSV file."""
    np.savetxt(file, np.hstack([recording.q, recording.v, recording.tau]), delimiter=",")
    return file
