"""Invalid recordings: every mistake is reported with file, line, cause and remedy, and no model is fitted."""

import numpy as np
import pytest
import synthetic_arm as synthetic
from real_data import DATA, needs_data

from palpate import Arm
from palpate.arm.gravity_model import GravityModel
from palpate.arm.identify.gravity import gravity
from palpate.arm.identify.recordings import on_levels, read_moving, read_static
from palpate.base.errors import PalpateError, RecordingError

HEADER = ",".join([f"q{k}_rad" for k in range(1, 8)] + [f"tau{k}_Nm" for k in range(1, 8)]) + "\n"
ROW = "0.1,0.0,0.1,0.2,0.3,0.1,0,0.01,0.5,0.3,0.01,0.01,0.01,0\n"


def rejection(path, text, read=lambda p: read_static(p, Arm.mtm("right"))) -> str:
    path.write_text(text)
    with pytest.raises(RecordingError) as error:
        read(path)
    return str(error.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the recording has no rows"),
        (HEADER, "the recording has no rows"),
        (HEADER + "1,2,3\n", ":2: 3 columns\n  why: 14 are needed: q1_rad .. tau7_Nm"),
        ("1,2,3\n", ":1: 3 columns"),
        (ROW.strip() + ",7\n", ":1: 15 columns"),
        (HEADER + ROW + ROW.replace("0.5", "nan"), ":3: tau2_Nm is 'nan'"),
        (HEADER + ROW.replace("0.5", ""), ":2: tau2_Nm is 'empty'"),
        (HEADER + ROW.replace("0.5", "inf"), ":2: tau2_Nm is 'inf'"),
        (HEADER + ROW.replace("0.5", "half"), ":2: tau2_Nm is 'half'"),
        (HEADER.replace("q2_rad", "q2_deg") + ROW, "column 'q2_deg' where 'q2_rad' is needed"),
        (HEADER.replace("tau3_Nm", "torque3") + ROW, "no column tau3_Nm"),
        (
            HEADER + ROW.replace("0.2,0.3", "4.5,0.3"),
            "joint 4 is at 4.5 in pose 1\n  why: mtm_right has -1.658 to 3.578",
        ),
    ],
)
def test_mistakes_are_reported(text, message, tmp_path):
    assert message in rejection(tmp_path / "a.csv", text)


def test_missing_file_is_reported():
    with pytest.raises(RecordingError, match=r"nowhere\.csv: the recording cannot be read"):
        read_static("nowhere.csv", Arm.mtm("right"))
    with pytest.raises(RecordingError, match="no recording given"):
        read_static([], Arm.mtm("right"))


def test_binary_file_is_rejected(tmp_path):
    (tmp_path / "a.csv").write_bytes(b"\xff\xfe\x00\x81" * 50)
    with pytest.raises(RecordingError, match="cannot be read"):
        read_static(tmp_path / "a.csv", Arm.mtm("right"))


def test_degrees_are_distinguished_from_radians(tmp_path):
    poses = synthetic.recording(30, 1)
    poses.q[:] = np.degrees(poses.q)
    synthetic.write(tmp_path / "a.csv", poses)
    with pytest.raises(RecordingError, match="all rows fit when they are read as degrees"):
        read_static(tmp_path / "a.csv", Arm.mtm("right"))


def test_encoder_counts_are_reported(tmp_path):
    poses = synthetic.recording(30, 1)
    poses.q[:, :6] *= 1000.0  # encoder counts
    synthetic.write(tmp_path / "a.csv", poses)
    with pytest.raises(RecordingError, match="motor turns or encoder counts"):
        read_static(tmp_path / "a.csv", Arm.mtm("right"))


def test_motor_torques_are_reported(tmp_path):
    poses = synthetic.recording(30, 1)
    poses.tau[:] /= 50.0
    synthetic.write(tmp_path / "a.csv", poses)
    with pytest.raises(RecordingError, match="at the motor, before the gear"):
        read_static(tmp_path / "a.csv", Arm.mtm("right"))


