"""A simulated haptic device with known mass, friction, delay, noise and resolution, held by a moving hand or by nobody.

Its measurements judge `palpate device bench`: what the bench recovers is compared with the numbers given here.
"""

from __future__ import annotations

import math
import time
from collections import deque
from dataclasses import dataclass

import numpy as np

from palpate.arm.hands import PRESETS
from palpate.base.arrays import Array
from palpate.devices.driver import Driver, Reading

GRAVITY = 9.81  # [m/s^2]
_SUBSTEPS = 4  # of the simulated motion in each period
_LONGEST = 0.05  # simulated time in one reading at most [s]


@dataclass(frozen=True)
class Truth:
    """Parameters of the simulated device, equal along its three axes."""

    mass: float = 0.2
    """Moving mass [kg]."""
    damping: float = 0.5
    """Viscous friction [N s/m]."""
    friction: float = 0.05
    """Dry friction [N]."""
    noise: float = 2e-6
    """Noise of the measured position, rms per axis [m]."""
    resolution: float = 1e-5
    """Resolution of the measured position, 0: exact [m]."""
    delay: float = 2
    """Periods from a command to its force, in quarters [-]."""
    stiffness: float = 0.0
    """Restoring force towards the middle, as of a spring or a cable [N/m]."""
    force_gain: float = 1.0
    """Force on the handle over the commanded force [-]."""
    seed: int = 0
    """Seed of the noise."""


class SimulatedDevice(Driver):
    """A device like an Omega.3: three translations, 12 N, no rotation.

    A simulated hand moves it up and down by 30 mm every 4 s; without a hand it moves by the commanded force alone. In
    the driver's own time each reading takes one period, which makes runs reproducible; otherwise it follows the clock.
    """

    rate, force_max, workspace = 1000.0, 12.0, (0.16, 0.16, 0.11)
    name_of_driver = "simulated"

    def __init__(self, argument: str = "", truth: Truth | None = None) -> None:
        self.truth = truth or Truth()
        self.mass = self.truth.mass
        self.resolution = self.truth.resolution
        self.delay = self.truth.delay / self.rate
        self.hand = PRESETS["light"]
        self.held = argument != "free"
        self.lockstep = False  #: True: each reading takes one period
        self.load = 0.0  #: mass of a weight that hangs on the handle [kg]
        self.attached = 0.0  #: stiffness of a spring along z between the handle and where it is at the start [N/m]
        self.stroke, self.period = 0.03, 4.0  #: motion of the hand, down and up [m], in this time [s]
        self._rng = np.random.default_rng(self.truth.seed)
        self._p, self._v = np.zeros(3), np.zeros(3)
        self._wrench = np.zeros(6)
        self._queue: deque[Array] = deque()
        self._last = np.zeros(3)
        self._t, self._clock = 0.0, 0.0

    @property
    def t(self) -> float:
        """Simulated time [s]."""
        return self._t

    @property
    def position(self) -> Array:
        """True position (3,) in the axes of the base [m]."""
        return self._p.copy()

    @property
    def velocity(self) -> Array:
        """True velocity (3,) in the axes of the base [m/s]."""
        return self._v.copy()

    def advance(self, F: Array, seconds: float) -> None:
        """Let the force F (3,) [N] act for a time [s], without the delay of `read`."""
        steps = max(1, math.ceil(seconds * _SUBSTEPS * self.rate))
        self._advance(F, seconds / steps, steps)

    def open(self) -> None:
        """Start the clock."""
        self._clock = time.monotonic()
        self._queue, self._last = deque([np.zeros(3)] * int(self.truth.delay)), np.zeros(3)

    def read(self) -> Reading:
        """The noisy, rounded pose after the time since the last reading."""
        passed = 1.0 / self.rate if self.lockstep else min(time.monotonic() - self._clock, _LONGEST)
        self._clock += passed
        self._queue.append(self._wrench[:3].copy())
        F, last = self._queue.popleft(), self._last
        late = round((self.truth.delay % 1.0) * _SUBSTEPS)
        self._advance(last, passed / _SUBSTEPS, late)
        self._advance(F, passed / _SUBSTEPS, _SUBSTEPS - late)
        self._last = F
        p = self._p + self.truth.noise * self._rng.standard_normal(3)
        if self.truth.resolution > 0.0:
            p = self.truth.resolution * np.round(p / self.truth.resolution)
        X = np.eye(4)
        X[:3, 3] = p
        return Reading(X)

    def write(self, wrench: Array) -> None:
        """Take the force, which acts after the delay."""
        self._wrench = np.array(wrench, dtype=np.float64)

    def close(self) -> None:
        """Nothing to close."""

    def _advance(self, F: Array, dt: float, steps: int) -> None:
        """Steps of m v' = F - b v - k p - friction sign(v) + hand. Friction holds what it can and reverses nothing.

        Positions follow the mean of the old and the new velocity: exact for a constant force, without a lead of half a
        step.
        """
        m, damping, stiffness, friction = self.truth.mass + self.load, self.truth.damping, 0.0, self.truth.friction
        if self.held:
            m, damping, stiffness = m + self.hand.mass, damping + self.hand.damping, self.hand.stiffness
        share = 1.0 / (1.0 + dt / m * (damping + dt * stiffness))
        p, v, force = self._p.tolist(), self._v.tolist(), (self.truth.force_gain * F).tolist()
        force[2] -= self.load * GRAVITY
        springs = (self.truth.stiffness, self.truth.stiffness, self.truth.stiffness + self.attached)
        turn = 2.0 * math.pi / self.period
        for _ in range(steps):
            self._t += dt
            aim = (0.0, 0.0, 0.5 * self.stroke * (math.cos(turn * self._t) - 1.0))
            for i in range(3):
                u = share * (v[i] + dt / m * (force[i] - springs[i] * p[i] - stiffness * (p[i] - aim[i])))
                before, v[i] = v[i], math.copysign(max(abs(u) - dt / m * friction, 0.0), u)
                p[i] += 0.5 * dt * (before + v[i])
        self._p, self._v = np.array(p), np.array(v)
