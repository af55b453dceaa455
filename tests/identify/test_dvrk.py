"""The dVRK's gravity compensation: its formula, and import and export of its file."""

import json

import numpy as np
import pytest
import synthetic_arm as synthetic
from real_data import DATA, needs_data

from palpate import Arm, _core
from palpate.arm import dvrk_gravity as dvrk
from palpate.arm.identify.fit_gravity import fit_poses
from palpate.arm.identify.recordings import read_static
from palpate.base.errors import OutputError, RecordingError

MODELS = {"MTMR_28247": "dvrk_config_jhu__jhu-dVRK__gc-MTMR-28247.json",
          "MTML_34863": "dvrk_config_jhu__jhu-daVinci__gc-MTML-34863.json"}  # fmt: skip


@pytest.mark.parametrize("side", ["left", "right"])
def test_ten_parameters_are_combinations_of_moments(side):
    """The regressor of the dVRK source equals ours times T at every pose."""
    arm = Arm.mtm(side)
    q = np.random.default_rng(9).uniform(arm.q_min, arm.q_max, (50, 7))
    Y = arm.gravity_columns(_core.GravityTerms(), q)
    np.testing.assert_allclose(Y @ dvrk.moments_of_parameters(arm), dvrk.regressor(q), atol=1e-11)


def test_cad_masses_have_the_published_parameters():
    """p of the CAD masses (right arm): .010 0 .088 .023 0 .018 -.004 0 .003 0, to three decimals."""
    arm = Arm.mtm("right")
    q = np.random.default_rng(9).uniform(arm.q_min, arm.q_max, (60, 7))
    G = np.concatenate([arm.gravity(x) for x in q])
    p = np.linalg.lstsq(dvrk.regressor(q).reshape(len(G), -1), G, rcond=None)[0]
    np.testing.assert_allclose(p, [0.010, 0, 0.088, 0.023, 0, 0.018, -0.004, 0, 0.003, 0], atol=6e-4)


def controller_torques(file, q, direction):
    """Torques (k, 6) [N m] from the shipped file, with one set of 40 numbers per direction."""
    numbers = json.loads(file.read_text())["GC_controller"]
    both = []
    for sign in ("pos", "neg"):
        x = np.array(numbers[f"gc_dynamic_params_{sign}"])
        both.append((dvrk.regressor(q) @ x[:10])[:, :6])
        for joint in range(6):
            both[-1][:, joint] += sum(x[10 + 5 * joint + k] * q[:, joint] ** k for k in range(5))
    return np.where(direction[:, :6] > 0, *both)


@needs_data
@pytest.mark.parametrize("name", MODELS)
def test_imported_model_is_the_shipped_formula(name, tmp_path):
    file = DATA / "gravity_models" / MODELS[name]
    model = dvrk.load(file)
    arm = Arm.mtm("left" if "MTML" in name else "right")
    q = synthetic.poses(40, 1)
    direction = np.sign(np.random.default_rng(0).standard_normal(q.shape))
    np.testing.assert_allclose(
        model.measured(q, arm, direction)[:, :6], controller_torques(file, q, direction), atol=1e-10
    )

    lost = dvrk.save(model, tmp_path / "again.json")
    assert lost.max() < 1e-9
    again = controller_torques(tmp_path / "again.json", q, direction)
    np.testing.assert_allclose(again, controller_torques(file, q, direction), atol=1e-9)
    assert json.loads((tmp_path / "again.json").read_text())["SN"] == name[-5:]


@needs_data
@pytest.mark.parametrize("name", MODELS)
def test_calibration_of_a_lab_explains_its_arm(name):
    """The shipped file explains random poses of its arm, so units, signs and coordinates are right."""
    model = dvrk.load(DATA / "gravity_models" / MODELS[name])
    arm = Arm.mtm("left" if "MTML" in name else "right")
    poses = read_static(DATA / "mtm_static" / f"{name}__random_N400.csv", arm)
    left = ((poses.tau - model.holding(poses.q, arm)) ** 2).sum(axis=0)[:6]
    r2 = 1 - left / ((poses.tau - poses.tau.mean(axis=0)) ** 2).sum(axis=0)[:6]
    assert (r2 > [0.3, 0.85, 0.78, 0.35, 0.78, 0.85]).all(), r2


def test_export_of_our_model_states_its_approximation_error(tmp_path):
    arm, poses = Arm.mtm("right"), synthetic.recording(120, 1)
    model = fit_poses(poses, arm, "potential", np.arange(7) < 6).model
    lost = dvrk.save(model, tmp_path / "gc.json", serial="12345")
    again = dvrk.load(tmp_path / "gc.json")
    left = np.sqrt(((again.holding(poses.q, arm) - model.holding(poses.q, arm)) ** 2).mean(axis=0))[:6]
    np.testing.assert_allclose(left, lost, rtol=1e-6)
    assert (lost < [0.02, 0.02, 0.005, 0.01, 0.004, 0.004]).all()
    assert again.friction[3, 0] == pytest.approx(model.friction[3, 0])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "this is no gravity compensation of the dVRK"),
        ("[]", "this is no gravity compensation of the dVRK"),
        ('{"ARM_NAME": "PSM1"}', "'PSM1' is missing or unknown"),
        ('{"ARM_NAME": "MTMR", "GC_controller": {}}', "'gc_dynamic_params_pos' is missing"),
    ],
)
def test_other_files_are_rejected(text, message, tmp_path):
    (tmp_path / "gc.json").write_text(text)
    with pytest.raises(RecordingError) as error:
        dvrk.load(tmp_path / "gc.json")
    assert message in str(error.value)


def test_existing_file_is_not_overwritten(tmp_path):
    (tmp_path / "gc.json").write_text("precious")
    model = fit_poses(synthetic.recording(40, 1), Arm.mtm("right"), "paper", np.arange(7) < 6).model
    with pytest.raises(OutputError, match="exists already"):
        dvrk.save(model, tmp_path / "gc.json")
    assert (tmp_path / "gc.json").read_text() == "precious"
