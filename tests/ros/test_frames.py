"""The axes of wrenches: an arm uses those of its flag `body/set_cf_orientation_absolute`, so wrench and flag must agree
at every moment. A wrench in the wrong frame would rotate with the wrist.

The tests transform each wrench as an arm does, by the last received flag; the force must point out of the wall.
"""

import os
import time

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from palpate.ros.haptics import Devices
from palpate.ros.plant import as_teleoperated
from palpate.scene.rig import build
from palpate.scene.scene import Scene
from palpate_lab.verify.bench import ros_stand as bench

NORMAL = np.array([0.0, 1.0, 0.0])  # normal of the wall in the frame of measured_cp
WRISTS = {"straight": [0.0, 0.0, 0.0], "pitched": [0.6, 0.0, 0.0], "turned": [0.3, -0.3, 0.5]}  # rotation vectors [rad]


@pytest.fixture(scope="module", params=["absolute", "tip"])
def stand(request, native, tmp_path_factory):
    stand = bench.Stand(native, f"FRAME{os.getpid()}{request.param}")
    node = bench.Node(stand, tmp_path_factory.mktemp(request.param), *(["--tip-frame"] * (request.param == "tip")))
    stand.tip = request.param == "tip"
    try:
        stand.press(60.0)
        yield stand
    finally:
        node.end()


def read(felt, R_LH):
    """Forces in the frame of measured_cp [N], as an arm interprets them."""
    absolute = felt[:, 10:11] == 1.0
    return np.where(absolute, felt[:, 3:6], felt[:, 3:6] @ R_LH.T)


@pytest.mark.parametrize("wrist", WRISTS)
def test_wrench_and_flag_agree_for_any_wrist_rotation(stand, wrist):
    turn = Rotation.from_rotvec(WRISTS[wrist])
    stand.mock_leader.follow(False)
    stand.released(time.monotonic())
    stand.mock_leader.turn_to(turn.as_quat())
    stand.press()
    felt = stand.mock_leader.wrenches[-20:]
    forces = read(felt, turn.as_matrix())
    assert np.linalg.norm(forces, axis=1).min() > 0.3
    np.testing.assert_allclose(forces @ NORMAL, np.linalg.norm(forces, axis=1), rtol=1e-3)
    assert stand.mock_leader.absolute != stand.tip
    along = felt[:, 3:6] @ NORMAL / np.linalg.norm(felt[:, 3:6], axis=1)
    assert (along < 0.99).all() == (stand.tip and wrist != "straight"), "components rotate with the tip frame"


def test_flag_is_published_before_each_force(stand):
    """As after the camera pedal, which changes the frame of the arm without a message."""
    stand.press()
    stand.mock_leader.follow(False)
    stand.released(time.monotonic())
    again = time.monotonic()
    stand.press()
    flags, felt = stand.mock_leader.frame_settings, stand.mock_leader.wrenches
    flags, felt = flags[flags[:, 0] > again], felt[felt[:, 0] > again]
    assert len(flags)
    assert (flags[:, 1] == (0.0 if stand.tip else 1.0)).all()
    pushes = felt[np.linalg.norm(felt[:, 3:6], axis=1) > 0.05, 0]
    assert flags[0, 0] < pushes[0], "the flag comes before the force"


@pytest.mark.parametrize("turn", [135.0, 45.0, 3.7])
def test_running_teleoperation_decides_what_the_leaders_axes_are(turn, tmp_path):
    """It adds the same numbers in both frames of measured_cp, wherever the scene has the leader stand. A force of the
    scene then has the direction in which the hand must move to lead the tool against it."""
    scene = tmp_path / "wall.yaml"
    scene.write_text(
        "objects: [{name: wall, box: {size: [0.2, 0.2, 0.05]}, stiffness: 300, damping: 2}]\n"
        f"arms: {{leader: {{base: {{xyz: [-0.2145, 0.45, 0.1788], rpy_deg: [0, 0, {turn}]}}}}}}\n"
    )
    rig = build(Scene.load(scene))
    mapped, words = as_teleoperated(rig, Devices())
    assert f"by {turn:.1f} deg" in words
    motion_B = np.array([0.3, -0.5, 0.8])  # the teleoperation: the same numbers in L and B
    np.testing.assert_allclose(mapped.arms.X_WL[:3, :3] @ motion_B, rig.arms.X_WB[:3, :3] @ motion_B, atol=1e-12)
    np.testing.assert_array_equal(mapped.options().X_WL, mapped.arms.X_WL)
    for devices in (Devices(teleop="none"), Devices(follower="virtual")):
        assert as_teleoperated(rig, devices) == (rig, "")
