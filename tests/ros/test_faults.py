"""Every fault, on real processes over ROS 2: the hand is free within 50 ms of when the fault can be known, comes back
no faster than the rate cap, it is told in words, and the record opens.

The leader is a puppet in this process (threads of C++), the node `palpate ros haptics` in one of its own. A bound on
time is judged by the best of three, for this machine may be busy; a node that is too slow is so each time.
"""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import stand as bench

from palpate.errors import PalpateError
from palpate.record import Record
from palpate.record.ticks import STATUS

HERE = Path(__file__).parent


@pytest.fixture
def node_here(node, rclpy):
    """A node of the test, beside the one that is tested."""
    here = rclpy.create_node(f"test_{os.getpid()}")
    yield here
    here.destroy_node()


@pytest.fixture(scope="module")
def stand(native):
    return bench.Stand(native, f"LEAD{os.getpid()}")


@pytest.fixture(scope="module")
def node(stand, tmp_path_factory):
    node = bench.Node(stand, tmp_path_factory.mktemp("faults"))
    stand.press(60.0)
    yield node
    if node.process.poll() is None:
        node.process.send_signal(signal.SIGCONT)
        node.process.terminate()
        node.process.wait(20)


def freed(stand, act, detectable, tries=3):
    """How long after it can be known the hand was free; the best of three."""
    took = []
    for _ in range(tries):
        stand.press()
        begin = time.monotonic()
        act()
        took.append(stand.released(begin + detectable))
        if took[-1] <= bench.MOST:
            break
    return min(took), begin


SILENT = {  # what is done to the leader's messages: (how, after how long it can be known, words)
    "silence": ({"silent": True}, bench.STALE, "the leader is silent"),
    "not a number": ({"not_finite": True}, 0.0, "a number was not finite"),
    "no rotation": ({"no_rotation": True}, 0.0, "a number was not finite"),
    "stamps of zero": ({"zero_stamp": True}, 0.0, "a stamp was zero"),
    "clock ahead": ({"clock": 1.0}, 0.0, "far from this machine's clock"),
    "clock behind": ({"clock": -1.0}, 0.0, "far from this machine's clock"),
    "delay of 100 ms": ({"delay": 0.1}, bench.STALE, "the leader is silent"),
}


@pytest.mark.parametrize("fault", SILENT)
def test_messages_that_cannot_be_believed_free_the_hand(stand, node, fault):
    how, detectable, words = SILENT[fault]
    told = len(node.told.lines)
    took, begin = freed(stand, lambda: stand.spoil(**how), detectable)
    assert took <= bench.MOST
    node.told.await_line(words, after=told)
    stand.press()
    assert stand.steepest(begin) <= 1.001 * bench.RATE_CAP


LOSSY = {
    "a fifth is lost": {"drop": 0.2},
    "some come twice": {"twice": 0.3},
    "some come out of order": {"swap": 0.3},
    "all of it": {"drop": 0.2, "twice": 0.2, "swap": 0.2},
    "joint states of wrong lengths": {"wrong_length": True},
}


@pytest.mark.parametrize("fault", LOSSY)
def test_a_bad_network_never_pushes_harder_or_faster(stand, node, fault):
    """Nothing here forbids a force: it goes on, or rests and comes back below the rate cap."""
    stand.press()
    before = stand.force()
    begin = stand.spoil(**LOSSY[fault])
    time.sleep(0.7)
    _, force = stand.held(begin)
    assert force.max() <= before + 0.1
    stand.press()
    assert stand.steepest(begin) <= 1.001 * bench.RATE_CAP


def test_an_arm_that_goes_to_fault_is_left_at_zero(stand, node):
    """The last wrench stays in force on the real arm: so the last one must be zero, though the arm takes no more."""
    told = len(node.told.lines)
    took, begin = freed(stand, lambda: stand.puppet.set_state("FAULT"), 0.0)
    assert took <= bench.MOST
    assert "is FAULT" in node.told.await_line(f"{stand.leader} is FAULT", after=told)
    stand.press()
    assert stand.steepest(begin) <= 1.001 * bench.RATE_CAP


