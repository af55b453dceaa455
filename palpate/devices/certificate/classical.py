"""Classical bounds for comparison with the certificate. They require passivity, which is stricter than stability."""

from __future__ import annotations

import math


def colgate_brown(b: float, B: float, T: float, delay: float = 0.0) -> float:
    """Largest passive stiffness [N/m]: ``b > K (T / 2 + delay) + |B|``, for any passive hand on the device.

    Without delay: Colgate and Brown, Factors affecting the Z-width of a haptic display, ICRA 1994. A delay counts as
    in Gil, Avello, Rubio and Florez, Stability analysis of a 1 DOF haptic interface using the Routh-Hurwitz criterion,
    IEEE Trans. Control Systems Technology 12(4), 2004.

    Args:
        b: damping of the device (or of device and hand, for the limit with that hand) [N s/m].
        B: damping of the wall [N s/m].
        T: period of the cycle [s].
        delay: delay in addition to the half period of the zero-order hold [s].
    """
    return max(b - abs(B), 0.0) / (0.5 * T + delay)


def abbott_okamura(b: float, friction: float, quantum: float, T: float) -> float:
    """Largest passive stiffness [N/m] with a quantised position: ``K <= min(2 b / T, 2 Fc / quantum)``.

    Abbott and Okamura, Effects of position quantization and sampling rate on virtual-wall passivity, IEEE Trans.
    Robotics 21(5), 2005, for a wall without damping.
    """
    return min(2.0 * b / T, 2.0 * friction / quantum if quantum > 0.0 else math.inf)
