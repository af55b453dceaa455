"""The simulated operator: sees with delay and error, feels with delay and threshold, and moves with noise.

Every 20 ms (`STEP`) the operator computes a velocity v of the tool; the hand moves 1/scale as far. x is the tool
position seen `visual_delay` ago, p the nearest point of the path, a the tangent there, n the pressing direction:

    v = c W / pace a  +  visual_gain (p - x) without components along a (and n)      path: steering law, crossover model
      + 3/s (F_wanted - F_sensed) / K_expected n                                     if the task is to press
      + scale yields (F_hand - threshold) / k_hand                                   gives way to a lasting force
    hand speed = v / scale (1 + noise) + unrest          tremor and the hand's spring, damper and mass: the simulation

c decreases as the seen error approaches half the width of the passage. F_sensed is felt (Weber, `touch_delay`), shown
as a bar next to the picture (10 % error, `visual_delay`), or judged by the look of the tissue (one bias per trial).
A path drawn into the picture halves the error of sight: this is an assumption, not a finding.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeVar

import numpy as np
from scipy.signal import lfilter

from palpate.base.arrays import Array
from palpate.simulators.operators.cohort import Person
from palpate.simulators.operators.errand import Aim

_T = TypeVar("_T")

STEP = 0.020
"""Time between two updates of the operator [s]."""
MAX_DURATION = 30.0
"""Longest trial [s]."""

SIGHT_CORRELATION = 0.5
"""Correlation time of the error of sight [s]."""
MOTOR_CORRELATION = 0.15
"""Correlation time of the motor noise [s]."""
DRAWN_PATH_ERROR = 0.5
"""Error of sight with the path drawn into the picture, relative to the error without it."""
BAR_ERROR = 0.10
"""rms error of a force shown as a bar, per force."""
PRESS_RATE = 3.0
"""Rate at which a force error is corrected [1/s]."""
MAX_PRESS_SPEED = 0.03
"""Maximum speed of the tool in the pressing direction [m/s]."""
MAX_SPEED = 0.03
"""Maximum speed of the tool along a path: in wide passages, care limits the speed before the steering law [m/s]."""
MUSCLE_LAG = 0.08
"""Time constant of the first-order lag of the muscles (McRuer and Jex 1967: 0.1 s and less) [s]."""


@dataclass(frozen=True)
class Senses:
    """Information that the console gives to an operator in addition to the plain picture."""

    force: Literal["looks", "shown", "felt"] = "looks"
    """Source of the tool's force: the look of the tissue, a bar in the picture, or the hand."""
    drawn: bool = False
    """True if the path is drawn into the picture."""


