"""The simulated operator: sees with delay and error, feels with delay and threshold, moves with noise.

Every 20 ms (`STEP`), in the tool's space; the hand moves 1/scale as far. x is where the tool was seen `visual_delay`
ago, p the point of the path that is nearest to it, a the path's direction there, n the direction that presses:

    v = c W / pace a  +  visual_gain (p - x) without its part along a (and n)        path: steering law, crossover model
      + 3/s (F_wanted - F_sensed) / K_expected n                                     where there is something to press
      + scale yields (F_hand - threshold) / k_hand                                   gives way to a lasting force
    hand speed = v / scale (1 + noise) + unrest          tremor and the hand's spring, damper and mass: the simulation

c slows down as the error that is seen fills the passage's half width. F_sensed is felt (Weber, `touch_delay`), shown
(as a bar beside the picture: a tenth of error, `visual_delay`), or judged by the tissue's look (one bias a trial).
A path that is drawn into the picture is seen with half the error: an assumption, not a finding.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeVar

import numpy as np
from scipy.signal import lfilter

from palpate.arrays import Array
from palpate.operators.cohort import Person
from palpate.operators.errand import Aim

_T = TypeVar("_T")

STEP = 0.020
"""Between two looks [s]."""
LONGEST = 30.0
"""Of a trial [s]."""

WANDER = 0.5
"""Correlation time of where the tool is seen [s]."""
UNEVEN = 0.15
"""Correlation time of the motor noise [s]."""
DRAWN = 0.5
"""Error of sight with the path drawn into the picture, per error without."""
BAR = 0.10
"""rms of a force that is shown as a bar, per force."""
PRESS_RATE = 3.0
"""Speed at which a force that is wrong is put right [1/s]."""
GENTLE = 0.03
"""Fastest that something is pressed or let go [m/s]."""
SWIFT = 0.03
"""Fastest that the tool is led along a path, however wide: care, not the steering law, sets the speed then [m/s]."""
MUSCLE = 0.08
"""Lag of the muscles, of the first order (McRuer and Jex 1967: 0.1 s and less) [s]."""


@dataclass(frozen=True)
class Senses:
    """What the console gives to an operator beside the plain picture."""

    force: Literal["looks", "shown", "felt"] = "looks"
    """how the tool's force is known: by the tissue's look, by a bar in the picture, by the hand."""
    drawn: bool = False
    """the path is drawn into the picture."""


class Operator:
    """One person in one trial. Everything random comes from the seed."""

    def __init__(self, person: Person, senses: Senses, seed: int) -> None:
        self.person, self.senses = person, senses
        rng = np.random.default_rng(seed)
        n = round(LONGEST / STEP) + 1
        sharp = DRAWN if senses.drawn else 1.0
        rms = person.visual_error * sharp * np.array([1.0, person.depth, 1.0])  # the camera looks along y of W
        self._unseen = rms * _wandering(rng, n, WANDER)
        self._uneven = _wandering(rng, n, UNEVEN)
        self._unrest = person.unrest * _wandering(rng, n, UNEVEN)
        self._unsure = _wandering(rng, n, WANDER)[:, 0]
        self._bias = float(np.exp(person.sight_of_force * rng.normal()))
        self._seen: list[Array] = []
        self._press: list[float] = []
        self._felt: list[Array] = []
        self._v, self._speed = np.zeros(3), 0.0
        self.k = 0  # looks so far

    def lead(self, p_WT: Array, F_T: float, F_hand_W: Array, aim: Aim, scale: float) -> Array:
        """Looks, feels, and says how fast the hand is to move until the next look.

        Args:
            p_WT: (3,) tool [m].
            F_T: how hard the tool presses what it touches [N].
            F_hand_W: (3,) what the device applies to the hand [N].
            aim: what is wanted where the tool was seen.
            scale: tool motion per hand motion.

        Returns:
            (3,) speed of the hand in W [m/s].
        """
        who = self.person
        self._seen.append(np.array(p_WT))
        self._press.append(F_T)
        self._felt.append(np.array(F_hand_W))
        v = self._along(aim) + self._across(aim)
        if aim.press > 0.0:
            v = v + self._pressing(aim)
        v = v / scale + self._giving_way(aim)
        size = float(np.linalg.norm(v))
        v = v + who.noise * size * self._uneven[self.k] + self._unrest[self.k]
        self._v = self._v + (1.0 - np.exp(-STEP / MUSCLE)) * (v - self._v)
        self.k += 1
        return self._v

    @property
    def preview(self) -> float:
        """How far one looks ahead along the path: as far as the tool goes within one's own delays [m]."""
        return self._speed * (self.person.visual_delay + MUSCLE)

    @property
    def x(self) -> Array | None:
        """Where the tool is seen now (3,) [m]: `visual_delay` late, with error; None before the first look."""
        late = _ago(self._seen, self.person.visual_delay)
        return None if late is None else np.asarray(late + self._unseen[self.k])

    def _along(self, aim: Aim) -> Array:
        error = float(np.linalg.norm(aim.error))
        care = max(0.2, 1.0 - error / (0.5 * aim.width))
        self._speed = min(care * aim.width / self.person.pace, aim.ahead / 0.3, SWIFT)
        return self._speed * aim.along

    def _across(self, aim: Aim) -> Array:
        return self.person.visual_gain * aim.error

    def _pressing(self, aim: Aim) -> Array:
        who = self.person
        wanted = aim.press * (1.0 if self.senses.force == "felt" else who.haste)
        v = PRESS_RATE * (wanted - self._sensed()) / aim.stiffness
        return float(np.clip(v, -GENTLE, GENTLE)) * aim.into

    def _sensed(self) -> float:
        """The tool's force as this person knows it [N]."""
        who, unsure = self.person, 1.0 + float(self._unsure[self.k])
        if self.senses.force == "felt":
            F = _ago(self._press, who.touch_delay) or 0.0
            return F * (1.0 + who.weber * (unsure - 1.0)) if who.threshold < F else 0.0
        F = _ago(self._press, who.visual_delay) or 0.0
        if self.senses.force == "shown":
            return F * (1.0 + BAR * (unsure - 1.0))
        return F * self._bias

    def _giving_way(self, aim: Aim) -> Array:
        """To what is felt across the path and does not come from pressing: there one goes where it is easy."""
        who = self.person
        late = _ago(self._felt, who.touch_delay)
        if late is None:
            return np.zeros(3)
        F = late - aim.along * float(aim.along @ late)
        if aim.press > 0.0:
            F = F - aim.into * float(aim.into @ F)
        size = float(np.linalg.norm(F))
        if size <= who.threshold:
            return np.zeros(3)
        return who.yields / who.hand.stiffness * (1.0 - who.threshold / size) * F


def _wandering(rng: np.random.Generator, n: int, correlation: float) -> Array:
    """(n, 3) of rms 1 that forgets itself within the correlation time [s]."""
    a = float(np.exp(-STEP / correlation))
    white = rng.normal(0.0, np.sqrt(1.0 - a * a), (n, 3))
    white[0] = rng.normal(0.0, 1.0, 3)
    return np.asarray(lfilter([1.0], [1.0, -a], white, axis=0))


def _ago(values: list[_T], delay: float) -> _T | None:
    """What was so long ago [s]; the first one before that."""
    i = len(values) - 1 - round(delay / STEP)
    return values[i] if i >= 0 else (values[0] if values else None)
