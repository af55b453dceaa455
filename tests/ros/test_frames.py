"""In which axes does the arm read a wrench? As its flag `body/set_cf_orientation_absolute` says, and the two must agree
at every moment: a wrench read in the wrong frame turns with the wrist.

The judge reads each wrench as an arm would, by the flag that it was told: it must point out of the wall.
"""

import os
import time

import numpy as np
import pytest
import stand as bench
from scipy.spatial.transform import Rotation

from palpate.cli import main

NORMAL = np.array([0.0, 1.0, 0.0])  # of the stand's wall, in the frame of measured_cp
WRISTS = {"straight": [0.0, 0.0, 0.0], "pitched": [0.6, 0.0, 0.0], "turned": [0.3, -0.3, 0.5]}  # rotation vectors [rad]


@pytest.fixture(scope="module", params=["absolute", "tip"])
def stand(request, native, tmp_path_factory):
    stand = bench.Stand(native, f"FRAME{os.getpid()}{request.param}")
    node = bench.Node(stand, tmp_path_factory.mktemp(request.param), *(["--tip-frame"] * (request.param == "tip")))
    stand.tip = request.param == "tip"
    stand.press(60.0)
    yield stand
    node.end()


def read(felt, R_LH):
    """Forces in the frame of measured_cp, as an arm reads them [N]."""
    absolute = felt[:, 10:11] == 1.0
    return np.where(absolute, felt[:, 3:6], felt[:, 3:6] @ R_LH.T)


@pytest.mark.parametrize("wrist", WRISTS)
def test_wrench_and_flag_agree_however_the_wrist_is_turned(stand, wrist):
    turn = Rotation.from_rotvec(WRISTS[wrist])
    stand.puppet.follow(False)
    stand.released(time.monotonic())
    stand.puppet.turn_to(turn.as_quat())
    stand.press()
    felt = stand.puppet.felt[-20:]
    forces = read(felt, turn.as_matrix())
    assert np.linalg.norm(forces, axis=1).min() > 0.3
    np.testing.assert_allclose(forces @ NORMAL, np.linalg.norm(forces, axis=1), rtol=1e-3)
    assert stand.puppet.absolute != stand.tip
    along = felt[:, 3:6] @ NORMAL / np.linalg.norm(felt[:, 3:6], axis=1)
    assert (along < 0.99).all() == (stand.tip and wrist != "straight"), "the numbers turn with the wrist in its frame"


def test_the_flag_is_told_again_before_each_push(stand):
    """As after the camera pedal: nobody tells that the arm's frame has become another."""
    stand.press()
    stand.puppet.follow(False)
    stand.released(time.monotonic())
    again = time.monotonic()
    stand.press()
    flags, felt = stand.puppet.flags, stand.puppet.felt
    flags, felt = flags[flags[:, 0] > again], felt[felt[:, 0] > again]
    assert len(flags)
    assert (flags[:, 1] == (0.0 if stand.tip else 1.0)).all()
    pushes = felt[np.linalg.norm(felt[:, 3:6], axis=1) > 0.05, 0]
    assert flags[0, 0] < pushes[0], "the frame first, then a push"


def test_bases_that_are_turned_against_each_other_are_refused(built, tmp_path, capsys):
    """A teleoperation that runs knows nothing of the scene: tool and force would go to different sides."""
    scene = tmp_path / "wall.yaml"
    scene.write_text(
        "objects: [{name: wall, box: {size: [0.2, 0.2, 0.05]}, stiffness: 300, damping: 2}]\n"
        "arms: {leader: {base: {xyz: [-0.2145, 0.45, 0.1788], rpy_deg: [0, 0, 90]}}}\n"
    )
    assert main(["ros", "haptics", str(scene), "--out", str(tmp_path)]) == 2
    told = " ".join(capsys.readouterr().err.split())
    assert "turned against each other by 90.0 deg" in told
    assert "rpy_deg, or use --teleop none" in told
