"""Every role x geometry x law x policy: which there are, and which have no meaning, with the reason in words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from palpate import _core
from palpate.conformance import judges, specimens
from palpate.conformance.judges import LAWS, ROLES
from palpate.conformance.specimens import SPECIMENS

AUTHORITY, PEDAL, OPERATOR = 0.6, 0.4, 2.0


@dataclass(frozen=True)
class PolicyCase:
    """A policy with the share of a fixture that it lets through, once everything has settled."""

    options: dict[str, Any] = field(default_factory=dict)
    ramp: tuple[Literal["pedal", "distance", "time", "force"], float, float] | None = None
    share: Callable[[float], float] = lambda gap: 1.0
    """of a fixture with this gap [m, rad]."""

    def make(self, turns: bool) -> _core.Policy:
        """For the core."""
        policy = _core.Policy()
        policy.rise = policy.fall = 0.02
        for key, value in self.options.items():
            setattr(policy, key, value)
        if self.ramp is not None:
            by, start, end = self.ramp
            scale = REACH / NEAR if turns and by == "distance" else 1.0
            policy.ramps = [_core.Ramp(by, scale * start, scale * end)]
        return policy


NEAR, REACH = 0.004, 0.6
"""Gap at which the ramp by distance is full: of places [m], of turns [rad]."""


def _by_distance(gap: float, full: float = NEAR) -> float:
    return float(np.clip(abs(gap) / full, 0.0, 1.0))


#: By name.
POLICIES: dict[str, PolicyCase] = {
    "soft": PolicyCase(),
    "hard": PolicyCase({"hard": True}),
    "part of the authority": PolicyCase({"authority": AUTHORITY}, share=lambda gap: AUTHORITY),
    "hard, part of the authority": PolicyCase({"hard": True, "authority": AUTHORITY}, share=lambda gap: AUTHORITY),
    "ramp by pedal": PolicyCase(ramp=("pedal", 0.0, 1.0), share=lambda gap: PEDAL),
    "ramp by distance": PolicyCase(ramp=("distance", 0.0, NEAR), share=_by_distance),
    "ramp by time": PolicyCase(ramp=("time", 0.0, 0.05)),
    "ramp by force": PolicyCase(ramp=("force", 0.0, 4.0), share=lambda gap: OPERATOR / 4.0),
    "engages and releases": PolicyCase({"engage": 1.0, "release": 1.2}),
    "first of two": PolicyCase({"priority": 1}),
}

_FIELDS = {"hard", "authority", "priority", "engage", "release", "rise", "fall", "ramps"}


@dataclass(frozen=True)
class Combination:
    """One of all."""

    role: str
    geometry: str
    law: str
    policy: str

    @property
    def meaningless(self) -> str:
        """Why it has no meaning, in words; empty when it has one. The product has to refuse it."""
        if ROLES[self.role].needs_solid and not SPECIMENS[self.geometry].solid:
            return f"a {self.geometry} has no inside, and {self.role} needs one"
        return ""

    def __str__(self) -> str:
        return f"{self.role} x {self.geometry} x {self.law} x {self.policy}"


def combinations() -> list[Combination]:
    """All of them, the policies run fastest."""
    return [Combination(r, g, law, p) for r in ROLES for g in SPECIMENS for law in _laws() for p in POLICIES]


def _laws() -> list[str]:
    return [law for law in _core.guidance_laws() if law in LAWS]


def unjudged() -> list[str]:
    """What the core has and nothing here judges: each is a combination that fails."""
    fields = {name for name in dir(_core.Policy) if not name.startswith("_")}
    return [*specimens.unjudged(), *judges.unjudged(), *sorted(fields - _FIELDS)]
