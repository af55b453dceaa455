"""`palpate bench ros`: pairing of states and wrenches at given times, and one short run of the command."""

import io
import json
import os
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path

import json_contract
import numpy as np
import pytest
from rich.console import Console

from palpate.cli import main
from palpate.ros import build
from palpate_lab.verify.bench import ros_discovery, ros_faults
from palpate_lab.verify.bench.ros import answers
from palpate_lab.verify.bench.ros_discovery import figures


def felt(rows):
    """Rows as of the MockLeader from (received, stamped) times, with equal clocks."""
    out = np.zeros((len(rows), 10))
    out[:, 0], out[:, 2] = [r[0] for r in rows], [r[1] for r in rows]
    return out


def test_each_state_is_paired_with_its_wrench():
    sent = np.array([0.0, 1e-3, 2e-3, 3e-3])
    rows = [(1.0e-4, 0.8e-4), (1.2e-3, 1.15e-3), (2.9e-3, 2.8e-3), (3.1e-3, 3.05e-3)]
    took, late = answers(sent, felt(rows), 0.0)
    np.testing.assert_allclose(took, [1e-4, 2e-4, 9e-4, 1e-4], atol=1e-12)
    assert late == 0


def test_wrench_after_the_next_state_counts_for_the_first():
    """A wrench stamped 5 us after the second state cannot depend on it."""
    sent = np.array([0.0, 1e-3, 2e-3])
    took, late = answers(sent, felt([(1.02e-3, 1.005e-3), (2.1e-3, 2.05e-3)]), 0.0)
    np.testing.assert_allclose(took, [1.02e-3, 1e-4], atol=1e-12)
    assert late == 1


def test_clocks_are_aligned_and_repeats_count_once():
    sent = np.array([5.0, 5.001])
    rows = felt([(5.0001, 1e9 + 5.00008), (5.0005, 1e9 + 5.0004), (5.0012, 1e9 + 5.0011)])
    took, late = answers(sent, rows, 1e9)
    np.testing.assert_allclose(took, [1e-4, 2e-4], atol=1e-6)
    assert late == 0


def test_command_measures_and_has_the_documented_keys(built, tmp_path, capsys):
    file = tmp_path / "ros.json"
    assert main(["bench", "ros", "--duration", "1.5", "--rate", "250", "--json", str(file)]) == 0
    report = json.loads(file.read_text())
    assert set(report) | {"sim_cores", "sim_rate_hz"} == json_contract.keys("bench ros")
    assert report["states"] == pytest.approx(375, rel=0.2)
    assert report["lost"] == 0
    assert abs(report["echo_lost"]) < 0.1 * report["echoes"]  # those in transit at both ends
    assert 0.0 < report["echo_p50_us"] < report["echo_max_us"]
    assert 0.0 < report["latency_p50_us"] < report["latency_max_us"]
    assert report["force_N"] > 0.1
    assert "bare echo" in capsys.readouterr().out


def test_discovery_figures_are_percentiles_of_the_clients_and_compare_with_the_control():
    robot = [{"ready_s": 0.1, "pose_s": 0.2 + 0.001 * k, "command_s": 0.3, "lost": 2, "dropped": 3} for k in range(101)]
    control = [{"ready_s": 0.1, "pose_s": 0.1, "command_s": 0.6, "lost": 0, "dropped": 9} for _ in range(101)]
    seen = figures(robot, control, 7)
    assert seen["pose_p50_s"] == pytest.approx(0.25)
    assert seen["pose_p95_s"] == pytest.approx(0.295)
    assert seen["pose_max_s"] == pytest.approx(0.3)
    assert seen["ratio"] == pytest.approx(2.95), "the worse of both directions"
    assert (seen["starts"], seen["topics"], seen["lost"], seen["control_lost"]) == (101, 7, 2.0, 0.0)
    assert (seen["dropped"], seen["control_dropped"]) == (3.0, 9.0)


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


def announcements(domain, count, process):
    """What the participant of a process sends to an unused address of its domain: pairs of time [s] and message.

    RTPS 2.5, table 9.8 and section 9.6.2.3: participant 30 listens at 7400 + 250 * domain + 10 + 2 * 30. Others on
    this machine may use the same domain: Fast DDS writes the number of a process into the identifier of a participant.
    """
    number = struct.pack("<H", process.pid & 0xFFFF)
    heard = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 7400 + 250 * domain + 10 + 2 * 30))
        sock.settimeout(30.0)
        while len(heard) < count:
            message = sock.recv(65536)
            if message.startswith(b"RTPS") and message[12:14] == number:
                heard.append((time.monotonic(), message))
    return heard


def parameters(message):
    """Identifiers and values of the parameters in a message's DATA submessages (RTPS 2.5, 9.4.2.11 and 9.4.5)."""
    found, at = [], 20
    while at + 4 <= len(message):
        kind, _, length = struct.unpack_from("<BBH", message, at)
        at += 4
        if kind == 0x15:  # DATA; its parameters follow the header and the encapsulation
            here = at + 4 + struct.unpack_from("<H", message, at + 2)[0] + 4
            while here + 4 <= at + length:
                identifier, size = struct.unpack_from("<HH", message, here)
                found.append((identifier, message[here + 4 : here + 4 + size]))
                here += 4 + size
        at += length
    return found


