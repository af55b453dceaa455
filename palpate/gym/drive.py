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
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.checks import vector
from palpate.base.errors import PalpateError
from palpate.gym.mixing import Authority, Hand, Mixer
from palpate.gym.observation import PARTS, observe, space_of
from palpate.gym.policy import Policy
from palpate.gym.world import RATE, Motion, for_policies
from palpate.record.ticks import Ticks
from palpate.scene.scene import Scene
from palpate.session import Haptics
from palpate.session.summary import Summary


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
    authority: Authority = "pedal",
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
    if not (0.0 < seconds < np.inf and 0.0 < rate <= RATE):
        what = f"seconds = {seconds:g}, rate = {rate:g}"
        raise PalpateError(what, mend="both are above 0, the seconds finite, and the rate is at most 1000 Hz")
    mixer = Mixer(motion or Motion(), RATE, timeout, authority, alone=person is None)
    place = vector("goal", goal)[None]
    with Haptics(for_policies(Scene.of(scene)), record, RATE, delay=None if person else 0.0) as haptics:
        joints = haptics.session.rig.arms.follower.n
        space_of(observed, joints)  # refuses unknown parts

        def seen(tick: Ticks, felt: float) -> dict[str, Any]:
            found = observe(observed, joints, tick.reshape(1), np.array([felt]), place)
            return {name: values[0] for name, values in found.items()}

        loop = _Driving(haptics, policy, rate, mixer, person, seen)
        shares = loop.run(round(seconds * RATE), realtime)
        return Drive(haptics.close(), mixer.asked.count, tuple(mixer.asked.notes), shares)


class _Driving:
    """The loop of `drive`."""

    def __init__(
        self, haptics: Haptics, policy: Policy, rate: float, mixer: Mixer, person: Person | None, seen: Any
    ) -> None:
        self._haptics, self._policy, self._every = haptics, policy, max(1, round(RATE / rate))
        self._mixer, self._person, self._seen = mixer, person, seen
        self._felt = 0.0

    def run(self, n: int, realtime: bool) -> Array:
        """Run n ticks; returns the authority of the policy at each."""
        shares, wrench = np.zeros(n), np.zeros(6)
        began = time.monotonic()
        asking: threading.Thread | None = None
        for k in range(n):
            t = k / RATE
            if k % self._every == 0 and (asking is None or not asking.is_alive()):
                asking = self._ask(t, wrench, realtime)
            hand = None if self._person is None else self._person.read(t)
            X = self._mixer.moved(t, hand)
            wrench = self._haptics.step(t, X, gripper=0.0 if hand is None else hand.gripper)
            self._felt = max(self._felt, float(np.linalg.norm(wrench[:3])))
            if self._person is not None:
                self._person.feel(wrench)
            shares[k] = self._mixer.share
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
            self._mixer.answer(self._policy, seen, t)
            return None
        thread = threading.Thread(
            target=self._mixer.answer, args=(self._policy, seen, t), name="palpate-policy", daemon=True
        )
        thread.start()
        return thread