def test_a_pedal_released_in_contact_frees_the_hand(stand, node):
    told = len(node.told.lines)
    took, begin = freed(stand, lambda: stand.puppet.follow(False), 0.0)
    assert took <= bench.MOST
    node.told.await_line("not following", after=told)
    stand.press()
    assert stand.steepest(begin) <= 1.001 * bench.RATE_CAP


def test_a_client_that_turns_the_frame_of_the_wrench_is_undone(stand, node, node_here, rclpy):
    """No force in a frame that the arm may read otherwise: free, then told anew, then on."""
    from std_msgs.msg import Bool

    topic, told = f"/{stand.leader}/body/set_cf_orientation_absolute", len(node.told.lines)
    flag = node_here.create_publisher(Bool, topic, 10)
    end = time.monotonic() + 10.0
    while flag.get_subscription_count() < 2:  # the leader and the node
        assert time.monotonic() < end, "discovery"
        time.sleep(0.01)
    took = []
    while len(took) < 3 and min(took, default=np.inf) > bench.MOST:
        stand.press()
        begin = time.monotonic()
        flag.publish(Bool(data=False))
        time.sleep(0.3)
        took.append(stand.first_free(begin))
    assert min(took) <= bench.MOST
    node.told.await_line("turned the wrench frame", after=told)
    stand.press()
    assert stand.puppet.absolute
    assert stand.steepest(begin) <= 1.001 * bench.RATE_CAP
    node_here.destroy_publisher(flag)


def test_qualities_of_service_that_do_not_fit_are_told(stand, node, node_here):
    """A listener that asks for latched wrenches gets none, and would never know why."""
    from geometry_msgs.msg import WrenchStamped
    from rclpy.qos import DurabilityPolicy, QoSProfile

    told = len(node.told.lines)
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    late = node_here.create_subscription(WrenchStamped, stand.wrench, lambda _: None, latched)
    line = node.told.await_line("durability", after=told)
    assert "does not fit ours" in line
    assert stand.wrench in line
    node_here.destroy_subscription(late)


def test_a_second_writer_stops_the_force_until_it_ends(stand, node, node_here):
    """It can be known once it is discovered and the graph is looked at, 20 times a second: 0.25 s at most."""
    from geometry_msgs.msg import WrenchStamped

    took, told = [], len(node.told.lines)
    for _ in range(3):
        stand.press()
        begin = time.monotonic()
        other = node_here.create_publisher(WrenchStamped, stand.wrench, 10)
        took.append(stand.released(begin + 0.25, seconds=3.0))
        node.told.await_line("commands the same arm", after=told)
        assert stand.force() == 0.0
        node_here.destroy_publisher(other)
        if took[-1] <= bench.MOST:
            break
    assert min(took) <= bench.MOST
    stand.press()
    assert stand.steepest(begin) <= 1.001 * bench.RATE_CAP


@pytest.mark.parametrize("pause", [0.05, 1.0])
def test_a_node_that_is_stopped_is_relieved_by_its_guardian(stand, node, pause):
    """SIGSTOP: within 20 ms of silence the guardian sends zero; what wakes up does not push on."""
    took = []
    for _ in range(3):
        stand.press()
        begin = time.monotonic()
        node.process.send_signal(signal.SIGSTOP)
        time.sleep(pause)
        stopped = time.monotonic()
        node.process.send_signal(signal.SIGCONT)
        took.append(stand.first_free(begin, stopped))
        time.sleep(0.15)
        if took[-1] <= bench.MOST:
            break
    assert min(took) <= bench.MOST
    stand.press()
    assert stand.steepest(begin) <= 1.001 * bench.RATE_CAP


def test_every_message_fault_is_in_the_record_and_the_summary(stand, node):
    """The last of this node: it ends in order, the record is whole and knows what happened."""
    summary = node.end()
    assert stand.force() == 0.0
    told = " ".join(summary["faults"])
    for words in ("not finite", "stamp was zero", "silent", "guardian took over"):
        assert words in told
    record = Record.open(summary["record"])
    assert record.complete
    status = record.ticks["status"].astype(int)
    for name in ("not_finite", "bad_stamp", "leader_stale", "not_following"):
        assert (status & STATUS[name][0]).any(), name
    force = np.linalg.norm(record.ticks["F_H_L"], axis=1)
    assert force.max() <= 1.0 + 1e-9
    growth, step = np.diff(force), np.diff(record.ticks["t"])
    assert (growth <= bench.RATE_CAP * np.minimum(step, 1.5 / bench.RATE) + 1e-6).all()


