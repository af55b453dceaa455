"""Soak of `palpate.Haptics`: random hands at several rates, with irregular and wrong input, judged at every step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.scene import Scene
from palpate.session import Haptics

RATES = (500.0, 1000.0, 2000.0, 4000.0)
"""Rates of the loops [Hz]."""
LAWS = ("indexed", "scaled", "rate", "drift")
"""Laws of the mapping, one for each rate."""
_WRONG = 0.002  # share of steps with wrong input [-]
_DOWN = 0.06  # way down to the objects in the first second [m]
_SIZE = 0.08  # workspace of the pretended device [m]


@dataclass(frozen=True)
class DeviceSoak:
    """Counts of a soak. Everything but steps, wrong, pressed and seconds should be zero."""

    seconds: float  # of each loop's own time
    steps: int
    wrong: int  # steps with invalid input
    pressed: int  # steps with a force
    not_finite: int  # wrenches with NaN or infinity
    above_cap: int  # forces above the cap
    above_rate_cap: int  # forces that rose faster than the rate cap
    force_on_wrong_input: int  # forces although a number of the input was invalid

    @property
    def bad(self) -> int:
        """Number of steps with a wrong answer."""
        return self.not_finite + self.above_cap + self.above_rate_cap + self.force_on_wrong_input


def run(seconds: float, seed: int, progress: Callable[[float], None] | None = None) -> DeviceSoak:
    """Step a loop of each rate for `seconds` of its own time.

    Args:
        seconds: time of each loop [s].
        seed: seed of the motions.
        progress: called with the rate before each loop [Hz].
    """
    counts = np.zeros(7, dtype=np.int64)
    for law, rate in zip(LAWS, RATES, strict=True):
        if progress is not None:
            progress(rate)
        counts += _loop(law, rate, seconds, np.random.default_rng([seed, int(rate)]))
    return DeviceSoak(seconds, *(int(count) for count in counts))


def judge(wrench: Array, before: float, valid: bool, dt: float, cap: float, rate_cap: float) -> tuple[bool, ...]:
    """Whether a wrench is not finite, above the cap, rose too fast since `before` [N], or answers invalid input."""
    force = float(np.linalg.norm(wrench[:3]))
    finite = bool(np.isfinite(wrench).all())
    rose = force - before > rate_cap * dt * (1 + 1e-9) + 1e-12
    return (not finite, force > cap * (1 + 1e-9), rose, not valid and bool(wrench.any()))


def _loop(law: str, rate: float, seconds: float, rng: np.random.Generator) -> np.ndarray:
    scene = _scene(law)
    cap, rate_cap, counts = scene.stability.force_cap, scene.stability.rate_cap, np.zeros(7, dtype=np.int64)
    amplitude, phase = rng.uniform(0.01, 0.04, (3, 3)), rng.uniform(0.0, 6.0, (3, 3))
    frequency = rng.uniform(0.1, 1.0, (3, 3))
    with Haptics(scene, rate=rate) as haptics:
        t, before, offset, X = 0.0, 0.0, np.zeros(3), np.eye(4)
        while t < seconds:
            dt = float(rng.choice([0.6, 1.0, 1.4, 60.0], p=[0.3, 0.4, 0.2995, 0.0005])) / rate
            t += dt
            if rng.random() < 0.0002:
                offset = rng.uniform(-0.02, 0.02, 3)  # the hand jumps
            X[:3, 3] = (amplitude * np.sin(2 * np.pi * frequency * t + phase)).sum(axis=0) + offset
            X[2, 3] -= _DOWN * min(1.0, t)
            valid = rng.random() >= _WRONG
            buttons = int(t % 3.0 > 2.8)
            wrench = haptics.step(t, X if valid else _spoilt(X, rng), buttons=buttons)
            most = max(dt, 2.0 / rate)  # the cycle advances by its own period at least
            wrong = judge(wrench, before, valid, most, cap, rate_cap)
            counts += np.array([1, not valid, wrench.any(), *wrong], dtype=np.int64)
            before = float(np.linalg.norm(wrench[:3]))
    return counts


def _spoilt(X: Array, rng: np.random.Generator) -> Array:
    """The pose with a number that is no number, of another size, or mirrored."""
    X = X.copy()
    row, column = rng.integers(0, 3), rng.integers(0, 4)
    X[row, column] = rng.choice([np.nan, np.inf, -np.inf, 1e9])
    return X if rng.random() < 0.7 else np.diag([-1.0, 1.0, 1.0, 1.0])


def _scene(law: str) -> Scene:
    """A ball and a plate below the tool."""
    ball = {"name": "ball", "sphere": {"radius": 0.03}, "stiffness": 400.0, "damping": 1.0, "friction": 0.3}
    box = {"name": "plate", "box": {"size": [0.2, 0.2, 0.02]}, "stiffness": 300.0, "pose": {"xyz": [0, 0, -0.03]}}
    mapping = {"law": law, "workspace": [_SIZE] * 3, "centre": [0.0, 0.0, 0.0]}
    return Scene.model_validate({"objects": [ball, box], "arms": {"leader": {"driver": "loop"}}, "mapping": mapping})
