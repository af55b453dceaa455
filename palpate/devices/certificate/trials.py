"""Simulated nonlinear effects that a linear analysis misses: dry friction, quantisation, and unilateral contact.

Dry friction stops small oscillations but not large ones. Quantisation sustains small oscillations. A unilateral wall
bounces. A fixed list of presses and taps is simulated at increasing stiffness, starting well below the linear limit,
and the limit is found by bisection.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from palpate.arm.hands import Hand
from palpate.devices.certificate.device import TAP, DeviceModel

_LADDER = (0.15, 0.3, 0.45, 0.6, 0.75, 0.88, 0.985)  # tested stiffness, as fractions of the expected limit
_ABOVE = (1.05, 1.15, 1.3)  # further fractions: friction may stabilise more than its describing function predicts
_FINE = 1.003  # ratio of the bounds at which the bisection ends


@dataclass(frozen=True)
class PressTrial:
    """A constant press, and an initial deviation from its equilibrium with the energy of a tap."""

    spring: bool
    """True for a bilateral spring instead of a unilateral wall."""
    press: float
    """Pressing force [N]."""
    tap: float
    """Speed whose kinetic energy is that of the deviation [m/s]."""
    phase: float = 0.0
    """Split of the deviation into initial speed (cosine) and initial position (sine) [rad]."""


TRIALS = (
    *(PressTrial(True, 0.0, TAP, phase) for phase in np.arange(6) * np.pi / 6),
    PressTrial(True, 0.0, TAP / 3),
    *(
        PressTrial(False, float(press), tap, phase)
        for i, press in enumerate(np.geomspace(0.2, 10.0, 9))
        for tap, phase in ((TAP * (-1) ** (i + 1), 0.3 * (-1) ** (i // 2)), (-0.3 * TAP, 0.0), (0.07 * TAP, 0.0))
    ),
)


def oscillates(device: DeviceModel, hand: Hand, K: float, B: float) -> bool:
    """True if any of `TRIALS` leaves a persistent oscillation. The simulated axis chooses the duration of each run."""
    from palpate import _verify  # compiled on first use

    spring, wall = (_verify.Axis(device.axis(hand, K, B, bilateral)) for bilateral in (True, False))
    stiff = K + hand.stiffness
    w_n = np.sqrt(stiff / (device.mass + hand.mass))
    return any(
        (spring if t.spring else wall)
        .run(x0=t.press / stiff + t.tap / w_n * np.sin(t.phase), v0=t.tap * np.cos(t.phase), push=t.press)
        .oscillates
        for t in TRIALS
    )


def limit(device: DeviceModel, hand: Hand, B: float, expected: float) -> float:
    """The largest stiffness [N/m] up to which no trial oscillates.

    Without dry friction, the linear limit is an upper bound, and it is returned if no trial below it oscillates.

    Args:
        device, hand: the simulated loop.
        B: damping of the wall [N s/m].
        expected: limit of the linear loop with equivalent viscous friction [N/m].
    """
    if expected in (0.0, np.inf):
        return expected
    stable = 0.0
    for fraction in _LADDER + (_ABOVE if device.friction > 0.0 else ()):
        K = fraction * expected
        if oscillates(device, hand, K, B):
            return edge(lambda k: oscillates(device, hand, k, B), stable, K)[0] if stable > 0.0 else 0.0
        stable = K
    return stable if device.friction > 0.0 else expected


def edge(swings: Callable[[float], bool], low: float, high: float, fine: float = _FINE) -> tuple[float, float]:
    """The largest stiffness found at rest and the smallest that oscillates [N/m], by bisection of the logarithm.

    Args:
        swings: returns True if the loop oscillates at a stiffness [N/m].
        low: stiffness at which the loop is at rest [N/m].
        high: stiffness at which the loop oscillates [N/m].
        fine: ratio of high to low at which the search ends [-].
    """
    while high / low > fine:
        middle = float(np.sqrt(low * high))
        if swings(middle):
            high = middle
        else:
            low = middle
    return low, high
