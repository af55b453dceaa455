"""The model files: equal to the generator's output, loadable from Python, complete for drawing, with clear errors."""

import runpy

import numpy as np
import pytest

import palpate
from palpate.arm import models_folder
from palpate.base.errors import ArmError


def test_models_equal_the_generators_output(monkeypatch):
    generator = models_folder() / "generate.py"
    if not generator.is_file():
        pytest.skip("an installed package has no models/generate.py")
    monkeypatch.syspath_prepend(str(generator.parent))
    for name, text in runpy.run_path(str(generator))["outputs"]().items():
        assert (models_folder() / name).read_text() == text, f"run python models/generate.py, {name} differs"


def test_arms_report_consistent_limits_and_names(arm):
    assert arm.n == len(arm.joint_names) == len(arm.home) == len(arm.tau_max)
    assert (arm.q_min < arm.q_max).all()
    assert (arm.q_min <= arm.home).all()
    assert (arm.home <= arm.q_max).all()
    assert (arm.tau_max > 0).all()
    assert arm.jaw_range[0] < arm.jaw_range[1]


def test_every_drawn_link_has_a_pose(arm):
    poses = arm.link_poses(arm.home)
    assert len(arm.visuals) > 20
    for visual in arm.visuals:
        assert visual.link in poses
        assert visual.X_link_visual.shape == (4, 4)
        assert min(visual.size) > 0
        assert len(visual.size) == {"box": 3, "cylinder": 2, "sphere": 1}[visual.shape]
    assert np.allclose(poses["tip"], arm.fk(arm.home), atol=1e-15)


def test_opening_the_jaws_does_not_move_the_tip():
    psm = palpate.Arm.psm()
    closed, opened = psm.link_poses(psm.home), psm.link_poses(psm.home, jaw=0.8)
    along = [opened[f"jaw_{i}"][:3, 1] for i in (1, 2)]
    assert np.isclose(np.arccos(along[0] @ along[1]), 0.8)
    assert np.array_equal(closed["tip"], opened["tip"])


def test_drawn_parallelograms_stay_parallel():
    mtm, psm = palpate.Arm.mtm("right"), palpate.Arm.psm()
    poses = mtm.link_poses(np.array([0.3, 0.5, -0.4, 0.2, 0.1, 0.3, 0.0]))
    assert np.allclose(poses["parallel_bar"][:3, :3], poses["upper_arm"][:3, :3])
    poses = psm.link_poses(np.array([0.3, 0.5, 0.1, 0, 0, 0]))
    assert np.allclose(poses["bar_upper"][:3, :3], poses["yaw_link"][:3, :3])
    # The far end of the bars meets the instrument's column, which turns about the remote centre.
    end = (poses["bar_upper"] @ [0, 0, -0.516, 1])[:3]
    assert np.linalg.norm(end - poses["pitch_link"][:3, :3] @ [0, 0.19, 0]) < 1e-12


@pytest.mark.parametrize("call", [lambda: palpate.Arm.mtm("middle"), lambda: palpate.Arm.psm("scissors")])
def test_error_for_an_unknown_arm_lists_the_known_arms(call):
    with pytest.raises(ArmError, match=r"the models are .*(right, left|lnd)"):
        call()


def test_error_for_a_wrong_shape_names_argument_and_shapes(arm):
    with pytest.raises(ValueError, match=rf"q must have shape \({arm.n},\).*got shape \(3,\)"):
        arm.fk(np.zeros(3))


def test_error_for_an_unknown_frame_lists_the_links():
    xml = (models_folder() / "psm_lnd.urdf").read_text()
    with pytest.raises(RuntimeError, match=r"'tool0' is not a link.*psm_base"):
        palpate.Arm(xml, "psm_base", "tool0")
    with pytest.raises(RuntimeError, match="URDF cannot be read"):
        palpate.Arm("<robot", "psm_base", "tip")


def test_hardware_effects_missing_in_the_model_file_are_ideal():
    xml = (models_folder() / "psm_lnd.urdf").read_text()
    options = palpate.Arm(xml, "psm_base", "tip").leader_options()
    assert np.array_equal(options.coupling, np.eye(6))
    for nothing in (options.coulomb, options.viscous, options.rotor_inertia):
        assert np.array_equal(nothing, np.zeros(6))


def test_coupling_moves_the_forearm_from_the_base():
    """Motor 3 sets the absolute angle of the forearm, q2 + q3."""
    A = palpate.Arm.mtm("right").leader_options().coupling
    q = A @ np.array([0, 0.3, 0.1, 0, 0, 0, 0])
    assert np.isclose(q[1] + q[2], 0.1)
