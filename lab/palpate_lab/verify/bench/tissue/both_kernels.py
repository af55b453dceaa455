"""The kernels with AVX2 and without, on the same press, and each of them twice."""

from __future__ import annotations

import numpy as np

from palpate import _tissue
from palpate_lab.verify.bench.tissue.bodies import PRONY, Lab, pressed
from palpate_lab.verify.bench.tissue.rows import Found, at_most

LAYER = (20e-3, 5e-3, 25e-3)  # thickness, cell, half width [m]
RADIUS, DEPTH = 5e-3, 4e-3  # [m]
TOLERANCE = 0.01  # of the largest force [%]


def measure(lab: Lab, short: bool = False) -> Found:
    """Difference of the forces of both kernels, and bytes that differ between two runs of the same."""
    if not _tissue.TissueBody.has_avx2:
        return Found()  # there is one kernel
    layer = (20e-3, 10e-3, 20e-3) if short else LAYER
    tips = pressed(RADIUS, DEPTH, (1e-3, 0.5e-3), 0.1, 0.1 if short else 0.4)
    tips[:, 0] += np.linspace(0.0, 4e-3, len(tips))
    forces = {}
    for portable in (False, True):
        soft = [lab.layer(*layer, prony=PRONY, yeoh=0.5, portable=portable) for _ in range(2)]
        forces[portable] = [lab.touch(one, tips, radius=RADIUS, friction=0.2).force for one in soft]
    wide, plain = forces[False][0], forces[True][0]
    difference = np.abs(wide - plain).max() / np.abs(plain).max()
    changed = sum(int(np.count_nonzero(a != b)) for a, b in forces.values())
    rows = (
        at_most("AVX2 against portable kernel: force", 100.0 * difference, TOLERANCE),
        at_most("same kernel twice: forces that differ", changed, 0, "values"),
    )
    return Found(rows, {"kernel_difference": float(difference)})
