"""The JSON of `palpate bench sweep` has the documented keys. No timing is asserted."""

import json_contract
from rich.console import Console

from palpate_lab.verify.bench import sweep


def test_sweep_has_the_documented_keys_and_equal_numbers_on_one_and_two_processes():
    progress = []
    result = sweep.run(60, turns=1, many=2, on_progress=progress.append)
    assert set(result) == json_contract.keys("bench sweep")
    assert [row["workers"] for row in result["rows"]] == [1, 2]
    assert result["identical"] is True
    assert {key for row in result["rows"] for key in row} == {"workers", "seconds", "start_s", "runs_per_s"}
    assert len(progress) == 2
    console = Console(width=120, record=True, quiet=True)
    console.print(sweep.table(result))


def test_runs_are_pressed_walls_and_some_of_them_oscillate():
    found = [sweep.wall_run({}, seed) for seed in range(40)]
    assert all(run["peak_m"] > 1e-4 for run in found)
    assert 0 < sum(run["oscillates"] for run in found) < 40
