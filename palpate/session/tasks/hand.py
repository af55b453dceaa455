"""The hand of a simulated operator in a task: it leads the tool by sight, with the error and pace of a person."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.scene.live_targets import PERIOD
from palpate.simulators.operators import Person, person

EVERY = 2
"""The operator acts at every second look of the judge."""
STEP = EVERY * PERIOD
"""Time between two updates [s]."""
SPEED = 0.06
"""Mean speed of the tool of an operator with the median pace [m/s]."""
_PACE = 0.12  # median pace of the operators [s]
_CORRELATION = 0.5  # of the error of sight [s]
_GAIN = 1.5  # of the correction by sight [1/s]
_LAG = 7.0  # of the simulated arm and hand behind a goal [rad/s]
_MOST = 0.02  # largest correction [m]
OPEN, CLOSED = 0.9, 0.0
"""Pinch angles [rad]."""

Acting = Iterator[None]
"""Actions of an operator: each item is one update."""


class Hand:
    """One hand of an operator.

    Args:
        session: session of the pair.
        number: number of the pair.
        seed: seed of the operator's traits and errors.
    """

    def __init__(self, session: Any, number: int, seed: int) -> None:
        self._session, self.number = session, number
        self.person: Person = person(seed % 10000)
        self._rng = np.random.default_rng([seed, number, 6])
        self._scale = float(session.scene.mapping.scale)
        tick = session.latest()
        self.p_WT = np.array(tick["p_WT"])
        self._home = self.p_WT - self._scale * np.array(session.controls.p_hand_offset_W)
        self.goal = self.p_WT.copy()  #: where the tool shall be (3,) [m]
        self._error, self._correction = np.zeros(3), np.zeros(3)
        self._expected, self._rate = self.goal.copy(), np.zeros(3)  # the tool as the hand's motion lets one expect it
        jaws = [c["to"] for c in session.rig.arms.follower.capsules if str(c["link"]).startswith("jaw")]
        self._reach = max((float(np.linalg.norm(to)) for to in jaws), default=0.003)
        self.pinch = OPEN

    @property
    def between(self) -> Array:
        """From T to the middle between the tips of the jaws (3,), in W [m]."""
        return np.asarray(self._R_WT[:, 2] * (self._reach - 0.003))

    @property
    def _R_WT(self) -> Array:
        from palpate.base.arrays.so3 import pose

        return np.asarray(pose(np.zeros(3), self._session.latest()["quat_WT"])[:3, :3])

    @property
    def force(self) -> float:
        """Force on the tool as the hand feels it, with the person's error [N]."""
        felt = float(np.linalg.norm(self._session.latest()["F_H_L"])) / self._force_scale
        return felt * (1.0 + self.person.weber * float(self._rng.normal()))

    @property
    def _force_scale(self) -> float:
        return float(self._session.scene.mapping.force_scale or 1.0)

    def update(self) -> None:
        """Send the goal and the pinch to the hand; to be called once for every update."""
        self.p_WT = np.array(self._session.latest()["p_WT"])
        a = np.exp(-STEP / _CORRELATION)
        rms = self.person.visual_error * np.array([1.0, self.person.depth, 1.0])  # the camera looks along y of W
        self._error = a * self._error + np.sqrt(1.0 - a * a) * rms * self._rng.normal(size=3)
        self._rate = self._rate + STEP * (_LAG**2 * (self.goal - self._expected) - 2.0 * _LAG * self._rate)
        self._expected = self._expected + STEP * self._rate
        lacks = self._expected + self._error - self.p_WT
        self._correction = np.clip(self._correction + _GAIN * STEP * lacks, -_MOST, _MOST)
        wanted = self.goal + self._correction - self._home
        self._session.change(p_hand_offset_W=wanted / self._scale, hand_pinch=self.pinch)

    def move(self, to: Array, speed: float = 1.0) -> Acting:
        """Lead the tool to a place by a minimum-jerk motion; speed relative to the person's pace."""
        start, to = self.goal.copy(), np.asarray(to)
        pace = SPEED * speed * min(max(_PACE / self.person.pace, 0.6), 1.6)
        duration = 0.25 + 1.4 * float(np.linalg.norm(to - start)) / pace
        for k in range(1, max(2, round(duration / STEP)) + 1):
            s = k / max(2, round(duration / STEP))
            self.goal = start + s**3 * (10.0 - 15.0 * s + 6.0 * s * s) * (to - start)
            yield
        yield from self.wait(0.25)  # the tool follows the goal late

    def grip(self, pinch: float, seconds: float = 0.45) -> Acting:
        """Open or close the jaws."""
        self.pinch = pinch
        yield from self.wait(seconds)

    def wait(self, seconds: float) -> Acting:
        """Rest."""
        for _ in range(max(1, round(seconds / STEP))):
            yield
