"""Solves the axisymmetric cases and writes lab/palpate_lab/verify/tissue/reference.json (25 minutes for all).

    python tools/tissue_reference.py           # only the cases that the file lacks
    python tools/tissue_reference.py --again   # all

The forces are relative to E R^2, for a sphere of radius R on a layer of thickness h bonded to a rigid ground. Their
error is .5 %: half the size of the elements changes them by .4 %. Over a lump they change by up to 1.5 % from 6 to 10
elements for one radius.
"""

import json
import sys
import time

import numpy as np

from palpate_lab.verify.tissue.axisymmetric import Indentation, Lump
from palpate_lab.verify.tissue.reference import PATH

# nu, yeoh, h over R (None: a half-space), deepest depth over R, and (top, radius, ratio of moduli) of a lump
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
    (0.45, 1.0, 5.0, 0.75),
    (0.45, 0.0, 6.0, 0.5, (0.6, 1.2, 10.0)),
    (0.45, 0.0, 6.0, 0.5, (1.0, 1.2, 10.0)),
    (0.45, 0.0, 6.0, 0.5),
]


def solve(nu, yeoh, h, deepest, lump=None):
    """One row of the table."""
    depths = np.arange(0.05, deepest + 1e-9, 0.05)
    size = {"thickness": 50.0, "width": 50.0} if h is None else {"thickness": h, "width": 5.0 + 3.0 * h}
    fine = {"fine": 8} if lump is None else {"fine": 10, "near": lump[0] + 2.0 * lump[1] + 0.2, "lump": Lump(*lump)}
    force = Indentation(poisson=nu, yeoh=yeoh, **size, **fine).forces(depths)
    known = {"nu": nu, "yeoh": yeoh, "h": h} | ({} if lump is None else {"lump": list(lump)})
    return {**known, "d": depths.round(4).tolist(), "f": [float(f"{x:.6g}") for x in force]}


def is_row_of(row, case):
    """Whether a row of the table belongs to a case."""
    nu, yeoh, h, deepest, *lump = case
    same = (row["nu"], row["yeoh"], row["h"]) == (nu, yeoh, h) and abs(row["d"][-1] - deepest) < 1e-6
    return same and row.get("lump") == (list(lump[0]) if lump else None)


def main():
    """Solve the cases; the file holds those that are ready."""
    rows = [] if "--again" in sys.argv else json.loads(PATH.read_text(encoding="utf-8"))["cases"]
    for case in CASES:
        if any(is_row_of(row, case) for row in rows):
            continue
        start = time.perf_counter()
        rows.append(solve(*case))
        print(case, f"{time.perf_counter() - start:.0f} s", flush=True)
        text = ",\n".join("  " + json.dumps(row) for row in rows)
        PATH.write_text('{"made_by": "tools/tissue_reference.py",\n "cases": [\n' + text + "\n ]}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
