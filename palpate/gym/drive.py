"""A policy drives the follower of a scene in the haptic loop, alone or with a person; everything is recorded.

Both move the goal of the tool by their own motion since the last tick, and the authority weighs these motions. The goal
is never moved to where one of them is: it cannot jump when the authority changes, whatever the other did meanwhile, as
with a clutch.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

import numpy as np

from palpate.arrays import Array, rigid
from palpate.arrays.checks import vector
from palpate.devices.haptics import Haptics
from palpate.errors import PalpateError
from palpate.gym.observation import PARTS, observe, space_of
from palpate.gym.policy import Policy
from palpate.gym.world import RATE, Motion, for_policies
from palpate.record.ticks import Ticks
from palpate.scene.scene import Scene
from palpate.session.summary import Summary

RAMP = 0.3
"""Time in which the authority passes from one to the other [s]."""


@dataclass(frozen=True)
class Hand:
    """State of a person's device."""

    X: Array
    """(4, 4) pose of the handle in the axes of W [m]."""
    gripper: float = 0.0
    """Pinch angle, 0: closed [rad]."""
    pedal: bool = False
    """True while the pedal is pressed."""


class Person(Protocol):
    """A person with a device."""

    def read(self, t: float) -> Hand:
        """State of the device at a time [s]."""
        ...

    def feel(self, wrench: Array) -> None:
        """Command a wrench (6,) on the hand, in the axes of W [N, N m]."""
        ...


@dataclass(frozen=True)
class Drive:
    """What a drive gave."""

    summary: Summary
    actions: int
    """Number of actions that the policy gave."""
    notes: tuple[str, ...]
    """What went wrong with the policy, in words."""
    authority: Array
    """(n,) authority of the policy at every tick, from 0 to 1."""


@dataclass
class _Asked:
    """The newest action of a policy, and what became of it."""

    action: Array = field(default_factory=lambda: np.zeros(6))
    at: float = -np.inf  # time of the loop at which it was asked for [s]
    count: int = 0
    notes: list[str] = field(default_factory=list)


def drive(
    scene: Scene | dict[str, Any] | str | os.PathLike[str],
    policy: Policy,
    seconds: float,
    *,
    rate: float = 50.0,
    record: str | os.PathLike[str] | None = None,
    observed: Sequence[str] = PARTS,
    motion: Motion | None = None,
    timeout: float = 0.1,
    goal: Sequence[float] = (0.0, 0.0, 0.0),
    person: Person | None = None,
    authority: Literal["pedal", "gripper"] = "pedal",
    realtime: bool = False,
) -> Drive:
    """Let a policy drive the follower; caps, guidance and watchdog of the scene act as for a device, at 1 kHz.

    An action that is not six finite numbers, an exception of the policy, and a policy that is silent for `timeout` stop
    the goal until the next good action; the force stays within its caps all the time.

    Args:
        scene: a scene, its values, its file, or the name of a shipped one.
        policy: from an observation to the velocity of the goal (6,), in W [m/s, rad/s].
        seconds: duration [s].
        rate: actions per second [Hz].
        record: folder for the record; None: nothing is recorded.
        observed: parts of the observation.
        motion: limits of the motion that the policy can ask for; `reach` and `tilt` hold where no person takes part.
        timeout: age of an action after which the goal stops [s].
        goal: place that the observation `goal` shows, in W [m].
        person: a person who shares the authority, and who feels the wrench.
        authority: ``pedal``: the person has the authority while the pedal is pressed; ``gripper``: while the gripper
            is closed below 0.2 rad, and all of it is the policy's above 0.6 rad.
        realtime: True: in real time, with the policy in a thread of its own; False: as fast as the machine can.

    Raises:
        SceneError, MeshError: the scene cannot run. PalpateError: an argument is out of range.
        ValueError: the goal is not three finite numbers.
    """
    if not (0.0 < seconds < np.inf and 0.0 < rate <= RATE and timeout > 0.0):
        what = f"seconds = {seconds:g}, rate = {rate:g}, timeout = {timeout:g}"
        raise PalpateError(what, mend="all are above 0, the seconds finite, and the rate is at most 1000 Hz")
    if authority not in ("pedal", "gripper"):
        raise PalpateError(f"authority = {authority!r}", mend="name pedal or gripper")
    place = vector("goal", goal)[None]
    limits = motion or Motion()
    with Haptics(for_policies(Scene.of(scene)), record, RATE, delay=None if person else 0.0) as haptics:
        joints = haptics.session.rig.arms.follower.n
        space_of(observed, joints)  # refuses unknown parts

        def seen(tick: Ticks, felt: float) -> dict[str, Any]:
            found = observe(observed, joints, tick.reshape(1), np.array([felt]), place)
            return {name: values[0] for name, values in found.items()}

        loop = _Driving(haptics, policy, rate, limits, timeout, person, authority, seen)
        shares = loop.run(round(seconds * RATE), realtime)
        notes = tuple(loop.asked.notes)
        return Drive(haptics.close(), loop.asked.count, notes, shares)


