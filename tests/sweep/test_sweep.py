"""Sweeps return identical numbers from every executor, in any order, and with killed workers."""

import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import sweep_points

from palpate.base.errors import SweepError
from palpate.base.sweep import Axis, sweep
from palpate.base.sweep.grid import Grid
from palpate.base.sweep.queue import Queue
from palpate.base.sweep.work import Work, seed_of

GRID = {"K": Axis(np.linspace(100.0, 400.0, 7), "N/m", "stiffness"), "law": ["a", "bc"], "k": range(3)}


@pytest.fixture(scope="module")
def expected():
    return sweep(sweep_points.draw, GRID, 5, "serial")


def test_local_executor_matches_the_serial_executor(expected, tmp_path):
    found = sweep(sweep_points.draw, GRID, 5, workers=3)
    assert found.rows() == expected.rows()
    found.to_netcdf(tmp_path / "a.nc")
    expected.to_netcdf(tmp_path / "b.nc")
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_a_dataclass_gives_the_rows_of_the_same_dictionary(expected):
    assert sweep(sweep_points.draw_typed, GRID, 5, "serial").rows() == expected.rows()


def test_what_is_no_named_value_names_the_function_and_no_file_of_palpate():
    failed = sweep(_unnamed, {"k": [1]}, executor="serial", on_error="keep")
    assert failed.errors[0].startswith("TypeError: fn returned a float")
    assert "palpate" not in failed.errors[0].partition(";")[2]


def _unnamed(point, seed):
    return 1.0


def test_points_are_in_row_major_order(expected):
    points = [(K, law, k) for K in np.linspace(100.0, 400.0, 7) for law in ("a", "bc") for k in range(3)]
    assert [(r["K"], r["law"], r["k"]) for r in expected.rows()] == points


def test_seeds_match_numpy_and_are_distinct():
    child = np.random.SeedSequence(5, spawn_key=(17,)).generate_state(1, np.uint64)[0]
    assert seed_of(5, 17) == int(child) // 2
    assert len({seed_of(seed, index) for seed in range(20) for index in range(500)}) == 10_000
    assert max(seed_of(0, index) for index in range(1000)) < 2**63


def test_points_left_out_keep_the_seeds_of_the_others(expected):
    some = sweep(sweep_points.draw, GRID, 5, "serial", where=lambda p: p["law"] == "bc" and p["K"] > 200)
    assert 0 < len(some.rows()) < len(expected.rows())
    assert all(row in expected.rows() for row in some.rows())
    assert np.isnan(some.array("x")[:, 0]).all()


def calls(folder: Path) -> list[int]:
    return [int(k) for file in folder.iterdir() for k in file.read_text().split()]


def test_killed_worker_loses_no_point(tmp_path):
    grid = {"k": range(120), "folder": [str(tmp_path)]}

    def kill_one() -> None:
        while len(calls(tmp_path)) < 40:
            time.sleep(0.01)
        os.kill(int(next(tmp_path.iterdir()).name), signal.SIGKILL)

    killer = threading.Thread(target=kill_one)
    killer.start()
    found = sweep(sweep_points.slow, grid, 7, workers=2)
    killer.join()
    assert sorted(set(calls(tmp_path))) == list(range(120))
    assert len(calls(tmp_path)) <= 123  # only the points that the killed worker had not transferred are repeated
    assert found.rows() == [
        p | {"x": seed_of(7, k) % 1000 + k} for k, p in enumerate(map(Grid.of(grid).point, range(120)))
    ]


def test_workers_end_with_a_killed_parent_also_within_a_point(tmp_path):
    code = (
        "import sweep_points\n"
        "from palpate.base.sweep import sweep\n"
        "if __name__ == '__main__':\n"
        f"    sweep(sweep_points.endless, {{'k': range(2), 'folder': [{str(tmp_path)!r}]}}, workers=2)\n"
    )
    script = tmp_path / "sweeping.py"
    script.write_text(code)
    here = str(Path(__file__).parent) + os.pathsep + str(Path(sweep_points.__file__).parent)
    parent = subprocess.Popen([sys.executable, script], env=os.environ | {"PYTHONPATH": here})
    try:
        _until(lambda: len(list(tmp_path.glob("[0-9]*"))) == 2)
    finally:
        parent.kill()
        parent.wait()
    workers = [int(file.name) for file in tmp_path.glob("[0-9]*")]
    _until(lambda: not any(map(_runs, workers)))


