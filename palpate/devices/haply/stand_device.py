"""A simulated Inverse3 or Minverse of the stand-in: its hand, its force and its settings."""

from __future__ import annotations

import time
from collections import deque

import numpy as np

from palpate.base.arrays import Array
from palpate.devices.haply.messages import Config, Grip, State
from palpate.devices.simulated import SimulatedDevice, Truth

MIDDLE = np.array([0.0, -0.12, 0.15])
"""Middle of the workspace in the axes of the base: x right, y away from the user, z up [m]."""
STROKE, PERIOD = 0.13, 8.0
"""The simulated hand moves down and up by this length [m] in this time [s]."""
_LOG = 200_000  # forces that are kept


class StandDevice:
    """One device. Only the thread that holds the lock of the service uses it.

    Args:
        id: its id.
        grip: the grip on it; None: without.
        handedness: `left` or `right`.
        held: True: a simulated hand moves it; False: the commanded force alone.
        mass: its moving mass [kg].
        idle_after: time without a message after which its motors are idle [s].
    """

    def __init__(self, id: str, grip: Grip | None, handedness: str, held: bool, mass: float, idle_after: float) -> None:
        self.id, self.grip, self.config = id, grip, Config(handedness=handedness)
        self.log: deque[tuple[float, Array]] = deque(maxlen=_LOG)
        """Each commanded force (3,) [N] with its time on the monotonic clock."""
        self._held, self._idle_after = held, idle_after
        self._device = SimulatedDevice("" if held else "free", Truth(mass=mass, delay=0))
        self._device.stroke, self._device.period = STROKE, PERIOD
        self._force, self._commanded, self._moved = np.zeros(3), 0.0, time.monotonic()
        self._idle = True  # the last message commanded no force

    def start(self) -> None:
        """Begin to move now."""
        self._moved = time.monotonic()

    def force(self, t: float, braked: bool) -> Array:
        """Force (3,) on the motors at a time on the monotonic clock [N]; braked: the emergency brake is on."""
        last = next(((at, F) for at, F in reversed(self.log) if at <= t), None)
        if last is None or t - last[0] > self._idle_after or braked:
            return np.zeros(3)
        return last[1].copy()

    def command(self, force: Array | None, braked: bool) -> None:
        """Let the last force act until now, and command a new one; None: the message commands no force."""
        self.catch_up(braked)
        now = time.monotonic()
        self._idle = force is None
        self._force, self._commanded = np.zeros(3) if force is None else force, now
        self.log.append((now, self._force))

    def catch_up(self, braked: bool) -> None:
        """Move until now."""
        now = time.monotonic()
        ends = min(now, self._commanded + self._idle_after)
        if ends > self._moved:
            self._device.advance(np.zeros(3) if braked else self._force, ends - self._moved)
        if now > max(ends, self._moved):
            self._device.advance(np.zeros(3), min(now - max(ends, self._moved), 1.0))
        self._moved = now

    def state(self, braked: bool, mirrored: bool) -> State:
        """What it measures; mirrored: it is not calibrated."""
        p, v = MIDDLE + self._device.position, self._device.velocity
        p[2] += 0.5 * STROKE if self._held else 0.0  # the hand moves down from the start
        if mirrored:
            p, v = p * [-1.0, 1.0, 1.0], v * [-1.0, 1.0, 1.0]
        silent = time.monotonic() - self._commanded > self._idle_after
        commanded = not (self._idle or silent or braked)
        force = self._force if commanded else np.zeros(3)
        return State(p, v, force, "position" if commanded else "idle", not mirrored, not braked, commanded)