def test_recording_of_the_other_arm_is_recognised(tmp_path):
    synthetic.write(tmp_path / "a.csv", synthetic.recording(30, 1))
    with pytest.raises(RecordingError, match=r"all rows fit the right arm\n  mend: name the arm .* \(--arm mtmr\)"):
        gravity(tmp_path / "a.csv", "mtml")


@pytest.mark.parametrize("header", [True, False])
def test_header_is_optional(header, tmp_path):
    poses = synthetic.recording(20, 1)
    synthetic.write(tmp_path / "a.csv", poses, header)
    np.testing.assert_allclose(read_static(tmp_path / "a.csv", Arm.mtm("right")).tau, poses.tau, rtol=1e-7)


def test_columns_are_found_by_name(tmp_path):
    """Columns may be in any order, among other columns."""
    columns = HEADER.strip().split(",")
    turned = ",".join(["pose", *reversed(columns)]) + "\n" + ",".join(["3", *reversed(ROW.strip().split(","))]) + "\n"
    (tmp_path / "a.csv").write_text(turned)
    poses = read_static(tmp_path / "a.csv", Arm.mtm("right"))
    assert poses.q[0, 3] == 0.2
    assert poses.tau[0, 1] == 0.5


def test_samples_of_one_pose_are_averaged(tmp_path):
    poses = synthetic.recording(10, 1)
    rows = np.repeat(np.hstack([poses.q, poses.tau]), 5, axis=0)
    rows[::5, 8] += 0.05
    (tmp_path / "a.csv").write_text(HEADER + "\n".join(",".join(map(repr, map(float, r))) for r in rows))
    read = read_static(tmp_path / "a.csv", Arm.mtm("right"))
    assert (len(read), read.samples) == (10, 50)
    np.testing.assert_allclose(read.tau[:, 1], poses.tau[:, 1] + 0.01)
    assert read.start.sum() == 1


def test_too_few_and_too_similar_poses_are_rejected(tmp_path):
    few = synthetic.recording(8, 1)
    synthetic.write(tmp_path / "few.csv", few)
    with pytest.raises(RecordingError, match="8 different poses\n  why: at least 12"):
        gravity(tmp_path / "few.csv", "mtmr")
    few.q[:, 1:] = few.q[0, 1:]
    synthetic.write(tmp_path / "few.csv", few)
    with pytest.raises(RecordingError, match=r"these poses do not identify .*shoulder_pitch\.m"):
        gravity(tmp_path / "few.csv", "mtmr")
    line = synthetic.recording(40, 1)
    line.q[:, [0, 2, 3, 4, 5]] = line.q[0, [0, 2, 3, 4, 5]]
    synthetic.write(tmp_path / "line.csv", line)
    with pytest.raises(RecordingError, match=r"too much alike: they show \d of 10 base parameters") as error:
        gravity(tmp_path / "line.csv", "mtmr")
    assert "these poses do not identify" in str(error.value)
    assert "wrist_platform" in str(error.value)


def test_repeated_poses_are_reported(tmp_path):
    poses = synthetic.recording(30, 1)
    rows = np.repeat(np.arange(30), 3)
    synthetic.write(tmp_path / "a.csv", synthetic.Static(poses.q[rows], poses.tau[rows], rows == 0, ("",), 90))
    found = gravity(tmp_path / "a.csv", "mtmr", model="gravity+springs")
    assert "90 rows are 30 poses: repeated ones were averaged" in found.warnings


def test_unknown_arm_and_model_names_are_reported(tmp_path):
    with pytest.raises(RecordingError, match="there is no arm 'psm'"):
        gravity("x.csv", "psm")
    with pytest.raises(RecordingError, match="there is no gravity model 'magic'\n  mend: choose one of potential"):
        gravity("x.csv", "mtmr", model="magic")


