"""Every role x geometry x law x policy: which there are, and which have no meaning, with the reason in words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from palpate import _core
from palpate.verify.conformance import roles, specimens
from palpate.verify.conformance.laws import LAWS
from palpate.verify.conformance.roles import ROLES, RoleCase
from palpate.verify.conformance.specimens import SPECIMENS

AUTHORITY, PEDAL, OPERATOR = 0.6, 0.4, 2.0
"""Of the policies; of the foot; of the operator's force [N]."""
NEAR, ENGAGE, RELEASE = 0.004, 0.0015, 0.006
"""Gap at which the ramp by distance is full; at which a fixture engages, and releases [m]."""
PER_TURN = 150.0
"""rad per m of these where a role turns the tool."""
LATER = 0.5
"""At which the ramp by time is full [s]."""
QUICK, SLOW = 0.02, 0.2
"""Rise and fall: so that an answer stands soon; the policy's default [s]."""


@dataclass(frozen=True)
class PolicyCase:
    """A policy with the share of a fixture that it lets through, once everything has settled."""

    options: dict[str, Any] = field(default_factory=dict)
    ramp: tuple[Literal["pedal", "distance", "time", "force"], float, float] | None = None
    share: Callable[[float], float] = lambda gap: 1.0
    """of a fixture with this gap [m], after LATER, with PEDAL and OPERATOR."""

    def make(self, case: RoleCase, rise: float = QUICK) -> _core.Policy:
        """For the core."""
        policy, per = _core.Policy(), PER_TURN if case.turns else 1.0
        policy.rise = policy.fall = rise
        for key, value in self.options.items():
            setattr(policy, key, per * value if key in ("engage", "release") else value)
        if self.ramp is not None:
            by, start, end = self.ramp
            scale = per if by == "distance" else 1.0
            policy.ramps = [_core.Ramp(by, scale * start, scale * end)]
        return policy

    @property
    def hard(self) -> bool:
        """The goal is corrected as well."""
        return bool(self.options.get("hard", False))


#: By name.
POLICIES: dict[str, PolicyCase] = {
    "soft": PolicyCase(),
    "hard": PolicyCase({"hard": True}),
    "part of the authority": PolicyCase({"authority": AUTHORITY}, share=lambda gap: AUTHORITY),
    "hard, part of the authority": PolicyCase({"hard": True, "authority": AUTHORITY}, share=lambda gap: AUTHORITY),
    "ramp by pedal": PolicyCase(ramp=("pedal", 0.0, 1.0), share=lambda gap: PEDAL),
    "ramp by distance": PolicyCase(ramp=("distance", 0.0, NEAR),
                                   share=lambda gap: float(np.clip(abs(gap) / NEAR, 0.0, 1.0))),
    "ramp by time": PolicyCase(ramp=("time", 0.0, LATER)),
    "ramp by force": PolicyCase(ramp=("force", 0.0, 4.0), share=lambda gap: OPERATOR / 4.0),
    "engages and releases": PolicyCase({"engage": ENGAGE, "release": RELEASE}),
    "first of two": PolicyCase({"priority": 1}),
}  # fmt: skip

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
        of_gap = self.policy in ("ramp by distance", "engages and releases")
        if ROLES[self.role].speed and of_gap:
            return "a limit of speed is of no distance that could engage or fade it"
        return roles.meaningless(self.role, self.geometry)

    @property
    def corrects(self) -> bool:
        """Its wrench comes from the correction of a goal: it leads out what was wrong when it came, and takes time."""
        return not ROLES[self.role].speed and (POLICIES[self.policy].hard or LAWS[self.law].together)

    def share(self, gap: float) -> float:
        """Of the law's wrench, at rest."""
        if ROLES[self.role].speed and not np.isfinite(gap):
            return POLICIES[self.policy].share(0.0)
        return POLICIES[self.policy].share(gap / PER_TURN if ROLES[self.role].turns else gap)

    def __str__(self) -> str:
        return f"{self.role} x {self.geometry} x {self.law} x {self.policy}"


def combinations() -> list[Combination]:
    """All of them, the policies run fastest."""
    return [Combination(r, g, law, p) for r in ROLES for g in SPECIMENS for law in _laws() for p in POLICIES]


def _laws() -> list[str]:
    return [law for law in _core.guidance_laws() if law in LAWS]


def unjudged() -> list[str]:
    """What the core has and nothing here judges: each counts as one that is left out."""
    fields = {name for name in dir(_core.Policy) if not name.startswith("_")}
    return [*specimens.unjudged(), *roles.unjudged(), *sorted(fields - _FIELDS)]
