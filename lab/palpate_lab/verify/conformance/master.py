"""Check on an admittance master, which renders a fixture's damping itself: the total wrench is unchanged."""

from __future__ import annotations

import numpy as np

from palpate_lab.verify.conformance.at_rest import WEIGHTS, settle
from palpate_lab.verify.conformance.bench import Bench, between, constant_pose
from palpate_lab.verify.conformance.combinations import Combination
from palpate_lab.verify.conformance.in_motion import paths
from palpate_lab.verify.conformance.laws import LAWS, RATIO, B
from palpate_lab.verify.conformance.roles import ROLES


def admittance_master(c: Combination) -> str:
    """The wrench minus damping times velocity equals an impedance master's wrench; the damping matrix is bounded."""
    for a, b in paths(c):
        runs = []
        for damping in (False, True):
            bench = Bench(c, quick=True, damping=damping).begin(a)
            bench.run(constant_pose(a, settle(c)))
            runs.append(bench.run(between(a, b, 200)))
        plain, taken = runs
        off = np.linalg.norm((plain.F - taken.F) * WEIGHTS, axis=1).max()
        if off > 1e-6 + 1e-4 * np.linalg.norm(plain.F * WEIGHTS, axis=1).max():
            return f"{off:.3g} N between the wrenches of the two masters"
        if np.any(plain.B):
            return "damping is commanded to a master that cannot render it"
        if np.abs(taken.B - taken.B.transpose(0, 2, 1)).max() > 1e-9:
            return "its damping is not symmetric"
        least, most = np.linalg.eigvalsh(taken.B).min(), np.linalg.eigvalsh(taken.B).max()
        if least < -1e-9 or most > B / RATIO * (1.0 + 1e-9):
            return f"its damping has eigenvalues from {least:.3g} to {most:.3g} N s/m"
        if LAWS[c.law].force is None and not ROLES[c.role].turns and not ROLES[c.role].speed and most == 0.0:
            return "no damping is commanded to a master that can render it"
    return ""
