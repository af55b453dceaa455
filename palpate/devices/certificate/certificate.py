"""The certificate: the largest stable stiffness, a verdict on a given stiffness, and the reason."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.checks import finite_or_none
from palpate.devices.certificate import classical, trials, words
from palpate.devices.certificate.coupled import CoupledLoop
from palpate.devices.certificate.device import DeviceModel
from palpate.devices.certificate.loop import SampledLoop

Verdict = Literal["stable", "marginal", "unstable"]

#: A stiffness below this fraction of both limits, with dry friction and linear, is stable. A stiffness above the limit
#: with friction divided by this fraction is unstable. A stiffness between these two values is marginal.
SURE = 0.97
_VISCOUS = 10.0  # largest damping that is advised, unless four times the present damping is larger [N s/m]


Loop = SampledLoop | CoupledLoop


@dataclass(frozen=True)
class Case:
    """One of the loops that must be stable."""

    description: str
    """The hand, direction and pose of this loop, in words."""
    loop: Loop


@dataclass(frozen=True)
class BoundaryPoint:
    """A point of the linear stability boundary."""

    B_N_s_per_m: float
    K_N_per_m: float | None
    """None: every stiffness is stable."""


@dataclass(frozen=True)
class Figures:
    """Figures of a certificate: the documented contract of ``--json`` (docs/json.md). None stands for infinity."""

    k_max_N_per_m: float | None
    verdict: Verdict | None
    reason: str
    margin: float | None
    K_N_per_m: float | None
    B_N_s_per_m: float
    k_linear_N_per_m: float | None
    frequency_Hz: float
    worst: str
    hands_N_per_m: dict[str, float | None]
    hand_damping_N_s_per_m: list[float]
    k_half_damping_N_per_m: float | None
    bounds_N_per_m: dict[str, float | None]
    boundary: list[BoundaryPoint]


@dataclass(frozen=True)
class Certificate:
    """Stiffness limit and verdict for one wall damping. The most critical of all cases sets the limit."""

    B: float
    """Damping of the wall [N s/m]."""
    k_max: float
    """Largest stable stiffness; infinity if every stiffness is stable [N/m]."""
    k_linear: float
    """Limit of the linear loop, without the effects of dry friction, encoder counts and bouncing [N/m]."""
    frequency: float
    """Frequency of the oscillation at the limit [Hz]."""
    worst: str
    """Description of the case that sets the limit."""
    K: float | None
    """Stiffness to judge; None if only the limit was requested [N/m]."""
    verdict: Verdict | None
    """Verdict on K; None without K."""
    margin: float | None
    """k_max / K - 1: relative stiffness reserve [-]."""
    reason: str
    """The verdict in words, with advice that would raise the limit."""
    bounds: dict[str, float] = field(default_factory=dict)
    """Classical passivity bounds by name, see `classical` [N/m]."""
    hands: dict[str, float] = field(default_factory=dict)
    """Linear limit with each hand of the range, with dry friction replaced by viscous friction [N/m]."""
    hand_damping: tuple[float, float] = (0.0, 0.0)
    """Smallest and largest damping of the hands for which the limit holds [N s/m]."""
    k_half_damping: float = 0.0
    """Limit of the loop for hands with half of this damping [N/m]."""
    cases: tuple[Case, ...] = field(default=(), repr=False)
    name: str = ""
    """Name of the object, region or fixture; empty for a device."""

    @property
    def k_sure(self) -> float:
        """Largest stiffness with the verdict "stable" [N/m]."""
        return SURE * min(self.k_max, self.k_linear)

    def boundary(self, points: int = 48) -> tuple[Array, Array]:
        """The linear stability boundary of the worst case at each damping: B (points,) [N s/m], K (points,) [N/m]."""
        top = min(case.loop.B_max for case in self.cases)
        top = min(top, max(4.0 * self.B, 3.0 * _VISCOUS))
        B = np.linspace(0.0, top * (1 - 1e-6), points)
        return B, np.array([min(case.loop.K_max(b)[0] for case in self.cases) for b in B])

    def figures(self) -> Figures:
        """The figures that ``palpate certify --json`` writes."""
        return Figures(
            k_max_N_per_m=finite_or_none(self.k_max),
            verdict=self.verdict,
            reason=self.reason,
            margin=self.margin,
            K_N_per_m=self.K,
            B_N_s_per_m=self.B,
            k_linear_N_per_m=finite_or_none(self.k_linear),
            frequency_Hz=self.frequency,
            worst=self.worst,
            hands_N_per_m={name: finite_or_none(k) for name, k in self.hands.items()},
            hand_damping_N_s_per_m=list(self.hand_damping),
            k_half_damping_N_per_m=finite_or_none(self.k_half_damping),
            bounds_N_per_m={name: finite_or_none(k) for name, k in self.bounds.items()},
            boundary=[BoundaryPoint(float(b), finite_or_none(k)) for b, k in np.transpose(self.boundary())],
        )


def linear_limit(cases: tuple[Case, ...], B: float) -> tuple[float, float, Case]:
    """Largest stable stiffness of all cases [N/m], its frequency [rad/s], and the case that sets it."""
    limits = [(*case.loop.K_max(B), case) for case in cases]
    return min(limits, key=lambda limit: limit[0])


def judge(K: float | None, k_max: float, k_linear: float) -> tuple[Verdict | None, float | None]:
    """The verdict on K, and the margin. The verdict is stable only if the loop is stable without dry friction."""
    if K is None or K <= 0.0:
        return (None if K is None else "stable" if k_max > 0.0 else "unstable"), None
    margin = k_max / K - 1.0
    sure = SURE * min(k_max, k_linear)
    verdict: Verdict = "stable" if sure >= K else "marginal" if k_max / SURE > K else "unstable"
    return verdict, (margin if np.isfinite(margin) else None)


def certify_device(device: DeviceModel, K: float | None = None, B: float = 0.0) -> Certificate:
    """The certificate of a device for a wall of stiffness K [N/m] (None: only the limit) and damping B [N s/m]."""
    frictional = tuple(Case(f"hand {h.name}", device.loop(h, lubricated=False)) for h in device.hands)
    linear = tuple(Case(f"hand {h.name}", device.loop(h)) for h in device.hands)
    k_linear, w, worst = linear_limit(linear, B)
    k_max = np.inf
    expectations = [(hand, case, *case.loop.K_max(B)) for hand, case in zip(device.hands, frictional, strict=True)]
    for hand, case, expected, w_hand in sorted(expectations, key=lambda one: one[2]):
        if expected >= k_max and not trials.oscillates(device, hand, k_max, B):
            continue
        k_hand = trials.limit(device, hand, B, expected)
        if k_hand < k_max:
            k_max, w, worst = k_hand, w_hand, case
    verdict, margin = judge(K, k_max, k_linear)
    b = device.damping + min(h.damping for h in device.hands)
    bounds = {
        "colgate_brown": classical.colgate_brown(device.damping, B, 1 / device.rate, device.delay + device.jitter),
        "colgate_brown_with_hand": classical.colgate_brown(b, B, 1 / device.rate, device.delay + device.jitter),
        "abbott_okamura": classical.abbott_okamura(device.damping, device.friction, device.quantum, 1 / device.rate),
    }

    loop = words.LoopFacts(device.delay + device.jitter, device.rate, B, w / (2 * np.pi), worst.description)
    reason = words.reason(K, k_max, verdict, loop, advice(frictional, B))
    if verdict == "marginal" and K is not None and SURE * k_linear < K:
        reason += f"; beyond {words.number(k_linear)} N/m it leans on the device's dry friction"
    hands = {hand.name: expected for hand, _, expected, _ in expectations}
    dampings = [h.damping for h in device.hands]
    less = [Case(h.name, device.loop(h.damped(words.LESS), lubricated=False)) for h in device.hands]
    k_less = min(k_max, linear_limit(tuple(less), B)[0])
    reason += "; " + words.hands_covered(dampings, k_less)
    return Certificate(B, k_max, k_linear, w / (2 * np.pi), worst.description, K, verdict, margin, reason, bounds,
                       hands, (min(dampings), max(dampings)), k_less, frictional)  # fmt: skip


def advice(cases: tuple[Case, ...], B: float) -> list[words.Advice]:
    """Changes that may raise the limit of any loop: less delay, other damping."""
    delay = max(case.loop.delay for case in cases)
    less = 1e-3 * round(1e3 * delay / 3) if delay >= 1.5e-3 else delay / 3
    found: list[words.Advice] = []
    if delay > 0.0:
        shorter = tuple(Case(c.description, c.loop.delayed(max(c.loop.delay - less, 0.0))) for c in cases)
        found.append((f"{1e3 * less:.2g} ms less delay", lambda: linear_limit(shorter, B)[0]))
    best, K = _best_damping(cases, B)
    change = f"{best:.2g} N s/m of damping" if best > B else f"only {best:.2g} N s/m of damping"
    return [*found, (change, lambda: K)]


def _best_damping(cases: tuple[Case, ...], B: float) -> tuple[float, float]:
    """The damping [N s/m], bounded by `_VISCOUS`, with the largest stable stiffness, and this stiffness [N/m]."""
    top = min(min(case.loop.B_max for case in cases), max(4.0 * B, _VISCOUS))
    grid = np.linspace(0.0, 0.98 * top, 12)
    K = [linear_limit(cases, float(b))[0] for b in grid]
    best = int(np.argmax(K))
    return float(grid[best]), float(K[best])
