"""ROS 2 for tests: a domain of this session, this machine alone, one build for all, processes ended by their id."""

from __future__ import annotations

import contextlib
import fcntl
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from palpate.errors import RosMissingError
from palpate.ros import where

try:
    where.find()
except RosMissingError as missing:
    _ABSENT = " ".join(str(missing).split())
else:
    _ABSENT = ""


def pytest_collection_modifyitems(items):
    here = Path(__file__).parent
    for item in items:
        if _ABSENT and here in item.path.parents:
            item.add_marker(pytest.mark.skip(reason=_ABSENT))


@pytest.fixture(scope="session", autouse=True)
def _only_here():
    """Every process of this session, and no other, hears the others."""
    kept = dict(os.environ)
    os.environ["ROS_DOMAIN_ID"] = str(1 + os.getpid() % 100)  # up to 101 no port collides with the system's own
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    began = time.time()
    yield
    os.environ.clear()
    os.environ.update(kept)
    _sweep(began)


def _sweep(began):
    """Shared memory that killed processes of this session have left: nobody holds its lock any more."""
    for lock in Path("/dev/shm").glob("fastdds_*_el"):
        with contextlib.suppress(OSError), lock.open() as file:
            if lock.stat().st_mtime >= began:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                lock.with_name(lock.name.removesuffix("_el")).unlink(missing_ok=True)
                lock.unlink()


@pytest.fixture(scope="session")
def built(_only_here):
    """What `palpate ros setup` makes; parallel sessions wait for the one that compiles."""
    from palpate import ros

    return ros.messages()


@pytest.fixture(scope="session")
def native(built):
    """The compiled module."""
    from palpate import ros

    return ros.load()


@pytest.fixture(scope="session")
def rclpy(built):
    """ROS 2 in this process, for what a test says and hears."""
    import rclpy

    rclpy.init()
    yield rclpy
    rclpy.shutdown()


@pytest.fixture
def node(rclpy):
    """A node of the test."""
    node = rclpy.create_node(f"test_{os.getpid()}")
    yield node
    node.destroy_node()


@pytest.fixture
def until(rclpy, node):
    """Spins the node until something is true; fails, in words, when it does not come."""

    def wait(condition, what, seconds=10.0):
        end = time.monotonic() + seconds
        while not (value := condition()):
            assert time.monotonic() < end, f"within {seconds:g} s not: {what}"
            rclpy.spin_once(node, timeout_sec=0.01)
        return value

    return wait


class Processes:
    """Python processes of a test: they end with it, by their id."""

    def __init__(self, folder):
        self._folder, self._running = folder, []

    def start(self, *arguments, **more) -> subprocess.Popen:
        """Python with these arguments."""
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        command = [sys.executable, *map(str, arguments)]
        process = subprocess.Popen(command, cwd=self._folder, **(pipes | more))
        self._running.append(process)
        return process

    def end(self):
        """All of them."""
        for process in self._running:
            if process.poll() is None:
                process.send_signal(signal.SIGCONT)
                process.terminate()
                try:
                    process.wait(10)
                except subprocess.TimeoutExpired:
                    process.kill()
                    process.wait()
            for pipe in (process.stdin, process.stdout, process.stderr):
                if pipe:
                    pipe.close()


@pytest.fixture
def start(built, tmp_path):
    """Starts Python with these arguments; what still runs at the end is ended."""
    processes = Processes(tmp_path)
    yield processes.start
    processes.end()


@pytest.fixture(scope="module")
def start_once(built, tmp_path_factory):
    """The same for what all tests of a file share."""
    processes = Processes(tmp_path_factory.mktemp("processes"))
    yield processes.start
    processes.end()


@pytest.fixture(scope="module")
def sim(start_once):
    """`palpate ros sim` with a pair of arms at 500 Hz, shared by the tests of a file."""
    process = start_once("-m", "palpate", "ros", "sim", "--arms", "MTMR", "PSM1", "--rate", "500")
    told = []
    for line in process.stdout:
        told.append(line)
        if "Ctrl-C" in line:
            return process
    pytest.fail("".join([*told, process.stderr.read()]))
