"""The JSON of `palpate bench guidance` has the documented keys. No timing is asserted."""

import json_contract
import numpy as np
from rich.console import Console

from palpate import _guidance
from palpate_lab.verify.bench import guidance


def test_keys_and_table():
    progress = []
    result = guidance.run(2000, 400, progress.append)
    assert set(result) == json_contract.keys("bench guidance")
    assert result["triangles"] > 1000
    assert all(value > 0.0 for key, value in result.items() if key.startswith(("query", "qp", "hundred")))
    console = Console(width=100, record=True, quiet=True)
    console.print(guidance.table(result))


def test_quadratic_programs_are_active_and_the_cage_holds():
    A, b, y0 = guidance._programs(20)
    steps = [_guidance.Qp().solve(A[i], b[i], y0[i])["steps"] for i in range(20)]
    assert min(steps) >= 1
    assert np.mean(steps) > 3
    stage = _guidance.Guidance()
    cage = guidance.polytope()
    stage.take(cage)
    X = guidance.around(4000)
    held = [stage.step(i * 1e-3, X[i], np.zeros(6), X[i])["correction"] for i in range(4000)]
    assert np.linalg.norm(held, axis=1).max() > 5e-3
