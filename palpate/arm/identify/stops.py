"""Finds poses in which a joint leaned on its stop: the stop's torque is not gravity and must not be compensated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.arm.gravity_model import Stop
from palpate.base.arrays import Array

Mask = NDArray[np.bool_]

_ZONE = 0.03  # end of the joint's range in which it may lean on a stop, as a fraction
# A pose reveals a stop if its torque exceeds the range of torques elsewhere by _BETRAYS times the width of that range,
# and exceeds _STRAINED times the drive limit, which no cable needs.
_BETRAYS = 1.0
_STRAINED = 0.4
_LEANS = 0.25  # excess above which the other poses in the zone count as leaning, in the same width


@dataclass(frozen=True)
class Leaning:
    """Poses that lean on one stop."""

    joint: int  # from 0
    side: int  # +1 upper, -1 lower end
    rows: Mask  # (k,)


def leaning(q: Array, tau: Array, use: Mask, tau_max: Array) -> list[Leaning]:
    """Poses of q (k, n) that lean on stops, by the torques tau (k, n) that `use` (k, n) allows.

    tau_max (n,) is the drive limit [N m].
    """
    found = []
    for joint in np.flatnonzero(use.any(axis=0)):
        low, high = q[:, joint].min(), q[:, joint].max()
        x = (q[:, joint] - low) / max(high - low, 1e-9)
        for side, depth in ((1, 1.0 - x), (-1, x)):
            rest = side * tau[use[:, joint] & (depth > 2 * _ZONE), joint]
            if len(rest) < 10:
                continue
            bottom, top = np.percentile(rest, [1, 99])
            beyond = (side * tau[:, joint] - top) / max(top - bottom, 1e-6)
            beyond[(depth > _ZONE) | ~use[:, joint]] = 0.0
            if ((beyond > _BETRAYS) & (np.abs(tau[:, joint]) > _STRAINED * tau_max[joint])).any():
                found.append(Leaning(int(joint), side, beyond > _LEANS))
    return found


def stop_of(q: Array, excess: Array, lean: Leaning) -> Stop:
    """Position and stiffness of a stop, from the excess torque (k,) [N m] of its drive at q (k,) [rad]."""
    into = lean.side * q[lean.rows]  # grows into the stop
    begin = float(into.min()) - Stop.width / 2
    depth = into - begin
    stiffness = float(lean.side * excess[lean.rows] @ depth / (depth @ depth))
    return Stop(lean.joint, lean.side, lean.side * begin, max(stiffness, 0.0))
