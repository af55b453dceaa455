"""Force sources `estimate` and `both`: rendering of forces from the follower's drive torques."""

import numpy as np
import pytest
import yaml

from palpate.arm import Arm
from palpate.arm.drives import drive_train
from palpate.arm.dynamics import Dynamics, to_data
from palpate.base.errors import PalpateWarning, SceneError
from palpate.record.ticks import as_ticks
from palpate.scene import Scene
from palpate.scene.rig import build

WALL = """\
objects: [{box: {size: [0.2, 0.2, 0.06]}, stiffness: 400, damping: 2}]
operator: {palpate: {force: 2.0, approach: 0.8, press: 0.6, slide: 1.0, leave: 0.6}}
force: {source: %s}
"""
pytestmark = pytest.mark.filterwarnings("ignore:.*felt twice")  # these tests use the sum of two equal forces


@pytest.fixture(scope="module")
def ticks():
    return {s: as_ticks(build(Scene.parse(WALL % s)).simulation().run(3000)) for s in ("contact", "estimate", "both")}


def test_default_source_is_the_virtual_contact(ticks):
    t = ticks["contact"]
    assert not t["tau_follower"].any()
    assert not t["F_estimate_W"].any()
    assert not t["F_touch_W"].any()
    assert np.linalg.norm(t["F_H_L"], axis=1).max() > 1.0


def test_estimated_force_is_the_contact_force(ticks):
    t = ticks["estimate"]
    touch = np.linalg.norm(t["F_touch_W"], axis=1)
    assert touch.max() > 1.0, "control: the follower touches the wall"
    pressed = touch > 0.5 * touch.max()
    error = np.linalg.norm(t["F_estimate_W"] - t["F_touch_W"], axis=1)
    assert np.median(error[pressed]) < 0.25 * touch.max()
    assert t["tau_follower"][:, 2].any()


def test_estimate_reaches_the_hand_within_the_limits(ticks):
    for source, force_of in (
        ("estimate", lambda t: t["F_estimate_W"]),
        ("both", lambda t: t["F_estimate_W"] + t["F_T_W"]),
    ):
        t = ticks[source]
        free = (t["status"].astype(int) & 0x203F) == 0  # without limiter, drive saturation and passivity
        assert free.sum() > 100
        given, requested = np.linalg.norm(t["F_H_L"], axis=1), np.linalg.norm(force_of(t), axis=1)
        np.testing.assert_allclose(given[free], requested[free], atol=1e-9)
        steps = np.linalg.norm(np.diff(t["F_H_L"], axis=0), axis=1)
        assert steps.max() < 1.0, "the rate cap holds"


def test_estimate_excludes_the_contact_law_and_its_energy(ticks):
    assert ticks["estimate"]["energy_spring"].max() == 0.0
    assert ticks["both"]["energy_spring"].max() > 0.0


def test_the_same_scene_and_seed_give_the_same_rows():
    rows = [build(Scene.parse(WALL % "estimate")).simulation().run(400) for _ in range(2)]
    kept = slice(0, -2)  # without the clock columns
    np.testing.assert_array_equal(rows[0][:, kept], rows[1][:, kept])


def test_ideal_joints_cannot_estimate_forces():
    scene = Scene.parse(WALL % "estimate" + "arms: {follower: {bandwidth: 0}}\n")
    with pytest.raises(SceneError, match="ideal joints have no torque"):
        build(scene).simulation()


def test_unrendered_object_is_rejected_and_twice_rendered_one_reported():
    text = "objects: [{name: wall, plane: {}, presence: %s}]\nforce: {source: %s}\n"
    for presence, source in (("real", "contact"), ("virtual", "estimate")):
        with pytest.raises(SceneError, match=f"'wall' is {presence} only and force.source is '{source}'"):
            build(Scene.parse(text % (presence, source)))
    with pytest.warns(PalpateWarning, match="'wall' is felt twice"):
        build(Scene.parse(text % ("both", "both")))


def test_dynamics_file_of_a_scene_is_used_or_rejected(tmp_path):
    """With a model that is too heavy the estimate contains the weight; files that do not fit are reported."""
    arm = Arm.psm()
    drives = arm.follower_options().drives
    known = {"coulomb": drives.coulomb, "viscous": drives.viscous, "rotor": drives.rotor_inertia}
    names = [t.name.rpartition("_") for t in drive_train(arm, "joints").terms]
    theta = [known[kind][int(joint) - 1] if kind in known else 0.0 for kind, _, joint in names]
    heavy = Dynamics(arm, 1.3 * arm.inertial_parameters, np.array(theta), "joints")
    (tmp_path / "psm.yaml").write_text(yaml.safe_dump(to_data(heavy)))
    text = (WALL % "estimate").replace("force: {", "force: {dynamics: psm.yaml, ")
    (tmp_path / "scene.yaml").write_text(text)
    rig = build(Scene.load(tmp_path / "scene.yaml"))
    np.testing.assert_array_equal(rig.options().estimate.links, heavy.pi)
    assert build(Scene.parse(WALL % "estimate")).options().estimate.links.size == 0
    t = as_ticks(rig.simulation().run(500))  # the hand, which the weight has moved, comes to rest
    q = t["q_follower"][-1][:6]
    W, J = np.diag(arm.tau_max**-2.0), arm.jacobian(q)[:3]
    F = np.linalg.solve(J @ W @ J.T + 1e-6 * np.eye(3), J @ W @ (0.3 * arm.gravity(q)))
    estimate = rig.arms.X_WB[:3, :3].T @ t["F_estimate_W"][-1]
    assert estimate[2] == pytest.approx(F[2], abs=drives.coulomb[2])  # tolerance for the dry friction of a slow joint
    for content, why in (("{", "not valid YAML"), ("a: 1", "not a dynamics model"), (None, "cannot be read")):
        if content is None:
            (tmp_path / "psm.yaml").unlink()
        else:
            (tmp_path / "psm.yaml").write_text(content)
        with pytest.raises(SceneError, match=why):
            build(Scene.load(tmp_path / "scene.yaml"))