class _Driving:
    """The loop of `drive`."""

    def __init__(
        self, haptics: Haptics, policy: Policy, rate: float, limits: Motion, timeout: float, person: Person | None,
        authority: str, seen: Any,
    ) -> None:  # fmt: skip
        self._haptics, self._policy, self._every = haptics, policy, max(1, round(RATE / rate))
        self._most = np.repeat([limits.speed, limits.turn], 3)
        self._reach = np.repeat([limits.reach, limits.tilt], 3)
        self._timeout, self._person, self._by, self._seen = timeout, person, authority, seen
        self.asked = _Asked()
        self._X, self._share = np.eye(4), 1.0 if person is None else 0.0
        self._alone = np.zeros(6)  # goal of a policy without a person, as that of an environment
        self._before: Array | None = None
        self._felt = 0.0

    def run(self, n: int, realtime: bool) -> Array:
        """Run n ticks; returns the authority of the policy at each."""
        shares, wrench = np.zeros(n), np.zeros(6)
        rigid.log(np.eye(3))  # loads scipy, which would hold up the first motion of a hand
        began = time.monotonic()
        asking: threading.Thread | None = None
        for k in range(n):
            t = k / RATE
            if k % self._every == 0 and (asking is None or not asking.is_alive()):
                asking = self._ask(t, wrench, realtime)
            hand = None if self._person is None else self._person.read(t)
            X = self._moved(t, hand)
            wrench = self._haptics.step(t, X, gripper=0.0 if hand is None else hand.gripper)
            self._felt = max(self._felt, float(np.linalg.norm(wrench[:3])))
            if self._person is not None:
                self._person.feel(wrench)
            shares[k] = self._share
            if realtime:
                time.sleep(max(0.0, began + (k + 1) / RATE - time.monotonic()))
        if asking is not None:
            asking.join(timeout=1.0)
        return shares

    def _ask(self, t: float, wrench: Array, realtime: bool) -> threading.Thread | None:
        """Ask the policy for an action, in a thread of its own in real time."""
        seen = self._seen(self._haptics.session.latest(), self._felt)
        self._felt = float(np.linalg.norm(wrench[:3]))
        if not realtime:
            self._answer(seen, t)
            return None
        thread = threading.Thread(target=self._answer, args=(seen, t), name="palpate-policy", daemon=True)
        thread.start()
        return thread

    def _answer(self, seen: Any, t: float) -> None:
        try:
            action = np.asarray(self._policy(seen), dtype=np.float64).reshape(-1)
        except Exception as error:  # whatever a policy raises must not end the loop
            self._note(f"the policy failed: {type(error).__name__}: {error}")
            return
        if action.shape != (6,) or not np.isfinite(action).all():
            self._note(f"an action is not six finite numbers: {action[:8]}")
            return
        self.asked.action, self.asked.at = np.clip(action, -self._most, self._most), t
        self.asked.count += 1

    def _note(self, text: str) -> None:
        if text not in self.asked.notes and len(self.asked.notes) < 20:
            self.asked.notes.append(text)

    def _moved(self, t: float, hand: Hand | None) -> Array:
        """The goal (4, 4), moved by policy and person since the last tick, as the authority weighs them.

        It is NaN while the hand's pose is not finite: the watchdog takes the force away, as for any device.
        """
        self._share = self._authority(hand)
        asked = self.asked.action
        if t - self.asked.at > self._timeout:
            if self.asked.count:
                self._note(f"the policy was silent for more than {self._timeout:g} s: the goal waits")
            asked = np.zeros(6)
        step = self._share * asked / RATE
        if hand is None:
            self._alone = np.clip(self._alone + step, -self._reach, self._reach)
            return rigid.displaced(np.eye(4), self._alone)
        if not np.isfinite(hand.X).all():
            self._before = None
            return np.full((4, 4), np.nan)
        if self._before is not None:
            step = step + (1.0 - self._share) * rigid.displacement(self._before, hand.X)
        self._before = np.array(hand.X)
        self._X = rigid.displaced(self._X, step)
        return self._X

    def _authority(self, hand: Hand | None) -> float:
        """Authority of the policy, which moves towards what the person asks for within `RAMP`."""
        if hand is None:
            return 1.0
        wanted = float(not hand.pedal) if self._by == "pedal" else float(np.clip((hand.gripper - 0.2) / 0.4, 0.0, 1.0))
        most = 1.0 / (RAMP * RATE)
        return float(np.clip(wanted, self._share - most, self._share + most))
