"""Sweeps on a real Dask cluster: a scheduler and workers in separate processes on the loopback interface."""

import json
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import sweep_points

from palpate.base.errors import MissingExtraError, SweepError
from palpate.base.sweep import cluster, sweep
from palpate.base.sweep.work import seed_of

TESTS = str(Path(sweep_points.__file__).parent)


def test_missing_dask_names_the_extra_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingExtraError, match=r"the Dask executor is not installed[\s\S]*palpate\[dask\]"):
        sweep(sweep_points.picky, {"k": [0]}, executor="dask")


@pytest.fixture(scope="module")
def dask(tmp_path_factory):
    """Address of a scheduler with two workers, and their processes."""
    pytest.importorskip("distributed", reason="Dask is not installed: make setup")
    folder = tmp_path_factory.mktemp("dask")
    scheduler, running = folder / "scheduler.json", []

    def start(*command: str) -> None:
        arguments = [sys.executable, "-m", "distributed.cli." + command[0], *command[1:]]
        running.append(subprocess.Popen(arguments, cwd=TESTS, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))

    start("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--dashboard-address",
          "127.0.0.1:0", "--scheduler-file", str(scheduler))  # fmt: skip
    for _ in range(2):
        start("dask_worker", "--scheduler-file", str(scheduler), "--nthreads", "1", "--no-nanny", "--no-dashboard",
              "--host", "127.0.0.1", "--local-directory", str(folder))  # fmt: skip
    while not scheduler.exists() or not scheduler.read_text():
        assert running[0].poll() is None
        time.sleep(0.05)
    yield json.loads(scheduler.read_text())["address"], running[1:]
    for process in reversed(running):
        process.kill()
        process.wait()


def test_cluster_matches_the_serial_executor(dask):
    grid = {"K": [1.0, 2.0, 3.0], "law": ["a", "b"], "k": range(5)}
    found = sweep(sweep_points.draw, grid, 5, "dask", address=dask[0])
    assert found.rows() == sweep(sweep_points.draw, grid, 5, "serial").rows()


def test_an_exception_names_its_points(dask):
    with pytest.raises(SweepError, match=r"at k = 2 \(seed \d+\): ValueError: no 2 today"):
        sweep(sweep_points.picky, {"k": range(8)}, executor="dask", address=dask[0])


def test_killed_cluster_worker_loses_no_point(dask, tmp_path):
    address, workers = dask

    def kill_one() -> None:
        while len(list(tmp_path.iterdir())) < 2:  # both workers have started
            time.sleep(0.01)
        time.sleep(0.3)
        workers[0].send_signal(signal.SIGKILL)

    killer = threading.Thread(target=kill_one)
    killer.start()
    found = sweep(sweep_points.slow, {"k": range(100), "folder": [str(tmp_path)]}, 7, "dask", address=address)
    killer.join()
    assert workers[0].wait(5.0) == -signal.SIGKILL
    assert [row["x"] for row in found.rows()] == [seed_of(7, k) % 1000 + k for k in range(100)]


def test_missing_scheduler_and_missing_workers_are_reported(dask, monkeypatch):
    monkeypatch.setattr(cluster, "CONNECT_SECONDS", 0.3)
    with pytest.raises(SweepError, match=r"no Dask scheduler answers at tcp://127.0.0.1:9"):
        sweep(sweep_points.picky, {"k": [0]}, executor="dask", address="tcp://127.0.0.1:9")
    with pytest.raises(SweepError, match="no Dask scheduler answers at nonsense://x"):
        sweep(sweep_points.picky, {"k": [0]}, executor="dask", address="nonsense://x")
    monkeypatch.setattr(cluster, "WORKERS_SECONDS", 0.3)
    for worker in dask[1]:
        worker.kill()
        worker.wait()
    time.sleep(0.5)
    with pytest.raises(SweepError, match=r"has no worker[\s\S]*dask worker"):
        sweep(sweep_points.picky, {"k": [0]}, executor="dask", address=dask[0])