def recorded_force(out):
    """Largest in the record of a run, that may still be written; 0 without one [N]."""
    for file in out.glob("*/record.mcap"):
        with contextlib.suppress(PalpateError):
            return np.linalg.norm(Record.open(file).ticks["F_H_L"], axis=1).max(initial=0.0)
    return 0.0


def test_kill_9_of_the_node_frees_the_hand_and_leaves_a_record(stand, tmp_path):
    node = bench.Node(stand, tmp_path)
    try:
        stand.press(60.0)
        guardian = node.guardian
        end = time.monotonic() + 20.0
        while recorded_force(node.out) <= 0.1:  # what a busy machine has not written yet is lost
            assert time.monotonic() < end, "no force in the record"
            time.sleep(0.2)
        begin = time.monotonic()
        node.process.kill()
        assert stand.released(begin) <= bench.MOST
        node.told.await_line("the haptic node died")
        record = Record.open(next(node.out.glob("*/record.mcap")))
        assert not record.complete
        assert "no end" in record.note
        assert recorded_force(node.out) > 0.1
    finally:
        node.process.kill()
        node.process.wait()
    end = time.monotonic() + 10.0
    while bench.alive(guardian):
        assert time.monotonic() < end, "the guardian stays"
        time.sleep(0.05)


PUPPET = """
import json, os, sys
sys.path.insert(0, sys.argv[1])
import stand as bench
from palpate import ros
stand = bench.Stand(ros.load(), sys.argv[2])
stand.press(60.0)
print("pressed", flush=True)
sys.stdin.read()
"""


def test_kill_9_of_the_leader_ends_the_push_and_is_told(native, tmp_path):
    name = f"GONE{os.getpid()}"
    leader = subprocess.Popen(
        [sys.executable, "-c", PUPPET, str(HERE), name], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    ear = bench.Stand(native, f"EAR{os.getpid()}", wrench=f"/{name}_TELE/following/mtm/body/servo_cf")
    ear.spoil(silent=True)
    ear.leader, ear.teleop = name, f"{name}_TELE"
    node = bench.Node(ear, tmp_path)
    try:
        assert leader.stdout.readline() == "pressed\n"
        end = time.monotonic() + 10.0
        while not ear.force() > 0.1:  # whoever is new is a stranger to the node for a moment
            assert time.monotonic() < end, "nothing is felt"
            time.sleep(0.02)
        told, begin = len(node.told.lines), time.monotonic()
        leader.kill()
        assert ear.released(begin + bench.STALE) <= 2 * bench.MOST  # one try: this machine may be busy
        node.told.await_line("the leader is silent", after=told)
        summary = node.end(signal.SIGTERM)
        assert Record.open(summary["record"]).complete
    finally:
        for process in (leader, node.process):
            if process.poll() is None:
                process.kill()
            process.wait()


def test_a_network_interface_that_goes_down(tmp_path):
    """In a network of their own, whose only interface is taken down and up again. What was sent last stays in force on
    an arm without a timeout, for nobody can reach it: but the node knows, says so, and begins at zero again."""
    can = subprocess.run(["unshare", "--user", "--map-root-user", "--net", "true"], capture_output=True, check=False)
    if can.returncode and subprocess.run(["unshare", "--net", "true"], capture_output=True, check=False).returncode:
        pytest.skip("no network namespaces here (unshare --net is refused): an interface cannot be taken down")
    how = ["unshare", "--net"] if os.geteuid() == 0 else ["unshare", "--user", "--map-root-user", "--net"]
    done = subprocess.run(
        [*how, sys.executable, str(HERE / "cable.py"), str(tmp_path)], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stdout + done.stderr
    seen = json.loads(done.stdout.splitlines()[-1])
    assert seen["came_while_down"] == 0
    assert seen["told"], "the node did not say that the leader is silent"
    assert seen["first_after"] <= bench.RATE_CAP * 1.5 / bench.RATE + 1e-6
    assert seen["steepest"] <= 1.001 * bench.RATE_CAP
    assert seen["complete"]
