"""`palpate ros topic`, and the page docs/ros2.md tried as it stands: a simulated MTM pressed into a wall."""

import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

from palpate.errors import PalpateError
from palpate.ros import topic

ROOT = Path(__file__).resolve().parents[2]


def test_messages_to_plain_values_and_back(built):
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


def test_a_topic_that_nobody_has_is_told(built):
    code, _, told = palpate("ros", "topic", "echo", "/nobody/here")
    assert code == 2
    assert "nobody publishes /nobody/here" in told


def test_the_page_from_sim_to_wall(built, start, tmp_path):
    """The scene and the client of docs/ros2.md; commands of the page list, echo and hz."""
    page = (ROOT / "docs" / "ros2.md").read_text()
    (tmp_path / "wall.yaml").write_text(re.search(r"```yaml\n(.*?)```", page, re.S)[1])
    sim = start("-m", "palpate", "ros", "sim", "--arms", "MTMR", "PSM1", "--rate", "250")
    words = [
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
    haptics = start("-m", "palpate", "ros", "haptics", tmp_path / "wall.yaml", *words)
    client = start(ROOT / "examples" / "ros2_client.py")
    out, told = client.communicate(timeout=120)
    assert client.returncode == 0, told
    rows = [[float(x) for x in re.findall(r"-?\d+\.?\d*", line)] for line in out.splitlines()]
    assert len(rows) == 26
    assert all(force == 0.0 for _, _, force in rows[:15]), "nothing is felt before the wall"
    assert max(force for *_, force in rows[-6:]) > 0.3  # a busy machine may let it rest for a moment
    assert rows[-1][1] < -384.0
    heard = []
    with topic.node() as here:
        listed = dict(topic.topics(here))
        assert listed["/MTMR/measured_cp"] == "geometry_msgs/msg/PoseStamped"
        assert {"/tf", "/palpate/markers", "/diagnostics"} <= set(listed)
        assert topic.listen(here, "/MTMR/measured_cp", heard.append, 3, 10.0) == 3
        assert topic.as_plain(heard[0])["pose"]["orientation"]["w"] != 0.0
        wrenches = []
        topic.listen(here, "/MTMR/body/servo_cf", wrenches.append, None, 0.5)  # and from now on
        assert wrenches
        topic.publish(here, "/console/emulate_operator_present", "sensor_msgs/msg/Joy", "buttons: [0]", None)
        end, seen = time.monotonic() + 20.0, -1
        while seen != len(wrenches):
            assert time.monotonic() < end, "nobody is there, and wrenches are sent"
            seen = len(wrenches)
            topic.listen(here, "/MTMR/operating_state", heard.append, None, 0.5)
    assert set(topic.as_plain(wrenches[-1])["wrench"]["force"].values()) == {0.0}, "zero, and then silence"
    for process in (haptics, sim):
        process.terminate()
        assert process.wait(30) in (0, 130)
