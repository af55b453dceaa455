"""On an admittance master, which takes a fixture's damping into its own equation: is the same felt as on any other?"""

from __future__ import annotations

import numpy as np

from palpate.verify.conformance.at_rest import WEIGH, settle
from palpate.verify.conformance.bench import Bench, between, still
from palpate.verify.conformance.combinations import Combination
from palpate.verify.conformance.in_motion import ways
from palpate.verify.conformance.laws import LAWS, RATIO, B
from palpate.verify.conformance.roles import ROLES


def admittance_master(c: Combination) -> str:
    """Wrench less damping times velocity is the other master's wrench; the damping is one, of the law's size."""
    for a, b in ways(c.role, c.geometry):
        told = []
        for damping in (False, True):
            bench = Bench(c, quick=True, damping=damping).begin(a)
            bench.run(still(a, settle(c)))
            told.append(bench.run(between(a, b, 200)))
        plain, taken = told
        off = np.linalg.norm((plain.F - taken.F) * WEIGH, axis=1).max()
        if off > 1e-6 + 1e-4 * np.linalg.norm(plain.F * WEIGH, axis=1).max():
            return f"{off:.3g} N between what the two masters feel"
        if np.any(plain.B):
            return "damping is told to a master that cannot take it"
        least, most = np.linalg.eigvalsh(taken.B).min(), np.linalg.eigvalsh(taken.B).max()
        if least < -1e-9 or most > B / RATIO * (1.0 + 1e-9):
            return f"its damping has eigenvalues from {least:.3g} to {most:.3g} N s/m"
        if LAWS[c.law].force is None and not ROLES[c.role].turns and not ROLES[c.role].speed and most == 0.0:
            return "no damping is told to a master that takes it"
    return ""
