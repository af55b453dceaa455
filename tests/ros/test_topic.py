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
    sim = start("-m", "palpate", "ros", "sim", "--arms", "MTMR", "PSM1", "--rate", "500")
    words = ["--follower", "virtual", "--teleop", "none", "--out", tmp_path / "runs", "--force-cap", "2"]
    haptics = start("-m", "palpate", "ros", "haptics", tmp_path / "wall.yaml", *words)
    client = start(ROOT / "examples" / "ros2_client.py")
    out, told = client.communicate(timeout=120)
    assert client.returncode == 0, told
    rows = [[float(x) for x in re.findall(r"-?\d+\.?\d*", line)] for line in out.splitlines()]
    assert len(rows) == 26
    assert all(force == 0.0 for _, _, force in rows[:15]), "nothing is felt before the wall"
    *_, (_, y, force) = rows
    assert force > 0.3
    assert y < -384.0
    code, listed, _ = palpate("ros", "topic", "list")
    assert code == 0
    for name in ("/MTMR/measured_cp", "/tf", "/palpate/markers", "/diagnostics"):
        assert name in listed
    code, echoed, _ = palpate("ros", "topic", "echo", "/MTMR/measured_cp", "--count", "1")
    assert code == 0
    assert "orientation" in echoed
    code, rate, _ = palpate("ros", "topic", "hz", "/MTMR/measured_cp", "--duration", "1")
    assert "average rate" in rate
    code, _, told = palpate("ros", "topic", "pub", "/console/emulate_operator_present", "sensor_msgs/msg/Joy",
                            "buttons: [0]")  # fmt: skip
    assert code == 0, told
    time.sleep(0.5)
    code, echoed, _ = palpate("ros", "topic", "echo", "/MTMR/body/servo_cf", "--count", "1")
    assert re.search(r"force:\n\s+x: -?0.0\n\s+y: -?0.0\n\s+z: -?0.0", echoed), "nobody is there: nothing is pushed"
    for process in (haptics, sim):
        process.terminate()
        assert process.wait(30) in (0, 130)
