"""Batch simulation: many runs on all cores. Each run equals the run of a session; the runs share their meshes.

runs = [palpate.Variation("scenes/palpation.yaml", {"objects.0.stiffness": float(K)}) for K in range(100, 600, 5)]
found = palpate.simulate(runs, duration=5.0, signals=["F_T_W"])
print(found.summary["peak_force_N"])    # (100,)
print(found.signals["F_T_W"].shape)     # (100, 500, 3)
"""

from palpate.session.batch.result import MEASURED, Simulated
from palpate.session.batch.runner import simulate
from palpate.session.batch.variation import Variation

__all__ = ["MEASURED", "Simulated", "Variation", "simulate"]
