"""How hard does a surgeon's hand press on tissue of unknown stiffness? Fifty simulated palpations give the answer.

You learn how to vary the values of a scene (`palpate.Variation`), how to run many simulations on all cores
(`palpate.simulate`), and how to use signals as arrays over all runs.

    python examples/06_many_runs.py --runs 50

Everything is simulated.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import palpate

SCENES = Path(__file__).resolve().parents[1] / "scenes"
SOFTEST, STIFFEST = 150.0, 800.0  # liver under an instrument, from healthy to fibrotic, in round numbers [N/m]


def variations(runs: int, seed: int) -> list[palpate.Variation]:
    """The palpation scene with random stiffness and a hand with tremor; each run has its own seed."""
    scene = palpate.Scene.load(SCENES / "palpation.yaml")
    rng = np.random.default_rng(seed)
    stiffness = np.exp(rng.uniform(np.log(SOFTEST), np.log(STIFFEST), runs))
    return [
        palpate.Variation(scene, {"objects.0.stiffness": K, "operator.tremor": 1e-4}, seed=i)
        for i, K in enumerate(stiffness)
    ]


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--runs", type=int, default=50)
    options.add_argument("--duration", type=float, default=5.0, help="of each run [s]")
    o = options.parse_args()

    runs = variations(o.runs, seed=1)
    found = palpate.simulate(runs, o.duration, signals=["F_T_W", "depth"], signal_rate=100.0)

    stiffness = np.array([run.overrides["objects.0.stiffness"] for run in runs])  # [N/m]
    force = np.linalg.norm(found.signals["F_T_W"], axis=2)  # (runs, samples) [N]
    depth = found.signals["depth"]  # (runs, samples) [m]
    deepest = depth.argmax(axis=1)
    rows = np.arange(len(found))
    felt = force[rows, deepest] / depth[rows, deepest]  # stiffness measured at the deepest point [N/m]

    print(f"{len(found)} runs of {o.duration:g} s, simulated")
    print("stiffness [N/m] | peak force on the hand [N] | deepest [mm] | force / depth [N/m]")
    for i in np.argsort(stiffness)[:: max(1, len(runs) // 10)]:
        peak, mm = found.summary["peak_force_N"][i], 1e3 * found.summary["max_penetration_m"][i]
        print(f"{stiffness[i]:15.0f} | {peak:26.2f} | {mm:12.1f} | {felt[i]:19.0f}")
    print(f"force / depth follows the stiffness: correlation {np.corrcoef(stiffness, felt)[0, 1]:.3f}")


if __name__ == "__main__":
    main()
