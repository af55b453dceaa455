"""What no linear analysis sees, by simulation: dry friction, whole counts, and a wall that never pulls.

Friction holds small swings and lets large ones go; counts keep small swings alive; a wall that is left and met again
bounces. A list of presses and taps, the same for every device, is tried at rising stiffness, beginning well below the
linear limit, and the edge is found by halving.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from palpate import _core
from palpate.certificate.device import TAP, Device
from palpate.hands import Hand

_LADDER = (0.15, 0.3, 0.45, 0.6, 0.75, 0.88, 0.985)  # of the expected limit
_ABOVE = (1.05, 1.15, 1.3)  # friction may hold more than its describing function says
_FINE = 1.003
_SWINGS = 60  # of the expected frequency in a run, before it is judged
_SHORTEST, _LONGEST = 0.5, 40.0  # [s]


@dataclass(frozen=True)
class Trial:
    """A press, and a push off that rest with the energy of a tap."""

    spring: bool
    """Against a spring that pulls as well, instead of a wall."""
    press: float
    """[N]."""
    tap: float
    """Speed that has the energy of the push [m/s]."""
    phase: float = 0.0
    """Share of it as speed (cosine) and as place (sine) [rad]."""


TRIALS = (
    *(Trial(True, 0.0, TAP, phase) for phase in np.arange(6) * np.pi / 6),
    Trial(True, 0.0, TAP / 3),
    *(
        Trial(False, float(press), tap, phase)
        for i, press in enumerate(np.geomspace(0.2, 10.0, 9))
        for tap, phase in ((TAP * (-1) ** (i + 1), 0.3 * (-1) ** (i // 2)), (-0.3 * TAP, 0.0), (0.07 * TAP, 0.0))
    ),
)


def lasts(axis: _core.Axis, duration: float, floor: float, x0: float, v0: float, push: float) -> bool:
    """Does an oscillation last? A run that is neither at rest nor clear is made three times as long."""
    while True:
        result = axis.run(duration=duration, x0=x0, v0=v0, push=push)
        if result.oscillates:
            return True
        if result.amplitude <= floor or duration > _LONGEST:
            return False
        duration *= 3.0


def duration(w: float) -> float:
    """Of a first run, for a loop that would swing at w [rad/s]."""
    return float(np.clip(_SWINGS * 2 * np.pi / max(w, 1e-3), _SHORTEST, 6.0))


def floor(device: Device) -> float:
    """Amplitude below which nothing counts as an oscillation [m]."""
    return max(_core.AXIS_QUANTA * device.quantum, _core.AXIS_UNFELT)


def oscillates(device: Device, hand: Hand, K: float, B: float, w: float) -> bool:
    """Does any of `TRIALS` leave an oscillation that lasts?"""
    spring, wall = (_core.Axis(device.axis(hand, K, B, bilateral)) for bilateral in (True, False))
    stiff = K + hand.stiffness
    w_n = np.sqrt(stiff / (device.mass + hand.mass))
    first, still = duration(w), floor(device)
    return any(
        lasts(spring if t.spring else wall, first, still, t.press / stiff + t.tap / w_n * np.sin(t.phase),
              t.tap * np.cos(t.phase), t.press)
        for t in TRIALS
    )  # fmt: skip


def limit(device: Device, hand: Hand, B: float, expected: float, w: float) -> float:
    """The largest stiffness up to which no trial oscillates; expected: of the linear loop with friction [N/m].

    Without dry friction the linear limit bounds it, and where no trial oscillates below, is the answer.
    """
    if not 0.0 < expected < np.inf:
        return expected
    held = 0.0
    for share in _LADDER + (_ABOVE if device.friction > 0.0 else ()):
        K = share * expected
        if oscillates(device, hand, K, B, w):
            return edge(lambda k: oscillates(device, hand, k, B, w), held, K)[0] if held > 0.0 else 0.0
        held = K
    return held if device.friction > 0.0 else expected


def edge(swings: Callable[[float], bool], low: float, high: float, fine: float = _FINE) -> tuple[float, float]:
    """The largest stiffness that was seen at rest, and the least that swings, by halving in the logarithm [N/m].

    Args:
        swings: whether a stiffness [N/m] does.
        low: one that does not.
        high: one that does.
        fine: ratio of the two at which the search ends [-].
    """
    while high / low > fine:
        middle = float(np.sqrt(low * high))
        if swings(middle):
            high = middle
        else:
            low = middle
    return low, high
