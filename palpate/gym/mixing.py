"""The goal of a tool that a policy and a person move: their motions are weighed, not their places."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from palpate.base.arrays import Array, rigid
from palpate.base.errors import PalpateError
from palpate.gym.observation import Observation
from palpate.gym.policy import Policy
from palpate.gym.world import Motion

RAMP = 0.3
"""Time in which the authority passes from one to the other [s]."""
CLOSED, OPEN = 0.2, 0.6
"""Angles of the gripper below which the person has all authority, and above which the policy has it [rad]."""
Authority = Literal["pedal", "gripper"]


@dataclass(frozen=True)
class Hand:
    """State of a person's device."""

    X: Array
    """(4, 4) pose of the handle in the axes of W [m]."""
    gripper: float = 0.0
    """Pinch angle, 0: closed [rad]."""
    pedal: bool = False
    """True while the pedal is pressed."""


@dataclass
class Asked:
    """The newest action of a policy, and what became of it."""

    action: Array = field(default_factory=lambda: np.zeros(6))
    at: float = -np.inf
    """Time of the loop at which it was asked for [s]."""
    count: int = 0
    """Number of good actions."""
    notes: list[str] = field(default_factory=list)
    """What went wrong, in words."""

    def note(self, text: str) -> None:
        """Keep a message once; twenty at most."""
        if text not in self.notes and len(self.notes) < 20:
            self.notes.append(text)


class Mixer:
    """Moves the goal of a tool by the actions of a policy and the motion of a hand.

    Args:
        motion: limits of the motion that the policy can ask for; `reach` and `tilt` hold where no person takes part.
        rate: ticks per second [Hz].
        timeout: age of an action after which the policy moves nothing [s].
        authority: by what a person takes the authority.
        alone: True if no person takes part.

    Raises:
        PalpateError: the authority is neither of them, or the timeout is not positive.
    """

    def __init__(self, motion: Motion, rate: float, timeout: float, authority: Authority, alone: bool = False) -> None:
        if authority not in ("pedal", "gripper"):
            raise PalpateError(f"authority = {authority!r}", mend="name pedal or gripper")
        if not timeout > 0.0:
            raise PalpateError(f"timeout = {timeout:g} s: must be above 0")
        self._most = np.repeat([motion.speed, motion.turn], 3)
        self._reach = np.repeat([motion.reach, motion.tilt], 3)
        self._dt, self._timeout, self._by = 1.0 / rate, timeout, authority
        self.asked = Asked()
        self.share = 1.0 if alone else 0.0
        """Authority of the policy, from 0 to 1."""
        self._X = np.eye(4)
        self._alone = np.zeros(6)  # goal of a policy without a person, as that of an environment
        self._before: Array | None = None
        rigid.log(np.eye(3))  # loads scipy, which would hold up the first motion of a hand

    def answer(self, policy: Policy, seen: Observation, t: float) -> None:
        """Ask a policy for the action of a time [s]; whatever it does wrong becomes a note, and moves nothing."""
        try:
            action = np.asarray(policy(seen), dtype=np.float64).reshape(-1)
        except Exception as error:  # whatever a policy raises must not end the loop
            self.asked.note(f"the policy failed: {type(error).__name__}: {error}")
            return
        if action.shape != (6,) or not np.isfinite(action).all():
            self.asked.note(f"an action is not six finite numbers: {action[:8]}")
            return
        self.asked.action, self.asked.at = np.clip(action, -self._most, self._most), t
        self.asked.count += 1

    def moved(self, t: float, hand: Hand | None) -> Array:
        """The goal (4, 4), moved by policy and person since the last tick, as the authority weighs them.

        It is NaN while the hand's pose is not finite: the watchdog takes the force away, as for any device.
        """
        self.share = self._authority(hand)
        action = self.asked.action
        if t - self.asked.at > self._timeout:
            if self.asked.count:
                self.asked.note(f"the policy was silent for more than {self._timeout:g} s: the goal waits")
            action = np.zeros(6)
        step = self.share * action * self._dt
        if hand is None:
            self._alone = np.clip(self._alone + step, -self._reach, self._reach)
            return rigid.displaced(np.eye(4), self._alone)
        if not np.isfinite(hand.X).all():
            self._before = None
            return np.full((4, 4), np.nan)
        if self._before is not None:
            step = step + (1.0 - self.share) * rigid.displacement(self._before, hand.X)
        self._before = np.array(hand.X)
        self._X = rigid.displaced(self._X, step)
        return self._X

    def _authority(self, hand: Hand | None) -> float:
        """Authority of the policy, which moves towards what the person asks for within `RAMP`."""
        if hand is None:
            return 1.0
        by_gripper = float(np.clip((hand.gripper - CLOSED) / (OPEN - CLOSED), 0.0, 1.0))
        wanted = float(not hand.pedal) if self._by == "pedal" else by_gripper
        most = self._dt / RAMP
        return float(np.clip(wanted, self.share - most, self.share + most))
