"""The JSON of `palpate bench sweep` is a contract. No timing is asserted."""

import json_contract
from rich.console import Console

from palpate.verify.bench import sweep


def test_keys_and_the_same_numbers_on_one_process_and_on_two():
    told = []
    result = sweep.run(60, turns=1, many=2, on_progress=told.append)
    assert set(result) == json_contract.keys("bench sweep")
    assert [row["workers"] for row in result["rows"]] == [1, 2]
    assert result["identical"] is True
    assert {key for row in result["rows"] for key in row} == {"workers", "seconds", "start_s", "runs_per_s"}
    assert len(told) == 2
    console = Console(width=120, record=True, quiet=True)
    console.print(sweep.table(result))


def test_the_runs_are_walls_that_are_pressed_and_some_of_them_swing():
    found = [sweep.wall_run({}, seed) for seed in range(40)]
    assert all(run["peak_m"] > 1e-4 for run in found)
    assert 0 < sum(run["oscillates"] for run in found) < 40
