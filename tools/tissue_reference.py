"""Solve the axisymmetric indentation cases anew and write palpate/verify/tissue/reference.json (about 15 minutes).

    python tools/tissue_reference.py

The forces are relative to E R^2, for a sphere of radius R on a layer of thickness h bonded to a rigid ground. Their
error is .5 %: half the size of the elements changes them by .4 %.
"""

import json
import time

import numpy as np

from palpate.verify.tissue.axisymmetric import Indentation
from palpate.verify.tissue.reference import PATH

# nu, yeoh, h over R (None: a half-space), deepest depth over R
CASES = [
    (0.45, 0.0, None, 1.0),
    (0.49, 0.0, None, 1.0),
    (0.45, 0.0, 1.0, 0.5),
    (0.45, 0.0, 2.0, 0.5),
    (0.45, 0.0, 0.5, 0.25),
    (0.45, 0.0, 5.0, 1.0),
    (0.45, 1.0, None, 0.75),
    (0.49, 0.0, 1.0, 0.5),
    (0.49, 0.0, 2.0, 0.5),
    (0.4, 0.0, None, 0.5),
]


def solve(nu, yeoh, h, deepest):
    """One row of the table."""
    depths = np.arange(0.05, deepest + 1e-9, 0.05)
    thickness = 50.0 if h is None else h
    case = Indentation(poisson=nu, yeoh=yeoh, thickness=thickness, width=50.0 if h is None else 5.0 + 3.0 * h, fine=8)
    force = case.forces(depths)
    return {"nu": nu, "yeoh": yeoh, "h": h, "d": depths.round(4).tolist(), "f": [float(f"{x:.6g}") for x in force]}


def main():
    """Solve all cases; the file holds those that are ready."""
    rows = []
    for case in CASES:
        start = time.perf_counter()
        rows.append(solve(*case))
        print(case, f"{time.perf_counter() - start:.0f} s", flush=True)
        text = ",\n".join("  " + json.dumps(row) for row in rows)
        PATH.write_text('{"made_by": "tools/tissue_reference.py",\n "cases": [\n' + text + "\n ]}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
