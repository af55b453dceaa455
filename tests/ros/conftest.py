"""ROS 2 for tests: a domain for this session on this machine, one build, and processes that are ended by their id."""

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
import warm

from palpate.base.errors import RosMissingError
from palpate.ros import build, where

try:
    where.find()
except RosMissingError as missing:
    _ABSENT = " ".join(str(missing).split())
else:
    _ABSENT = ""


LONGEST = (
    "test_move.py",
    "test_faults.py",
    "test_haptics_node.py",
    "test_topic.py",
    "test_teleop_on_sim.py",
    "test_patient_side.py",
    "test_no_allocation.py",
    "test_two_hands_on_sim.py",
    "test_bench_ros.py",
    "test_sim.py",
    "test_wheel.py",
)
"""They come first, so that the workers end at about the same time. The wheel's first run has a bound on its time, and
would exceed it beside the compilation of the nodes."""


def pytest_collection_modifyitems(items):
    here = Path(__file__).parent
    for item in items:
        if _ABSENT and here in item.path.parents:
            item.add_marker(pytest.mark.skip(reason=_ABSENT))
    items.sort(key=lambda item: LONGEST.index(item.path.name) if item.path.name in LONGEST else len(LONGEST))


def _domain():
    """ROS domain of this session, 1 to 100: up to 101 no port collides with system ports.

    Those of the workers of one run are 37 or 74 apart: some tests use domains that are 1, 30 or 50 apart.
    """
    worker = os.environ.get("PYTEST_XDIST_WORKER", "")
    return 1 + (os.getppid() + 37 * int(worker[2:]) if worker else os.getpid()) % 100


@pytest.fixture(scope="session", autouse=True)
def _own_domain():
    """Only the processes of this session discover each other."""
    kept = dict(os.environ)
    os.environ["ROS_DOMAIN_ID"] = str(_domain())
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    began = time.time()
    yield
    os.environ.clear()
    os.environ.update(kept)
    _sweep(began)


@pytest.fixture(scope="module", autouse=True)
def _warm_processes(_own_domain):
    """Processes of Python start without importing Palpate, which takes most of the time of many tests."""
    with warm.processes():
        yield


def _sweep(began):
    """Remove shared memory of killed processes of this session, whose locks are free."""
    for lock in Path("/dev/shm").glob("fastdds_*_el"):
        with contextlib.suppress(OSError), lock.open() as file:
            if lock.stat().st_mtime >= began:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                lock.with_name(lock.name.removesuffix("_el")).unlink(missing_ok=True)
                lock.unlink()


@pytest.fixture(scope="session")
def built(_own_domain):
    """The result of `palpate ros setup`; parallel sessions wait for the one that compiles."""
    from palpate import ros

    return ros.messages()


@pytest.fixture(scope="session")
def native(built):
    """The compiled module."""
    from palpate import ros

    return ros.load()


@pytest.fixture(scope="session")
def rclpy(built):
    """The module rclpy, initialised in this process, which announces itself as often as Palpate's own processes."""
    import rclpy

    build.speed_up_discovery(where.find())

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
    """A function that spins the node until a condition holds, and fails with a description after a timeout.

    `rclpy.spin_once` adds the node to an executor and removes it, for each message: it handles about 1,500 a second,
    and a client of several topics falls seconds behind.
    """
    from rclpy.executors import SingleThreadedExecutor

    executor = SingleThreadedExecutor()
    executor.add_node(node)

    def wait(condition, description, seconds=10.0):
        end = time.monotonic() + seconds
        while not (value := condition()):
            assert time.monotonic() < end, f"timeout of {seconds:g} s: {description}"
            executor.spin_once(timeout_sec=0.01)
        return value

    yield wait
    executor.remove_node(node)


def plain_environment():
    """The variables of this process without the profile of Fast DDS that Palpate has set for it."""
    return {k: v for k, v in os.environ.items() if not (k in build.PROFILES and Path(v).parent == build.HERE)}


class Processes:
    """Python processes of a test, which are ended after it by their id."""

    def __init__(self, folder):
        self._folder, self._running = folder, []

    def start(self, *arguments, domain=None, **more) -> subprocess.Popen:
        """Start Python with these arguments, in this session's ROS domain or another one."""
        environment = plain_environment() | ({} if domain is None else {"ROS_DOMAIN_ID": str(domain)})
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        command = [sys.executable, *map(str, arguments)]
        process = subprocess.Popen(command, cwd=self._folder, **(pipes | {"env": environment} | more))
        self._running.append(process)
        return process

    def end(self):
        """End all processes."""
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
    """A function that starts Python with arguments; processes are ended after the test."""
    processes = Processes(tmp_path)
    yield processes.start
    processes.end()


@pytest.fixture(scope="module")
def start_once(built, tmp_path_factory):
    """As `start`, for processes that the tests of a file share."""
    processes = Processes(tmp_path_factory.mktemp("processes"))
    yield processes.start
    processes.end()


@pytest.fixture(scope="module")
def start_sim(start_once):
    """A function that starts `palpate ros sim` with these arms at 125 Hz, and waits until it runs."""

    def start(*arms):
        process = start_once("-m", "palpate", "ros", "sim", "--arms", *arms, "--rate", "125")
        lines = []
        for line in process.stdout:
            lines.append(line)
            if "Ctrl-C" in line:
                return process
        pytest.fail("".join([*lines, process.stderr.read()]))

    return start


@pytest.fixture(scope="module")
def sim(start_sim):
    """`palpate ros sim` with a pair of arms, shared by the tests of a file."""
    return start_sim("MTMR", "PSM1")