def _until(holds):
    due = time.monotonic() + 60.0
    while not holds():
        assert time.monotonic() < due
        time.sleep(0.02)


def _runs(process):
    """True while a process exists and has not ended."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_point_that_kills_every_worker_is_reported_as_failed():
    found = sweep(sweep_points.deadly, {"k": range(8)}, workers=2, on_error="keep")
    assert [row["k"] for row in found.rows()] == [0, 1, 2, 4, 5, 6, 7]
    assert found.errors == {3: "its worker process died in each attempt (was killed by SIGKILL)"}


@pytest.mark.parametrize("executor", ["serial", "local"])
def test_exception_names_its_points_and_its_location(executor):
    with pytest.raises(SweepError) as failure:
        sweep(sweep_points.picky, {"k": range(8)}, executor=executor)
    text = str(failure.value)
    assert "sweep_points.picky: 2 of 8 points failed" in text
    assert "at k = 2 (seed " in text
    assert "ValueError: no 5 today" in text
    assert "sweep_points.py:" in text


def test_too_many_failures_stop_the_sweep():
    with pytest.raises(SweepError, match=r"20 of 1000 points failed, 980 not tried[\s\S]*and 15 more"):
        sweep(partial(sweep_points.picky), {"k": [2], "n": range(1000)}, executor="serial")


def test_queue_returns_every_point_with_shrinking_chunks():
    queue, taken = Queue(range(1000), 2), []
    while queue:
        chunk = queue.take()
        queue.took(len(chunk), 1e-4 * len(chunk))
        taken.append(chunk)
    assert [k for chunk in taken for k in chunk] == list(range(1000))
    sizes = [len(chunk) for chunk in taken]
    assert sizes[0] == 1
    assert max(sizes) == 249
    assert sizes[1:] == sorted(sizes[1:], reverse=True)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"fn": lambda point, seed: {}}, "fn cannot be sent to worker processes"),
        ({"executor": "slurm"}, "unknown executor 'slurm'"),
        ({"address": "tcp://x:1"}, "address tcp://x:1 does not apply to executor 'local'"),
        ({"workers": 0}, "workers must be at least 1, got 0"),
        ({"grid": {"k": []}}, "axis 'k' cannot be swept"),
        ({"grid": {"k": [1, 1]}}, "it contains a value twice"),
        ({"grid": {"k": [1, "a"]}}, "axis 'k' mixes numbers and texts"),
        ({"grid": {"k": [float("nan")]}}, "axis 'k' has the value nan"),
        ({"fn": sweep_points.__dict__["Path"], "executor": "serial"}, "TypeError"),
    ],
)
def test_invalid_arguments_are_rejected(arguments, message):
    with pytest.raises(SweepError, match=message):
        sweep(**{"fn": sweep_points.picky, "grid": {"k": [0]}, **arguments})


def test_script_without_a_main_guard_gets_a_remedy(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "from palpate.base.sweep import sweep\ndef f(p, s): return {}\nsweep(f, {'k': range(3)}, workers=1)\n"
    )
    run = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=60)
    assert run.returncode == 1
    assert "sweep() was called inside a worker process" in run.stderr
    assert "the worker processes do not start" in run.stderr
    assert "if __name__ == '__main__':" in run.stderr


def test_workers_with_other_sources_are_rejected():
    work = Work(sweep_points.picky, Grid.of({"k": [0]}), 0, "0.0.1 (other)")
    (answer,) = pickle.loads(pickle.dumps(work)).answers([0])
    assert "the sweep was begun by 0.0.1 (other); install the same" in answer.error
