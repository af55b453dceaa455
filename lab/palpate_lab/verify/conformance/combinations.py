"""All combinations of role, geometry, law and policy, and the reasons why some of them are meaningless."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from palpate import _core, _guidance
from palpate_lab.verify.conformance import roles, specimens
from palpate_lab.verify.conformance.laws import LAWS
from palpate_lab.verify.conformance.roles import ROLES, RoleCase
from palpate_lab.verify.conformance.specimens import SPECIMENS

AUTHORITY, PEDAL, OPERATOR = 0.6, 0.4, 2.0
"""Authority of the policies [-]; position of the pedal [-]; force of the operator [N]."""
NEAR, ENGAGE, RELEASE = 0.004, 0.0015, 0.006
"""Gap at which the ramp by distance ends, at which a fixture engages, and at which it releases [m]."""
PER_TURN = 150.0
"""Conversion of these gaps for roles that rotate the tool [rad/m]."""
LATER = 0.5
"""End of the ramp by time [s]."""
QUICK, SLOW = 0.02, 0.2
"""Rise and fall times: a short one that settles quickly, and the policy's default [s]."""


@dataclass(frozen=True)
class PolicyCase:
    """A policy with its settled activation of a fixture."""

    hard: bool = False
    """True if the policy also corrects the goal."""
    authority: float = 1.0
    priority: int = 0
    engage: float | None = None
    """Gap at which the fixture engages [m]; None: the fixture is always engaged."""
    release: float | None = None
    """Gap at which it releases [m]."""
    ramp: tuple[Literal["pedal", "distance", "time", "force"], float, float] | None = None
    activation: Callable[[float], float] = lambda gap: 1.0
    """Activation [-] by gap [m] after the time LATER, with PEDAL and OPERATOR."""

    def make(self, case: RoleCase, rise: float = QUICK) -> _core.Policy:
        """The core's policy for a role."""
        policy, per = _core.Policy(), PER_TURN if case.turns else 1.0
        policy.rise = policy.fall = rise
        policy.hard, policy.authority, policy.priority = self.hard, self.authority, self.priority
        if self.engage is not None and self.release is not None:
            policy.engage, policy.release = per * self.engage, per * self.release
        if self.ramp is not None:
            by, start, end = self.ramp
            scale = per if by == "distance" else 1.0
            policy.ramps = [_core.Ramp(by, scale * start, scale * end)]
        return policy


#: By name.
POLICIES: dict[str, PolicyCase] = {
    "soft": PolicyCase(),
    "hard": PolicyCase(hard=True),
    "part of the authority": PolicyCase(authority=AUTHORITY, activation=lambda gap: AUTHORITY),
    "hard, part of the authority": PolicyCase(hard=True, authority=AUTHORITY, activation=lambda gap: AUTHORITY),
    "ramp by pedal": PolicyCase(ramp=("pedal", 0.0, 1.0), activation=lambda gap: PEDAL),
    "ramp by distance": PolicyCase(ramp=("distance", 0.0, NEAR),
                                   activation=lambda gap: float(np.clip(abs(gap) / NEAR, 0.0, 1.0))),
    "ramp by time": PolicyCase(ramp=("time", 0.0, LATER)),
    "ramp by force": PolicyCase(ramp=("force", 0.0, 4.0), activation=lambda gap: OPERATOR / 4.0),
    "engages and releases": PolicyCase(engage=ENGAGE, release=RELEASE),
    "first of two": PolicyCase(priority=1),
}  # fmt: skip

_FIELDS = {"hard", "authority", "priority", "engage", "release", "rise", "fall", "ramps"}


@dataclass(frozen=True)
class Combination:
    """One combination of role, geometry, law and policy, by their names."""

    role: str
    geometry: str
    law: str
    policy: str
    seed: int = 0
    """Seed of the tool poses at which the combination is judged."""

    @property
    def meaningless(self) -> str:
        """Reason why the combination is meaningless and must be refused; empty if it is meaningful."""
        of_gap = self.policy in ("ramp by distance", "engages and releases")
        if ROLES[self.role].speed and of_gap:
            return "a limit of speed is of no distance that could engage or fade it"
        return roles.meaningless(self.role, self.geometry)

    @property
    def corrects(self) -> bool:
        """True if the wrench comes from a goal correction, which removes an initial violation only over time."""
        return not ROLES[self.role].speed and (POLICIES[self.policy].hard or LAWS[self.law].together)

    def activation(self, gap: float) -> float:
        """Activation of the law's wrench at rest [-]."""
        return POLICIES[self.policy].activation(gap / PER_TURN if ROLES[self.role].turns else gap)

    @property
    def turn(self) -> int:
        """Index of law and policy; it selects the combination's places from those of its role and geometry."""
        return len(POLICIES) * list(LAWS).index(self.law) + list(POLICIES).index(self.policy)

    def __str__(self) -> str:
        return f"{self.role} x {self.geometry} x {self.law} x {self.policy}"


def combinations(seed: int = 0) -> list[Combination]:
    """All combinations, judged at the places of a seed; the policy varies fastest."""
    return [Combination(r, g, law, p, seed) for r in ROLES for g in SPECIMENS for law in _laws() for p in POLICIES]


def sample(seed: int) -> list[Combination]:
    """One meaningful combination of every second pair of role and geometry, of the other half for the next seed.

    The seed also selects law, policy and places.
    """
    rng, found = np.random.default_rng(seed), []
    for role in ROLES:
        for geometry in SPECIMENS:
            kinds = [(law, policy) for law in _laws() for policy in POLICIES]
            order = [Combination(role, geometry, kinds[k][0], kinds[k][1], seed) for k in rng.permutation(len(kinds))]
            found += [c for c in order if not c.meaningless][:1]
    return found[seed % 2 :: 2]


def _laws() -> list[str]:
    return [law for law in _guidance.guidance_laws() if law in LAWS]


def unjudged() -> list[str]:
    """Names of the core that have no reference here; each one counts as unjudged."""
    fields = {name for name in dir(_core.Policy) if not name.startswith("_")}
    return [*specimens.unjudged(), *roles.unjudged(), *sorted(fields - _FIELDS)]
