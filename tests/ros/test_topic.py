"""`palpate ros topic`, and the commands of docs/ros2.md: a simulated MTM pressed into a wall."""

import re
import shlex
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml

from palpate.errors import PalpateError
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


def palpate(*arguments, seconds=60):
    done = subprocess.run(
        [sys.executable, "-m", "palpate", *map(str, arguments)], capture_output=True, text=True, timeout=seconds,
        check=False,
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


def test_unknown_topic_is_reported(built):
    code, _, error = palpate("ros", "topic", "echo", "/nobody/here")
    assert code == 2
    assert "nobody publishes /nobody/here" in error


def scene_of_the_page(folder):
    (folder / "wall.yaml").write_text(re.search(r"```yaml\n(.*?)```", PAGE, re.S)[1])


def test_commands_of_the_page_work_unchanged(built, start, tmp_path):
    """Three terminals; the last two commands print the force of the wall and the force on the hand."""
    scene_of_the_page(tmp_path)
    blocks = [block.replace("\\\n", " ") for block in re.findall(r"```bash\n(.*?)```", PAGE, re.S)]
    robot, node, hand = blocks[1:4]
    commands = [shlex.split(line, comments=True) for line in (robot, node)]
    processes = [start("-m", *line) for line in commands]
    assert "Ctrl-C" in [processes[0].stdout.readline() for _ in range(2)][-1]
    assert "force cap 1 N" in [processes[1].stdout.readline() for _ in range(2)][-1]
    time.sleep(1.0)
    outputs = []
    for line in hand.splitlines():
        code, out, err = palpate(*shlex.split(line, comments=True)[1:])
        assert code == 0, (line, err)
        outputs.append(out)
        if "home" in line or "hand/servo_cp" in line:
            time.sleep(6.0)  # time in which a user reads
    push, felt = (yaml.safe_load(out.split("---")[0])["wrench"]["force"] for out in outputs[-2:])
    assert push["y"] > 0.3
    assert abs(felt["y"] - push["y"]) < 0.6
    for process in reversed(processes):
        process.terminate()
        assert process.wait(30) in (0, 130)


def test_page_from_the_simulation_to_the_wall(built, start, tmp_path):
    """The scene and the client of docs/ros2.md; commands of the page list, echo and hz."""
    scene_of_the_page(tmp_path)
    sim = start("-m", "palpate", "ros", "sim", "--arms", "MTMR", "PSM1", "--rate", "250")
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
        "250",
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
        assert process.wait(30) in (0, 130)
