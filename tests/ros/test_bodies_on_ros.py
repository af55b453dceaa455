"""Rigid bodies on ROS 2: a master feels a fixed body and pushes a free one, within the cap, and ends at zero."""

import signal
import time

import numpy as np
import pytest
from test_haptics_node import master, masters, node, pressing  # noqa: F401 - fixtures

pytest.importorskip("mujoco")

from palpate.record.reader import Record

SCENE = """
objects: [{name: table, plane: {size: 0.2}, pose: {xyz: [0, 0, -0.03]}}]
bodies:
  - {name: block, fixed: true, parts: [{box: [0.1, 0.1, 0.02]}], pose: {xyz: [0, 0, -0.01]}}
  - {name: plate, mass: 0.02, parts: [{box: [0.04, 0.04, 0.004]}], pose: {xyz: [0, 0, 0.0021]}}
arms: {follower: {model: psm_prograsp, base: {xyz: [0, 0, 0.19]}}}
operator: {path: [{t: 0, xyz: [0, 0, 0.03]}, {t: 1, xyz: [0, 0, 0.03]}]}
record: {report: false}
"""


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    file = tmp_path_factory.mktemp("bodies") / "bodies.yaml"
    file.write_text(SCENE)
    return file


def test_a_master_feels_a_plate_on_a_block(master, node, tmp_path):  # noqa: F811
    process = pressing(master, node)
    time.sleep(0.2)
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate(timeout=30)
    assert process.returncode == 0, err
    forces = np.array([force for _, force in master.forces])
    assert 0.5 < forces.max() <= 1.0 + 1e-6, "within the default cap of arms on ROS 2"
    assert not forces[-3:].any(), "zero last: the node sends three"
    record = Record.open(next((tmp_path / "runs").glob("*/record.mcap")))
    assert record.ticks["F_instrument_W"][:, 2].max() > 0.5, "upwards, by the bodies"
    assert "plate" in record.bodies.names


PAIRS = """
objects: [{name: table, plane: {size: 0.3}, pose: {xyz: [0, 0, -0.03]}}]
bodies: [{name: plate, mass: 0.02, parts: [{box: [0.04, 0.04, 0.004]}], pose: {xyz: [0, 0, 0.0021]}}]
pairs:
  right:
    devices: {leader: NOBODYR, follower: virtual, teleop: none}
    arms:
      leader: {base: {xyz: [0.345, 0.243, 0.219], rpy_deg: [0, 0, -20]}}
      follower: {model: psm_prograsp, base: {xyz: [0.05, 0, 0.19]}}
    operator: {path: [{t: 0, xyz: [0.05, 0, 0.03]}, {t: 1, xyz: [0.05, 0, 0.03]}]}
  left:
    devices: {leader: NOBODYL, follower: virtual, teleop: none}
    arms:
      leader: {model: mtm_left, base: {xyz: [-0.345, 0.243, 0.219], rpy_deg: [0, 0, 20]}}
      follower: {model: psm_prograsp, base: {xyz: [-0.05, 0, 0.19]}}
    operator: {path: [{t: 0, xyz: [-0.05, 0, 0.03]}, {t: 1, xyz: [-0.05, 0, 0.03]}]}
record: {report: false}
"""


def test_the_tools_of_all_pairs_are_among_the_same_bodies(built):
    from palpate.ros.pairs import plants_of
    from palpate.scene import Scene
    from palpate.session import PairsSession

    scene = Scene.parse(PAIRS)
    with PairsSession(scene, plants=plants_of(scene)) as pairs:
        right, world = pairs.pairs["right"], pairs.world
        assert [tool.name for tool in world.tools] == ["right", "left"]
        pairs.start()
        time.sleep(0.5)
        assert world.states()["t"] > 0.1
        right.stop()  # as if its node had failed
        t = world.states()["t"]
        time.sleep(0.3)
        assert world.states()["t"] > t + 0.1, "the hand of the other pair still meets the bodies"
    assert not world.core_bodies.running