class Operator:
    """One person in one trial. All random numbers come from the seed."""

    def __init__(self, person: Person, senses: Senses, seed: int) -> None:
        self.person, self.senses = person, senses
        rng = np.random.default_rng(seed)
        n = round(MAX_DURATION / STEP) + 1
        factor = DRAWN_PATH_ERROR if senses.drawn else 1.0
        rms = person.visual_error * factor * np.array([1.0, person.depth, 1.0])  # the camera looks along y of W
        self._sight_error = rms * _coloured_noise(rng, n, SIGHT_CORRELATION)
        self._motor_noise = _coloured_noise(rng, n, MOTOR_CORRELATION)
        self._rest_noise = person.unrest * _coloured_noise(rng, n, MOTOR_CORRELATION)
        self._force_error = _coloured_noise(rng, n, SIGHT_CORRELATION)[:, 0]
        self._bias = float(np.exp(person.sight_of_force * rng.normal()))
        self._seen: list[Array] = []
        self._press: list[float] = []
        self._felt: list[Array] = []
        self._v, self._speed = np.zeros(3), 0.0
        self.k = 0  # number of updates so far

    def lead(self, p_WT: Array, F_T: float, F_hand_W: Array, aim: Aim, scale: float) -> Array:
        """Update the operator; return the velocity of the hand until the next update.

        Args:
            p_WT: (3,) position of the tool [m].
            F_T: force of the tool on the touched surface [N].
            F_hand_W: (3,) force of the device on the hand [N].
            aim: local goal at the seen position of the tool.
            scale: tool motion per hand motion.

        Returns:
            (3,) velocity of the hand in W [m/s].
        """
        person = self.person
        self._seen.append(np.array(p_WT))
        self._press.append(F_T)
        self._felt.append(np.array(F_hand_W))
        v = self._velocity_along(aim) + self._velocity_across(aim)
        if aim.press > 0.0:
            v = v + self._velocity_pressing(aim)
        v = v / scale + self._velocity_yielding(aim)
        size = float(np.linalg.norm(v))
        v = v + person.noise * size * self._motor_noise[self.k] + self._rest_noise[self.k]
        self._v = self._v + (1.0 - np.exp(-STEP / MUSCLE_LAG)) * (v - self._v)
        self.k += 1
        return self._v

    @property
    def preview(self) -> float:
        """Distance that the operator looks ahead: the distance that the tool moves within the operator's delays [m]."""
        return self._speed * (self.person.visual_delay + MUSCLE_LAG)

    @property
    def x(self) -> Array | None:
        """Seen position (3,) of the tool [m], with delay and error; None before the first update."""
        late = _delayed(self._seen, self.person.visual_delay)
        return None if late is None else np.asarray(late + self._sight_error[self.k])

    @property
    def F(self) -> float:
        """Force of the tool as the operator senses it [N]; after the first update."""
        return self._sensed()

    def _velocity_along(self, aim: Aim) -> Array:
        error = float(np.linalg.norm(aim.error))
        care = max(0.2, 1.0 - self.person.care * error / (0.5 * aim.width))
        self._speed = min(care * aim.width / self.person.pace, aim.ahead / 0.3, MAX_SPEED)
        return self._speed * aim.along

    def _velocity_across(self, aim: Aim) -> Array:
        return self.person.visual_gain * aim.error

    def _velocity_pressing(self, aim: Aim) -> Array:
        person = self.person
        force = aim.press * (1.0 if self.senses.force == "felt" else person.haste)
        v = PRESS_RATE * (force - self._sensed()) / aim.stiffness
        return float(np.clip(v, -MAX_PRESS_SPEED, MAX_PRESS_SPEED)) * aim.into

    def _sensed(self) -> float:
        """Force of the tool as the operator senses it [N]."""
        person, error = self.person, 1.0 + float(self._force_error[self.k])
        if self.senses.force == "felt":
            F = _delayed(self._press, person.touch_delay) or 0.0
            return F * (1.0 + person.weber * (error - 1.0)) if person.threshold < F else 0.0
        F = _delayed(self._press, person.visual_delay) or 0.0
        if self.senses.force == "shown":
            return F * (1.0 + BAR_ERROR * (error - 1.0))
        return F * self._bias

    def _velocity_yielding(self, aim: Aim) -> Array:
        """Velocity (3,) that follows a felt force across the path, without the force of pressing [m/s]."""
        person = self.person
        late = _delayed(self._felt, person.touch_delay)
        if late is None:
            return np.zeros(3)
        F = late - aim.along * float(aim.along @ late)
        if aim.press > 0.0:
            F = F - aim.into * float(aim.into @ F)
        size = float(np.linalg.norm(F))
        if size <= person.threshold:
            return np.zeros(3)
        return person.yields / person.hand.stiffness * (1.0 - person.threshold / size) * F


def _coloured_noise(rng: np.random.Generator, n: int, correlation: float) -> Array:
    """First-order coloured noise (n, 3) with rms 1 and the given correlation time [s]."""
    a = float(np.exp(-STEP / correlation))
    white = rng.normal(0.0, np.sqrt(1.0 - a * a), (n, 3))
    white[0] = rng.normal(0.0, 1.0, 3)
    return np.asarray(lfilter([1.0], [1.0, -a], white, axis=0))


def _delayed(values: list[_T], delay: float) -> _T | None:
    """The value `delay` [s] ago; the first value if there was none yet, None if the list is empty."""
    i = len(values) - 1 - round(delay / STEP)
    return values[i] if i >= 0 else (values[0] if values else None)
