"""Fixtures of guidance in the certificate: each by itself, all at once, and beside what is touched.

A fixture is asked where the hand sends the tool, so that the follower's servo is not in its loop (arms.py): it may be
stiffer than a surface. Of several that act at once no more than the sum of their stiffnesses is felt in any direction,

    n^T (sum K_i n_i n_i^T) n <= sum K_i,

and this sum is what counts: for "all fixtures at once", and as a spring beside each object that is touched.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from palpate import _core

#: Index of what is no object.
NO_OBJECT = -1
FORCES = (1.0, 2.0, 3.0)
"""Of a hand, that the entry into a soft fixture is told for [N]."""


@dataclass(frozen=True)
class Pulled:
    """A fixture, or several that act at once, on the tool's side."""

    name: str
    K: float
    """Steepest rise of the force with the deviation [N/m]."""
    B: float
    """Most damping [N s/m]."""


def moves(fixture: _core.Fixture) -> bool:
    """It counts, and pulls the tool's place, not its orientation."""
    return fixture.on and fixture.policy.authority > 0.0 and fixture.role != "orient"


def pulled(fixtures: Sequence[_core.Fixture]) -> list[Pulled]:
    """Each fixture that counts; of several also what they are at once."""
    each = [Pulled(f"fixture {f.name}", f.policy.authority * f.stiffness, f.policy.authority * f.damping)
            for f in fixtures if moves(f)]  # fmt: skip
    if len(each) > 1:
        each.append(Pulled("all fixtures at once", sum(f.K for f in each), sum(f.B for f in each)))
    return each


def at_once(fixtures: Sequence[_core.Fixture]) -> float:
    """Stiffness that they may add along one line [N/m]."""
    return sum(f.policy.authority * f.stiffness for f in fixtures if moves(f))


def entry(force: float, K: float, force_scale: float) -> float:
    """How far a hand that presses with `force` [N] gets into a soft fixture, at the tool [m]: F / (force_scale K)."""
    return force / (force_scale * K)


def reach(k: float, force_scale: float) -> str:
    """What a soft fixture of k [N/m] can hold, in words: ``1, 2, 3 N get 2.2, 4.4, 6.7 mm in``."""
    told = ", ".join(f"{1e3 * entry(force, k, force_scale):.2g}" for force in FORCES)
    return f"{', '.join(f'{force:g}' for force in FORCES)} N get {told} mm in"
