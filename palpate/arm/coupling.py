"""The coupling of an arm: how its motors drive its joints."""

from __future__ import annotations

import numpy as np

from palpate.arm.arm import Arm
from palpate.base.arrays import Array


def coupling(arm: Arm) -> Array:
    """Coupling matrix A (n, n): q_joint = A q_motor and tau_motor = A^T tau_joint."""
    try:
        return np.asarray(arm.leader_options().coupling)
    except ValueError:  # an arm without drive limits or inertia: assume one motor per joint
        return np.eye(arm.n)


def drives(q: Array, arm: Arm) -> Array:
    """Motor positions (k, n) of joint positions q (k, n) [rad]."""
    return np.asarray(q @ np.linalg.inv(coupling(arm)).T)
