"""Guidance fixtures in the certificate: each alone, all at once, and in parallel with each touched object.

A fixture is evaluated at the commanded tool pose, so the follower's servo is not in its loop (arms.py) and it may be
stiffer than a surface. The total stiffness of several active fixtures in a direction n is at most the sum

    n^T (sum K_i n_i n_i^T) n <= sum K_i.

The certificate uses this sum for "all fixtures at once" and as a spring in parallel with each touched object.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from palpate import _guidance


#: Index of a surface that is not an object of the scene.
NO_OBJECT = -1
FORCES = (1.0, 2.0, 3.0)
"""Forces of the hand for which the penetration into a soft fixture is reported [N]."""


@dataclass(frozen=True)
class FixtureSpring:
    """Spring and damper of one fixture, or of several active fixtures, on the tool's side."""

    name: str
    K: float
    """Largest slope of the force over the deviation [N/m]."""
    B: float
    """Largest damping [N s/m]."""


def acts_on_position(fixture: _guidance.Fixture) -> bool:
    """True if the fixture is on, has authority, and acts on the tool's position instead of its orientation."""
    return fixture.on and fixture.policy.authority > 0.0 and fixture.role != "orient"


def fixture_springs(fixtures: Sequence[_guidance.Fixture]) -> list[FixtureSpring]:
    """One entry per fixture that acts on the position; with several fixtures also their sum."""
    each = [FixtureSpring(f"fixture {f.name}", f.policy.authority * f.stiffness, f.policy.authority * f.damping)
            for f in fixtures if acts_on_position(f)]  # fmt: skip
    if len(each) > 1:
        each.append(FixtureSpring("all fixtures at once", sum(f.K for f in each), sum(f.B for f in each)))
    return each


def total_stiffness(fixtures: Sequence[_guidance.Fixture]) -> float:
    """Upper bound of the fixtures' total stiffness along any direction [N/m]."""
    return sum(f.policy.authority * f.stiffness for f in fixtures if acts_on_position(f))


def entry(force: float, K: float, force_scale: float) -> float:
    """Depth of the tool in a soft fixture when the hand presses with `force` [N]: F / (force_scale K) [m]."""
    return force / (force_scale * K)


def entry_summary(k: float, force_scale: float) -> str:
    """Penetration into a soft fixture of k [N/m] in words: ``1, 2, 3 N get 2.2, 4.4, 6.7 mm in``."""
    depths = ", ".join(f"{1e3 * entry(force, k, force_scale):.2g}" for force in FORCES)
    return f"{', '.join(f'{force:g}' for force in FORCES)} N get {depths} mm in"
