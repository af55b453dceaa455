"""The haptic node with real processes: a wall is rendered, and the last wrench is zero however the node ends."""

import json
import os
import signal
import threading
import time
from itertools import count, pairwise
from pathlib import Path

import pytest

HERE = Path(__file__).parent
RATE = 125.0  # a rate that the mock master in Python reaches on a busy machine
NUMBERS = count(1)
SCENE = """
objects: [{name: wall, box: {size: [0.2, 0.2, 0.05]}, stiffness: 300, damping: 2}]
record: {report: false}
"""


class MasterOutput:
    """JSON lines that the mock master prints; `arm` is its present name, after which the lists begin anew."""

    def __init__(self, process):
        self.process, self.lines, self.arm = process, [], ""
        self.forces = []  # (stamp [s], force [N]) of every wrench so far
        self.thread = threading.Thread(target=self._read, daemon=True)
        self.thread.start()

    def _read(self):
        for line in self.process.stdout:
            if line.startswith("{"):
                self.lines.append(json.loads(line))
                if "arm" in self.lines[-1]:
                    self.lines, self.forces, self.arm = [], [], self.lines[-1]["arm"]
                elif "force" in self.lines[-1]:
                    self.forces.append((self.lines[-1]["t"], self.lines[-1]["force"]))

    def send(self, command):
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()

    def until(self, condition, description, seconds=20.0):
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, f"timeout of {seconds:g} s: {description}; {self.lines[-3:]}"
            assert self.process.poll() is None, self.process.stderr.read()
            time.sleep(0.01)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    file = tmp_path_factory.mktemp("scene") / "wall.yaml"
    file.write_text(SCENE)
    return file


@pytest.fixture(scope="module")
def masters(start_once, scene):
    """The process of the mock masters."""
    return MasterOutput(start_once(HERE / "fake_master.py", RATE, scene))


@pytest.fixture
def master(masters):
    """A mock master of a name that no other test has: a node that was killed stays in the graph for seconds."""
    wanted = f"MTM{next(NUMBERS)}"
    masters.send(f"arm {wanted}")
    masters.until(lambda: masters.arm == wanted, "the mock master starts", 60.0)
    return masters


@pytest.fixture
def node(start, scene, tmp_path, master):
    """A function that starts the haptic node with options."""

    def run(*options):
        command = ["ros", "haptics", scene, "--leader", master.arm, "--console", f"{master.arm}_console"]
        command += ["--follower", "virtual", "--rate", RATE, "--out", tmp_path / "runs"]
        return start("-m", "palpate", *command, *options)

    return run


def pressing(master, node, *options):
    """Start the node and move the tool into the wall until the force exceeds 0.5 N."""
    process = node(*(options or ("--teleop", "none")))
    master.send("operator 1")
    master.send("following 1")
    master.until(lambda: master.forces, "the node sends wrenches", 60.0)
    time.sleep(0.3)
    master.send("depth 0.3")  # the tool starts to follow at the present position of the hand
    master.until(lambda: master.forces[-1][1] > 0.5, "the wall pushes", 15.0)
    master.send("further 0.0")
    return process


def zero_after(master, t, within):
    """Check that wrenches are sent `within` [s] after t, and that all of them are zero."""
    master.until(lambda: sum(at > t + within for at, _ in master.forces) > 20, "zero wrenches are sent")
    assert not any(force for at, force in master.forces if at > t + within)


def test_wall_force_is_within_the_default_cap_and_sigterm_ends_with_zero(master, node, tmp_path):
    process = pressing(master, node)
    master.send("further 0.01")  # 3 N without the cap
    master.until(lambda: master.forces[-1][1] > 0.99, "the cap is reached")
    time.sleep(0.2)
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate(timeout=30)
    assert process.returncode == 0, err
    forces = [force for _, force in master.forces]
    assert max(forces) <= 1.0 + 1e-9, "the cap for real arms"
    assert forces[-1] == 0.0
    assert max(b - a for a, b in pairwise(forces)) <= 50.0 / RATE * 1.5 + 1e-9
    flags = {line["flag"]: line["on"] for line in master.lines if "flag" in line}
    assert flags == {"body/set_cf_orientation_absolute": True, "use_gravity_compensation": True}
    (record,) = (tmp_path / "runs").glob("*/record.mcap")
    from palpate.record.reader import Record

    assert Record.open(record).ticks["depth"].max() > 1e-3
    assert master.arm in out


def test_wrench_is_zero_when_an_external_teleoperation_stops_following(master, node):
    process = pressing(master, node, "--teleop", f"{master.arm}_PSM1")
    master.send("following 0")
    t = time.time()
    zero_after(master, t, 0.15)  # up to 0.1 s of it from the pipe to the message
    process.send_signal(signal.SIGINT)
    assert process.wait(30) == 0


@pytest.mark.parametrize("death", [signal.SIGKILL, pytest.param(signal.SIGSTOP, marks=pytest.mark.long)])
def test_guardian_sends_zero_wrenches_when_the_node_is_gone(master, node, death):
    process = pressing(master, node)
    before = len(master.forces)
    t = time.time()
    os.kill(process.pid, death)
    zero_after(master, t, 0.05)
    if death == signal.SIGSTOP:
        master.send("depth 0.0")
        os.kill(process.pid, signal.SIGCONT)
        master.until(lambda: master.process and len(master.forces) > before + 200, "the node comes back")
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=30)
        assert process.returncode == 0, err
    else:
        process.wait(10)


def test_node_without_its_guardian_ends_with_zero(master, node):
    process = pressing(master, node)
    task = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    (guardian,) = (int(p) for p in task if "palpate.ros.guardian" in Path(f"/proc/{p}/cmdline").read_text())
    os.kill(guardian, signal.SIGKILL)
    t = time.time()
    said, err = process.communicate(timeout=30)
    assert process.returncode == 1, err
    assert "the guardian process has died: the force was set to zero" in said
    assert not any(force for at, force in master.forces if at > t + 0.2)


def test_two_nodes_on_one_arm_send_no_force(master, node):
    first = pressing(master, node)
    second = node("--teleop", "none")
    while "force cap" not in second.stdout.readline():
        assert second.poll() is None, second.stderr.read()
    master.until(lambda: not any(force for _, force in master.forces[-500:]), "each node finds the other", 60.0)
    time.sleep(1.0)
    assert not any(force for _, force in master.forces[-500:]), "the wrenches stay zero"
    for process in (first, second):
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=30)
        assert process.returncode == 0, err


def test_own_teleoperation_is_inactive_while_another_one_is_on(master, node):
    master.send("teleop ENABLED")
    process = node("--teleop", "none", "--duration", 3)
    master.send("operator 1")
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert "another teleoperation" in out
    assert not master.forces, "no wrench is sent"


def test_silent_master_gets_no_force(master, node):
    process = pressing(master, node)
    master.send("silent 1")
    t = time.time()
    zero_after(master, t, 0.2)
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate(timeout=30)
    assert process.returncode == 0, err
    assert "the leader is silent" in out