ROBOT = """
import sys
from palpate import ros
ros = ros.load()
leader = ros.MockLeader(ros.Context(domain=int(sys.argv[1])), ros.MockLeaderOptions())
sys.stdin.read()
leader.stop()
"""


def test_robot_announces_itself_often_and_offers_udp_alone(start, monkeypatch, tmp_path):
    """Fast DDS's own interval is 3 s, for which a client waits that missed the answer to its first announcement.

    Fast DDS reads its profile once in a process, so each robot has a process of its own. The second one, with a profile
    of the user, has Fast DDS's defaults.
    """
    domain = (int(os.environ["ROS_DOMAIN_ID"]) + 50) % 102
    robot = start("-c", ROBOT, domain)
    heard = announcements(domain, 12, robot)  # the first ones follow each other quickly in any case
    robot.kill()
    robot.wait()
    assert np.median(np.diff([when for when, _ in heard][6:])) < 1.0
    assert offered(heard[-1][1]) == ({UDP}, False)

    mine = tmp_path / "mine.xml"
    mine.write_text('<dds xmlns="http://www.eprosima.com"><profiles/></dds>')
    monkeypatch.setenv("FASTDDS_DEFAULT_PROFILES_FILE", str(mine))
    other = start("-c", ROBOT, (domain + 1) % 102)
    kinds, types = offered(announcements((domain + 1) % 102, 1, other)[0][1])
    assert UDP in kinds
    assert len(kinds) == 2, "Fast DDS offers shared memory, where it is not asked to leave it"
    assert types, "Fast DDS offers types, where it is not asked to leave them"


UDP = 1
"""LOCATOR_KIND_UDPv4 (RTPS 2.5, table 9.4)."""


def offered(announcement):
    """The kinds of a participant's default locators, and whether it has Fast DDS's service that looks up types."""
    locators = [value for identifier, value in parameters(announcement) if identifier == 0x31]
    built_in = next(value for identifier, value in parameters(announcement) if identifier == 0x58)
    kinds = {struct.unpack_from("<i", value)[0] for value in locators}
    return kinds, bool(struct.unpack("<I", built_in)[0] >> 12 & 15)


PROFILE = """
import os, sys
from palpate import ros
from palpate.ros import build
ros = ros.load()
leader = ros.MockLeader(ros.Context(domain=int(sys.argv[1])), ros.MockLeaderOptions())
print(*(os.environ[name] for name in build.PROFILES if name in os.environ))
leader.stop()
"""


@pytest.mark.parametrize("mine", [None, "mine.xml"])
def test_profile_has_no_error_and_one_of_the_user_stays(mine):
    """Fast DDS would ignore a profile with an error, and print a message."""
    domain = (int(os.environ["ROS_DOMAIN_ID"]) + 50) % 102
    environment = {k: v for k, v in os.environ.items() if k not in build.PROFILES}
    environment |= {build.PROFILES[0]: mine} if mine else {}
    done = subprocess.run([sys.executable, "-c", PROFILE, str(domain)], env=environment, capture_output=True, text=True,
                          timeout=60, check=True)  # fmt: skip
    file = done.stdout.strip().splitlines()[-1]
    assert Path(file).name == (mine or "discovery.xml")
    assert ("XMLPARSER" in done.stdout + done.stderr) == bool(mine), "mine.xml does not exist"


def test_full_sockets_are_counted():
    """A socket that nobody reads drops what does not fit."""
    before = ros_discovery._dropped()
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as full,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out,
    ):
        full.bind(("127.0.0.1", 0))
        for _ in range(1000):
            out.sendto(bytes(2000), full.getsockname())
    assert ros_discovery._dropped() - before >= 100


def test_the_worst_try_after_a_fault_is_told_and_late_ones_are_counted():
    row = ros_faults.row("silence", [0.012, 0.051, 0.013, 0.014], 49.0)
    assert row == {"fault": "silence", "median_s": 0.0135, "worst_s": 0.051, "late": 1, "steepest_N_s": 49.0}
    result = {"rate_hz": 1000.0, "tries": 4, "asked_s": 0.05, "load": 0.5, "faults": [row]}
    assert set(result) == json_contract.keys("bench ros --faults")
    console = Console(width=120, record=True, file=io.StringIO())
    console.print(ros_faults.table(result))
    assert "51.0 ms" in console.export_text()


@pytest.mark.long
def test_stops_of_planned_motions_are_measured_on_the_simulated_arm(built):
    pytest.importorskip("ompl", reason="motion planning needs the extra planning")
    from palpate_lab.verify.bench import execution_ros

    rows = execution_ros.run(1)
    assert [row["mode"] for row in rows] == ["ROS 2, servo_jp", "ROS 2, move_jp"]
    for row in rows:
        assert row["speed_m_s"] > 0.08
        assert row["goal_worst_s"] <= row["slow_worst_s"]
