"""A score of force sensitivity from the true force of contact.

The rating scale of the field (GEARS) has the item, and people judge it by sight. Here the force itself is known. The
score is 100 / (1 + demerits), with three demerits, each dimensionless, each zero for a careful hand, each a mean or a
quantile over the time in contact, so that neither the length of a task nor its pace matters:

    excess      mean of max(0, F - need) / need       what loads tissue beyond what the task needs
    peaks       max(0, F_99 / harm - 1)               single blows hurt, although they hardly change a mean
    unsteady    (F_90 - F_10) / max(F_50, need) / 4   a hand that feels the force holds it steady

F_q is the quantile q of the force in contact. Below `TOUCH` nothing is counted as touched.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array

NEED, HARM = 1.0, 3.0
"""Force that a task needs, and force that harms the tissue, where a task states none [N]."""
TOUCH = 0.05
"""Smallest force of a contact [N]."""


@dataclass(frozen=True)
class ForceSensitivity:
    """The score and its demerits; NaN where nothing was touched."""

    score: float
    """0 to 100."""
    excess: float
    peaks: float
    unsteady: float


def force_sensitivity(force: Array, need: float = NEED, harm: float = HARM) -> ForceSensitivity:
    """The score of a task.

    Args:
        force: (n,) magnitude of the true force between instrument and tissue at equal steps of time [N].
        need: force that the task needs [N].
        harm: force above which the tissue is harmed [N].

    Raises:
        ValueError: `need` or `harm` is not positive.
    """
    if not (need > 0.0 and harm > 0.0):
        raise ValueError(f"need = {need} N and harm = {harm} N must be positive")
    F = force[force > TOUCH]
    if not len(F):
        return ForceSensitivity(*[float("nan")] * 4)
    low, middle, high, top = np.quantile(F, (0.1, 0.5, 0.9, 0.99))
    excess = float(np.maximum(0.0, F - need).mean()) / need
    peaks = max(0.0, float(top) / harm - 1.0)
    unsteady = float(high - low) / max(float(middle), need) / 4.0
    return ForceSensitivity(100.0 / (1.0 + excess + peaks + unsteady), excess, peaks, unsteady)
