"""The energy that a fixture yields is in the energy ledger, and the passivity layer withholds it."""

from __future__ import annotations

import numpy as np

from palpate import _core, _verify
from palpate.base.arrays import Array
from palpate_lab.verify.conformance.bench import DT, Motion

ALLOWANCE = 5e-4
"""Energy that the passivity layer may return beyond the energy put in [J]."""


def billing_failure(F: Array, motion: Motion) -> str:
    """The ledger books the work of the wrench F (n, 6), and the passivity layer returns its allowance at most."""
    options = _core.StabilityOptions()
    options.force_cap, options.rate_cap, options.moment_cap, options.moment_rate_cap = 50.0, 1e3, 1.0, 20.0
    options.acceleration, options.angular_acceleration, options.allowance = 10.0, 200.0, ALLOWANCE
    stage, ledger = _verify.Stability(options, DT), _verify.Ledger()
    felt = np.empty_like(F)
    for k, (X, V) in enumerate(zip(motion.X, motion.V, strict=True)):
        R, p = np.ascontiguousarray(X[:3, :3]), X[:3, 3]
        t = DT * k
        felt[k] = stage.step(F[k], p, V[:3], t=t, t_leader=t, R_LH=R, w_LH=V[3:]).F_H_L
        stage.rendered(felt[k])
        booked = ledger.step(p, felt[k], np.zeros(6), np.zeros(6), 0.0, R, F[k][None])
    wanted, returned = (np.cumsum(np.einsum("ij,ij->i", G[:-1], motion.displacements)) for G in (F, felt))
    off = abs(sum(booked.source) + wanted[-1]) + abs(booked.port + returned[-1])
    if off > 1e-9 + 1e-6 * np.abs(wanted).max():
        return f"{1e3 * wanted[-1]:.4g} mJ were given, {-1e3 * sum(booked.source):.4g} mJ are in the ledger"
    if returned.max() > ALLOWANCE + 1e-6:
        return f"the passivity layer returns {1e3 * returned.max():.3g} mJ, {1e3 * ALLOWANCE:.3g} allowed"
    return ""
