"""`palpate ros topic`, and the commands of docs/ros2.md: a simulated MTM pressed into a wall."""

import re
import shlex
import signal
import time
from pathlib import Path

import pytest
import yaml

from palpate.base.errors import PalpateError
from palpate.cli import main
from palpate.ros import topic

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "ros2.md").read_text()


def test_messages_survive_the_conversion_to_plain_values(built):
    from sensor_msgs.msg import JointState, Joy

    joy = Joy()
    topic.fill(joy, {"buttons": [1, 0], "axes": [0.5]})
    assert topic.as_plain(joy)["buttons"] == [1, 0]
    joints = JointState()
    plain = {"header": {"stamp": {"sec": 3, "nanosec": 4}, "frame_id": "x"}, "name": ["a"], "position": [0.25]}
    topic.fill(joints, plain)
    assert topic.as_plain(joints) == plain | {"velocity": [], "effort": []}
    with pytest.raises(PalpateError, match=r"no field 'button'[\s\S]*fields: header, axes, buttons"):
        topic.fill(joy, {"button": 1})
    with pytest.raises(PalpateError, match="does not fit"):
        topic.fill(joints, {"position": "many"})
    with pytest.raises(PalpateError, match=r"no message type 'std_msgs/msg/Boole'"):
        topic.message_type("std_msgs/msg/Boole")


def test_unknown_topic_is_reported(built, capsys, monkeypatch):
    monkeypatch.setattr(topic, "FIND", 0.3)
    assert main(["ros", "topic", "echo", "/nobody/here"]) == 2
    assert "nobody publishes /nobody/here" in capsys.readouterr().err


def await_message(here, name, accept, seconds=60.0):
    """Wait until an accepted message comes on a topic."""
    from rclpy.qos import QoSProfile, ReliabilityPolicy

    end, found = time.monotonic() + seconds, []
    while name not in (listed := dict(topic.topics(here, 0.1))):
        assert time.monotonic() < end, f"no topic {name} within {seconds:g} s"
    newest = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    heard = here.create_subscription(topic.message_type(listed[name]), name, lambda m: found.append(accept(m)), newest)
    while not any(found):
        assert time.monotonic() < end, f"no accepted message on {name} within {seconds:g} s"
        topic.spin(here, 0.05)
        time.sleep(0.02)
    here.destroy_subscription(heard)


def scene_of_the_page(folder, more=""):
    (folder / "wall.yaml").write_text(re.search(r"```yaml\n(.*?)```", PAGE, re.S)[1] + more)


def test_commands_of_the_page_work_unchanged(built, start, tmp_path, capsys):
    """Four terminals; the last two commands print the force of the wall and the force on the hand."""
    scene_of_the_page(tmp_path, "record: {report: true}\n")
    blocks = [block.replace("\\\n", " ") for block in re.findall(r"```bash\n(.*?)```", PAGE, re.S)]
    robot, node, hand, felt_by_hand = blocks[1:5]
    commands = [shlex.split(line, comments=True) for line in (robot, node)]
    processes = [start("-m", *line) for line in commands]
    assert "Ctrl-C" in [processes[0].stdout.readline() for _ in range(2)][-1]
    assert "force cap 1 N" in [processes[1].stdout.readline() for _ in range(2)][-1]

    def run(line):
        capsys.readouterr()
        assert main(shlex.split(line, comments=True)[1:]) == 0, (line, capsys.readouterr().err)
        return capsys.readouterr().out

    def pushed(line):
        return yaml.safe_load(run(line).split("---")[0])["wrench"]["force"]["y"]

    *commands, holding = hand.splitlines()
    push, felt = felt_by_hand.splitlines()
    with topic.node() as here:  # a user reads what happens before the next command
        for line in commands:
            run(line)
            if "home" in line:
                await_message(here, "/MTMR/measured_cp", lambda m: abs(m.pose.position.y + 0.3645) < 1e-3)
            if "operator_present" in line:
                await_message(here, "/diagnostics", lambda m: m.status[0].message == "free to push")
        assert "hand/servo_cp" in holding
        processes.append(start("-m", *shlex.split(holding, comments=True)))
        await_message(here, "/MTMR/body/servo_cf", lambda m: m.wrench.force.y > 0.3)
        time.sleep(1.0)  # the handle comes to rest
    pushes = [pushed(push)]
    while pushes[-1] == 0.0 and len(pushes) < 10:  # a busy machine pauses the force
        pushes.append(pushed(push))
    assert pushes[-1] > 0.3
    assert abs(pushed(felt) - pushes[-1]) < 0.6
    for process in reversed(processes):
        process.send_signal(signal.SIGINT)
        assert process.wait(90) in (0, 130)
    assert list(tmp_path.glob("runs/*/report.html"))


def test_page_from_the_simulation_to_the_wall(built, start, tmp_path):
    """The scene and the client of docs/ros2.md; commands of the page list, echo and hz."""
    scene_of_the_page(tmp_path, "record: {report: false}\n")
    sim = start("-m", "palpate", "ros", "sim", "--arms", "MTMR", "PSM1", "--rate", "125")
    options = [
        "--follower",
        "virtual",
        "--teleop",
        "none",
        "--out",
        tmp_path / "runs",
        "--force-cap",
        "2",
        "--rate",
        "125",
    ]
    haptics = start("-m", "palpate", "ros", "haptics", tmp_path / "wall.yaml", *options)
    client = start(ROOT / "examples" / "ros2_client.py")
    out, error = client.communicate(timeout=120)
    assert client.returncode == 0, error
    rows = re.findall(r"^hand goal +(\d+) mm: handle at y = (-[\d.]+) mm, pushed by (-?[\d.]+) N; \w.*$", out, re.M)
    rows = [[float(x) for x in row] for row in rows]
    assert len(rows) == len(out.splitlines()) >= 20
    assert all(force == 0.0 for _, _, force in rows[:15]), "no force before the wall"
    assert rows[-1][2] > 0.5
    assert rows[-1][1] < -384.0
    heard = []
    with topic.node() as here:
        listed, end = dict(topic.topics(here)), time.monotonic() + 20.0
        while not {"/tf", "/palpate/markers", "/diagnostics", "/MTMR/measured_cp"} <= set(listed):
            assert time.monotonic() < end, listed
            time.sleep(0.1)
            listed = dict(topic.topics(here))
        assert listed["/MTMR/measured_cp"] == "geometry_msgs/msg/PoseStamped"
        assert topic.listen(here, "/MTMR/measured_cp", heard.append, 3, 10.0) == 3
        assert topic.as_plain(heard[0])["pose"]["orientation"]["w"] != 0.0
        wrenches = []
        topic.listen(here, "/MTMR/body/servo_cf", wrenches.append, None, 0.5)  # the subscription stays active
        assert wrenches
        topic.publish(here, "/console/emulate_operator_present", "sensor_msgs/msg/Joy", "buttons: [0]", None)
        end, seen = time.monotonic() + 20.0, -1
        while seen != len(wrenches):
            assert time.monotonic() < end, "wrenches are sent without an operator"
            seen = len(wrenches)
            topic.listen(here, "/MTMR/operating_state", heard.append, None, 0.5)
    assert set(topic.as_plain(wrenches[-1])["wrench"]["force"].values()) == {0.0}, "the last wrench is zero"
    for process in (haptics, sim):
        process.terminate()
        assert process.wait(90) in (0, 130)
