"""Evaluate one function over a grid, on all cores or on a Dask cluster, with identical results.

    from palpate.base.sweep import Axis, sweep

    def felt(point, seed):  # at the top of a file: the workers import it
        ...
        return {"peak_N": peak}

    if __name__ == "__main__":
        swept = sweep(felt, {"K": Axis([100.0, 200.0], "N/m", "stiffness of the wall")}, seed=1)
        swept.to_netcdf("felt.nc")

docs/studies.md shows how to run a sweep on the cluster of a laboratory.
"""

from __future__ import annotations

from palpate.base.sweep.grid import Axis
from palpate.base.sweep.result import Label, Swept
from palpate.base.sweep.run import sweep

__all__ = ["Axis", "Label", "Swept", "sweep"]
