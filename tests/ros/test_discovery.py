"""Discovery: how soon a client and our processes find each other, and `palpate bench ros --discovery`."""

import json
import os
import socket
import time

import json_contract
import numpy as np
import pytest

from palpate.cli import main
from palpate.ros import build
from palpate.verify.bench import ros_discovery
from palpate.verify.bench.ros_discovery import figures


def test_discovery_figures_are_percentiles_of_the_clients_and_compare_with_the_control():
    robot = [{"ready_s": 0.1, "pose_s": 0.2 + 0.001 * k, "command_s": 0.3, "lost": 2} for k in range(101)]
    control = [{"ready_s": 0.1, "pose_s": 0.1, "command_s": 0.6, "lost": 0} for _ in range(101)]
    seen = figures(robot, control, 7)
    assert seen["pose_p50_s"] == pytest.approx(0.25)
    assert seen["pose_p95_s"] == pytest.approx(0.295)
    assert seen["pose_max_s"] == pytest.approx(0.3)
    assert seen["ratio"] == pytest.approx(2.95), "the worse of both directions"
    assert (seen["starts"], seen["topics"], seen["lost"], seen["control_lost"]) == (101, 7, 2.0, 0.0)


def test_discovery_beside_the_robot_and_its_control(built, tmp_path, capsys, monkeypatch):
    """Both answer, and the control has as many topics; the command prints the documented keys."""
    monkeypatch.setattr(ros_discovery, "_ALONE", 0.0)
    monkeypatch.setattr(ros_discovery, "_PAUSE", 0.0)
    file = tmp_path / "discovery.json"
    assert main(["bench", "ros", "--discovery", "--starts", "1", "--json", str(file)]) == 0
    seen = json.loads(file.read_text())
    assert set(seen) == json_contract.keys("bench ros --discovery")
    assert seen["topics"] > 300
    assert 0.0 < seen["ready_max_s"] < seen["pose_max_s"]
    assert 0.0 < seen["control_ready_max_s"] < seen["control_command_max_s"]
    assert "first command answered" in capsys.readouterr().out
    assert main(["bench", "ros", "--discovery", "--starts", "0"]) == 2


def announcements(domain, count):
    """Times at which the participants of a domain announce themselves at an unused address of it [s].

    RTPS 2.5, table 9.8 and section 9.6.2.3: participant 30 listens at 7400 + 250 * domain + 10 + 2 * 30.
    """
    times = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 7400 + 250 * domain + 10 + 2 * 30))
        sock.settimeout(30.0)
        while len(times) < count:
            if sock.recv(65536).startswith(b"RTPS"):
                times.append(time.monotonic())
    return np.array(times)


ROBOT = """
import sys
from palpate import ros
ros = ros.load()
leader = ros.MockLeader(ros.Context(domain=int(sys.argv[1])), ros.MockLeaderOptions())
sys.stdin.read()
leader.stop()
"""


def test_robot_announces_itself_often_unless_the_user_has_a_profile(start, monkeypatch):
    """Fast DDS's own interval is 3 s, for which a client waits that missed the answer to its first announcement.

    Fast DDS reads its profile once in a process, so the robot has a process of its own.
    """
    domain = (int(os.environ["ROS_DOMAIN_ID"]) + 50) % 102
    start("-c", ROBOT, domain)
    times = announcements(domain, 12)  # the first ones follow each other quickly in any case
    assert np.median(np.diff(times[6:])) < 1.0
    monkeypatch.setenv("FASTDDS_DEFAULT_PROFILES_FILE", "mine.xml")
    build.announce_often(build.where.find())
    assert os.environ["FASTDDS_DEFAULT_PROFILES_FILE"] == "mine.xml"


CLIENT = """
import os, sys, time
import rclpy
from pathlib import Path
rclpy.init()
node = rclpy.create_node("client")
end = time.monotonic() + 20.0
while len(node.get_topic_names_and_types()) < int(sys.argv[1]) and time.monotonic() < end:
    time.sleep(0.02)
mine = {os.readlink(path) for path in Path("/proc/self/fd").iterdir() if path.is_symlink()}
rows = [row.split() for row in Path("/proc/self/net/udp").read_text().splitlines()[1:]]  # inode, ..., dropped datagrams
print(len(node.get_topic_names_and_types()), sum(int(row[-1]) for row in rows if f"socket:[{row[9]}]" in mine))
os._exit(0)
"""
TOPICS = 300


def test_descriptions_of_all_topics_fit_the_receive_buffer_of_a_client(start):
    """Sent at once, they overflow it, and the rest arrives 110 ms later. A busy machine may also delay the client."""
    robot = start("-m", "palpate", "ros", "sim")
    assert any("Ctrl-C" in line for line in robot.stdout)
    lost = []
    while len(lost) < 5 and 0 not in lost:
        topics, drops = map(int, start("-c", CLIENT, TOPICS).communicate(timeout=60)[0].split())
        assert topics >= TOPICS
        lost.append(drops)
    assert 0 in lost, lost
