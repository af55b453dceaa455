"""One hand on an arm of ROS 2, the other on a device: one session, one console, instruments that meet."""

import json
import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest
from test_two_hands_on_sim import CAP, RATE, Client, scene_text

from palpate.base.errors import DeviceError, PalpateError, StateError
from palpate.record.reader import Record
from palpate.scene import Scene
from palpate.session import PairsSession


class Handle:
    """A device that rests where it is put, and keeps every wrench."""

    rate, force_max, workspace = 500.0, 5.0, (0.2, 0.2, 0.2)

    def __init__(self):
        self.x, self.written = 0.0, []

    def open(self):
        """Nothing to open."""

    def read(self):
        """The pose in the axes of the device's base."""
        X = np.eye(4)
        X[0, 3] = self.x
        return X

    def write(self, wrench):
        """Keep a wrench."""
        self.written.append(np.array(wrench[:3]))

    def close(self):
        """Nothing to close."""


def mixed(**left):
    """The scene of two hands, whose left one is on a `Handle`."""
    data = Scene.parse(scene_text()).model_dump(mode="json", exclude_unset=True)
    hand = data["pairs"]["left"]
    del hand["devices"]
    hand["arms"]["leader"] = {"driver": f"{__name__}:Handle"}
    hand.update(left)
    return Scene.model_validate(data).with_origin("", {}, trust=True)


@pytest.fixture(scope="module")
def client(built):
    """A homed robot in this process, whose head sensor reports the operator, and its client."""
    from std_msgs.msg import Empty

    from palpate.ros import sim

    robot = sim.start(("MTMR", "PSM1"), rate=RATE, head_sensor=True)
    with Client(int(os.environ["ROS_DOMAIN_ID"])) as client:
        client.publish("/system/power_on", Empty())
        client.publish("/system/home", Empty())
        client.wait(lambda: all(client.homed.get(arm) for arm in ("MTMR", "PSM1")), "both arms homed")
        yield client
    robot.stop()


@pytest.fixture
def pairs(client, tmp_path):
    """Both pairs, following."""
    from palpate.ros.haptics import Limits
    from palpate.ros.pairs import plants_of
    from palpate.ros.pedal_topics import PedalTopics

    scene = mixed()
    plants = plants_of(scene, Limits(CAP, RATE))
    assert list(plants) == ["right"]
    with (
        PairsSession(scene, tmp_path, plants=plants) as pairs,
        PedalTopics(pairs.console, plants["right"].loop.context.domain),
    ):
        with pytest.raises(StateError, match="MTMR"):
            pairs.step()
        pairs.start()
        client.press("/console/emulate_operator_present")
        client.wait(lambda: len(client.forces["right"]) > 20, "wrenches on the arm")
        yield pairs


def test_an_arm_and_a_device_push_each_other_and_end_apart(client, pairs):
    right, left = pairs.pairs["right"], pairs.pairs["left"]
    assert (right.rate, left.rate) == (RATE, 500.0)
    handle = left.plant.driver

    def push(least):
        for _ in range(400):
            handle.x += 0.0002 if np.linalg.norm(handle.written[-1]) < least else 0.0
            time.sleep(0.01)
            if np.linalg.norm(client.forces["right"][-1]) > 0.9 * least:
                return
        raise AssertionError((handle.x, handle.written[-1], client.forces["right"][-1]))

    push(0.3)
    arm, device = np.array(client.forces["right"][-1]), handle.written[-1]
    assert arm[0] > 0.1, "the arm is pushed back to its own side"
    assert np.linalg.norm(arm + device) < 0.1 * np.linalg.norm(arm), "and the device as much to the other"
    assert np.linalg.norm(arm) <= CAP + 1e-9
    client.press("/console/emulate_clutch")
    client.wait(lambda: {one.state.session for one in pairs.pairs.values()} == {"clutched"}, "one console for both")
    client.press("/console/emulate_clutch", False)
    client.wait(lambda: {one.state.session for one in pairs.pairs.values()} == {"following"}, "both follow again")
    os.kill(right.plant.loop.guardian.pid, signal.SIGKILL)
    client.wait(lambda: right.ended is not None, "the end of the pair without its guardian")
    client.wait(lambda: not np.any(client.forces["right"][-1]), "zero on the arm")
    assert left.ended is None
    before = len(handle.written)
    client.wait(lambda: len(handle.written) > before + 100, "the device goes on")
    summary = pairs.close()
    assert any("right: the guardian process has died" in words for words in summary.faults), summary.faults
    records = {name: Path(one.record) for name, one in summary.pairs.items()}
    assert records["right"].parent.parent == records["left"].parent.parent, "one folder of the run"
    for file in records.values():
        assert np.linalg.norm(Record.open(file).ticks["F_instrument_W"], axis=1).max() > 0.2


def test_the_command_runs_an_arm_beside_a_device(client, start, tmp_path):
    file, out = tmp_path / "mixed.yaml", tmp_path / "out.json"
    file.write_text(mixed(arms={"leader": {"driver": "simulated"}}).to_yaml())
    options = ["--rate", RATE, "--duration", 3, "--out", tmp_path / "runs", "--json", out]
    process = start("-m", "palpate", "ros", "haptics", file, *options)
    said, err = process.communicate(timeout=90)
    assert process.returncode == 0, said + err
    assert "right: MTMR, wrenches to /MTMR/body/servo_cf" in said
    pairs = json.loads(out.read_text())["pairs"]
    assert list(pairs) == ["right", "left"]
    assert min(one["ticks"] for one in pairs.values()) > 50, "both run"
    assert pairs["right"]["ticks"] < 0.5 * pairs["left"]["ticks"], "each at its own rate"


def test_what_cannot_lead_is_refused_by_name(built):
    from palpate.ros.pairs import plants_of
    from palpate.ros.plant import CrtkPlant

    with pytest.raises(PalpateError, match="left does not name its arms"):
        plants_of(mixed(arms={}))
    with pytest.raises(PalpateError, match=r"is on MTML \(devices\) and on .*Handle \(driver\)"):
        plants_of(mixed(devices={"leader": "MTML"}))
    scene = Scene.parse(scene_text())
    with pytest.raises(DeviceError, match="both have MTMR"):
        PairsSession(scene, plants={name: CrtkPlant(scene.pair(name)) for name in scene.pairs})


def test_a_driver_that_an_arm_stands_in_for_is_named(built):
    from palpate.ros.plant import CrtkPlant

    data = {"objects": [{"shape": "organ"}], "arms": {"leader": {"driver": "simulated"}}}
    (words,) = CrtkPlant(Scene.model_validate(data)).events
    assert words == "the scene's driver simulated is not used: the hand is on MTMR"
