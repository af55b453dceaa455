"""Linear viscoelasticity by a Prony series: relaxation and creep in closed form.

A modulus that is 1 at infinite time relaxes as G(t) = 1 + sum_i g_i exp(-t / tau_i). Its creep compliance J(t) is the
solution of the convolution integral of G with dJ/dt = 1. In the Laplace domain J(s) = 1 / (s^2 G(s)), whose poles lie
between the rates 1/tau_i, so that J has as many terms as G (Tschoegl 1989, The Phenomenological Theory of Linear
Viscoelastic Behavior, chapter 8).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array

Prony = Sequence[tuple[float, float]]
"""Terms (g_i, tau_i): modulus that relaxes, over the modulus at infinite time [-], and its time constant [s]."""


def relaxation(prony: Prony, t: npt.ArrayLike) -> Array:
    """Modulus over the modulus at infinite time [-], at times `t` [s] after a step of strain."""
    time = np.asarray(t, dtype=np.float64)
    return 1.0 + sum((g * np.exp(-time / tau) for g, tau in prony), np.zeros_like(time))


def complex_modulus(prony: Prony, frequency: float) -> complex:
    """Storage + i loss modulus over the modulus at infinite time [-], in a steady oscillation of `frequency` [Hz]."""
    omega = 2.0 * np.pi * frequency
    return 1.0 + sum((g * 1j * omega * tau / (1.0 + 1j * omega * tau) for g, tau in prony), 0j)


def creep(prony: Prony, t: npt.ArrayLike) -> Array:
    """Strain over the strain at infinite time [-], at times `t` [s] after a step of stress."""
    time = np.asarray(t, dtype=np.float64)
    return 1.0 - sum((j * np.exp(-time / tau) for j, tau in retardation(prony)), np.zeros_like(time))


def retardation(prony: Prony) -> list[tuple[float, float]]:
    """Terms (j_k, lambda_k) of the creep compliance J(t) = 1 - sum_k j_k exp(-t / lambda_k), times in [s]."""
    from scipy.optimize import brentq

    merged: dict[float, float] = {}
    for g, tau in prony:
        if g > 0.0:
            merged[tau] = merged.get(tau, 0.0) + g
    times = np.array(sorted(merged))
    terms = np.array([merged[tau] for tau in times])
    found = []
    for i, tau in enumerate(times):  # one zero between two neighbouring rates, and one below the lowest rate

        def modulus(x: float) -> float:  # G(s) s at s = -1/x
            return float(1.0 - np.sum(terms * times / (x - times)))

        high = times[i + 1] if i + 1 < len(times) else tau + float(np.sum(terms * times)) * 1.001 + tau
        edge = 1e-12 * (high - tau)
        x = float(brentq(modulus, tau + edge, high - (edge if i + 1 < len(times) else 0.0), xtol=1e-15 * high))
        slope = float(np.sum(terms * times / (1.0 - times / x) ** 2))  # of G(s) s in s
        found.append((x / slope, x))
    return found


def hereditary_force(prony: Prony, t: npt.ArrayLike, elastic: npt.ArrayLike) -> Array:
    """Force (n,) of a body whose force at infinite time would be `elastic` (n,) [N], at increasing times `t` (n,) [s].

    F(t) = elastic(t) + sum_i g_i integral exp(-(t - s)/tau_i) d elastic(s), exact for `elastic` linear between times
    (Lee and Radok 1960, J. Appl. Mech. 27: valid for contact while the circle of contact does not shrink).
    """
    time, rest = np.asarray(t, dtype=np.float64), np.asarray(elastic, dtype=np.float64)
    dt, rise = np.diff(time), np.diff(rest)
    return rest + sum((g * _relaxing(tau, dt, rise, float(rest[0])) for g, tau in prony if g), np.zeros_like(rest))


def _relaxing(tau: float, dt: Array, rise: Array, start: float) -> Array:
    """Integral of exp(-(t - s)/tau) d elastic(s) (n,), for steps dt and rises (n - 1,) between times."""
    keep = np.exp(-dt / tau)
    gain = np.where(dt > 0.0, tau * -np.expm1(-dt / tau) / np.where(dt > 0.0, dt, 1.0), 1.0)
    if len(dt) and np.ptp(dt) <= 1e-6 * float(dt.mean()):
        from scipy.signal import lfilter

        k = float(np.exp(-dt.mean() / tau))
        filtered, _ = lfilter([1.0], [1.0, -k], gain * rise, zi=[k * start])
        return np.concatenate([[start], filtered])
    states = [start]
    for k, r in zip(keep.tolist(), (gain * rise).tolist(), strict=True):
        states.append(k * states[-1] + r)
    return np.array(states)