def test_test_poses_outside_the_training_region_are_reported(tmp_path):
    train, test = synthetic.recording(60, 1), synthetic.recording(30, 2)
    test.q[:5, 3] = 3.5
    synthetic.write(tmp_path / "a.csv", train)
    synthetic.write(tmp_path / "b.csv", test)
    found = gravity(tmp_path / "a.csv", "mtmr", model="gravity+springs", test=tmp_path / "b.csv")
    assert found.test.outside >= 5
    assert any("outside of the trained region" in text for text in found.warnings)


def test_test_poses_used_in_training_are_reported(tmp_path):
    synthetic.write(tmp_path / "a.csv", synthetic.recording(60, 1))
    found = gravity(tmp_path / "a.csv", "mtmr", model="paper", test=tmp_path / "a.csv")
    assert any("60 of 60 test poses were trained on" in text for text in found.warnings)


@needs_data
def test_actuator_coordinates_give_a_warning(tmp_path):
    """A real recording in motor coordinates is within the joint limits; only its torques are implausible."""
    from palpate.arm.coupling import coupling, drives

    arm = Arm.mtm("right")
    poses = read_static(DATA / "mtm_static/MTMR_31519__random_N160.csv", arm)
    turned = synthetic.Static(drives(poses.q, arm), poses.tau @ coupling(arm), poses.start, poses.files, poses.samples)
    synthetic.write(tmp_path / "m.csv", turned)
    found = gravity(tmp_path / "m.csv", "mtmr", model="gravity+springs")
    assert any("actuator coordinates" in text for text in found.warnings)
    plain = gravity(DATA / "mtm_static/MTMR_31519__random_N160.csv", "mtmr", model="gravity+springs")
    assert not any("actuator" in text for text in plain.warnings)


@needs_data
def test_repeated_samples_of_a_real_recording_are_averaged():
    poses = read_static(DATA / "mtm_static_wpi/mtmr_static_12poses_x50.csv", Arm.mtm("right"))
    assert (len(poses), poses.samples) == (12, 600)


@needs_data
def test_poses_of_one_joint_at_a_time_still_give_advice():
    """40 poses of a lab, each of which moves one joint in a small range."""
    arm = Arm.mtm("right")
    found = gravity(DATA / "mtm_static_wpi/mtmr_static_decoupled_40poses.csv", arm)
    assert found.cross_validation.r2_directed[1:].min() > 0.9
    q = np.array([pose for pose, _ in found.advice])
    assert ((q >= arm.q_min) & (q <= arm.q_max)).all()
    assert len(q) == 6


@needs_data
def test_a_moving_recording_has_no_header():
    motion = read_moving(DATA / "mtm_moving/mtm__one_results.csv", 7)
    assert motion.q.shape == motion.v.shape == motion.tau.shape
    assert len(motion) > 5000


def test_grid_poses_are_set_to_their_levels():
    rng = np.random.default_rng(0)
    levels = np.array([-1.0, 0.0, 1.5])
    q = np.zeros((900, 7))
    q[:, 3] = levels[np.arange(900) % 3] + 0.01 * rng.standard_normal(900)
    q[:, 0] = rng.uniform(-1, 1, 900)
    snapped = on_levels(synthetic.Static(q, q, np.arange(900) == 0, ("",), 900)).q
    assert len(np.unique(snapped[:, 3])) == 3
    np.testing.assert_array_equal(snapped[:, 0], q[:, 0])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 1", "this is not a gravity model\n  why: 'kind' is missing"),
        ("kind: dynamics", "its kind is 'dynamics'"),
        ("- 1", "this is not a gravity model"),
        ("a: [", "the gravity model cannot be read"),
    ],
)
def test_other_files_are_rejected_as_models(text, message, tmp_path):
    assert message in rejection(tmp_path / "m.yaml", text, GravityModel.load)


def test_models_of_another_arm_are_rejected(tmp_path):
    synthetic.write(tmp_path / "a.csv", synthetic.recording(40, 1))
    model = gravity(tmp_path / "a.csv", "mtmr", model="paper").model
    with pytest.raises(PalpateError, match="is of mtm_right, the arm is mtm_left"):
        model.apply(Arm.mtm("left"))
