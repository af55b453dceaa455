"""A policy and a person with a device share an instrument, in real time and under the watchdogs of the device.

The device is wrapped by a driver whose handle is the goal that both move: everything that acts on a person's device,
the caps, the guidance, the watchdog that writes zero force, and the record, acts on it.
"""

from __future__ import annotations

import os
import threading
import time
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import PalpateError
from palpate.devices.driver import Driver, Reading, as_reading
from palpate.gym.mixing import Authority, Hand, Mixer
from palpate.gym.observation import PARTS, observe
from palpate.gym.policy import Policy
from palpate.gym.world import Motion, for_policies
from palpate.scene.scene import Scene
from palpate.session import Session
from palpate.session.summary import Summary

_FACTS = ("rate", "force_max", "moment_max", "gripper_max", "workspace", "resolution", "mass", "delay")
_PEDAL = 1  # bit of the button that takes the authority: the clutch


class SharedDevice(Driver):
    """The driver of a device whose handle is the goal of both.

    Args:
        driver: the driver of the device, not yet open; its clutch is the pedal.
        mixer: what moves the goal.
    """

    def __init__(self, driver: Driver, mixer: Mixer) -> None:
        self._driver, self._mixer, self._began = driver, mixer, time.monotonic()
        for name in _FACTS:
            setattr(self, name, getattr(driver, name, getattr(Driver, name)))
        self.felt = 0.0
        """Largest force since the policy was asked [N]."""

    @property
    def t(self) -> float:
        """Time since the device was wrapped [s]."""
        return time.monotonic() - self._began

    def open(self) -> None:
        """Open the device."""
        self._driver.open()

    def read(self) -> Reading:
        """The goal, moved by the policy and the hand since the last reading."""
        given = as_reading(self._driver.read())
        X = np.array(given.X, dtype=np.float64)
        hand = Hand(X, float(given.gripper), bool(int(given.buttons) & _PEDAL))
        return Reading(self._mixer.moved(self.t, hand), gripper=given.gripper)

    def write(self, wrench: Array) -> None:
        """Command the wrench on the hand."""
        self.felt = max(self.felt, float(np.linalg.norm(wrench[:3])))
        self._driver.write(wrench)

    def grip(self, torque: float) -> None:
        """Command the torque of the gripper."""
        self._driver.grip(torque)

    def close(self) -> None:
        """Close the device."""
        self._driver.close()


def share(
    scene: Scene | dict[str, Any] | str | os.PathLike[str],
    policy: Policy,
    driver: Driver,
    seconds: float,
    *,
    authority: Authority = "pedal",
    rate: float = 50.0,
    record: str | os.PathLike[str] | None = None,
    motion: Motion | None = None,
    timeout: float = 0.1,
) -> tuple[Summary, Mixer]:
    """Let a policy and a person with a device drive the follower together, in real time.

    Args:
        scene: a scene, its values, its file, or the name of a shipped one.
        policy: from an observation to the velocity of the goal (6,), in W [m/s, rad/s]; in a thread of its own.
        driver: driver of the device, not yet open.
        seconds: duration [s].
        authority: ``pedal``: the person drives while the clutch of the device is pressed; ``gripper``: while its
            gripper is closed below 0.2 rad, and the policy above 0.6 rad.
        rate: actions per second [Hz].
        record: folder for the record; None: nothing is recorded.
        motion: limits of the motion that the policy can ask for.
        timeout: age of an action after which the policy moves nothing [s].

    Returns:
        The summary of the run, and the mixer with the actions and notes of the policy.

    Raises:
        PalpateError: an argument is out of range. DeviceError: the device cannot be used. SceneError, MeshError: the
        scene cannot run.
    """
    if not (0.0 < seconds < np.inf and 0.0 < rate <= 1000.0):
        what = f"seconds = {seconds:g}, rate = {rate:g}"
        raise PalpateError(what, mend="the seconds are above 0 and finite, and the rate is at most 1000 Hz")
    mixer = Mixer(motion or Motion(), getattr(driver, "rate", Driver.rate), timeout, authority)
    device = SharedDevice(driver, mixer)
    session = Session(for_policies(Scene.of(scene)), record, driver=device)
    joints, stop = session.rig.arms.follower.n, threading.Event()

    def ask() -> None:
        while not stop.wait(1.0 / rate):
            felt, device.felt = device.felt, 0.0
            tick = session.latest().reshape(1)
            seen = observe(PARTS, joints, tick, np.array([felt]), np.zeros((1, 3)))
            mixer.answer(policy, {name: values[0] for name, values in seen.items()}, device.t)

    asking = threading.Thread(target=ask, name="palpate-policy", daemon=True)
    asking.start()
    try:
        summary = session.run(seconds)
    finally:
        stop.set()
        asking.join(timeout=1.0)
    return summary, mixer
