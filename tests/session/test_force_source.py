"""The hand feels what the follower's drives feel: estimate and both as sources of the force."""

import numpy as np
import pytest
import yaml

from palpate.arm import Arm
from palpate.arm.drives import drive_train
from palpate.arm.dynamics import Dynamics, to_data
from palpate.errors import PalpateWarning, SceneError
from palpate.record.ticks import as_ticks
from palpate.scene import Scene
from palpate.scene.rig import build

WALL = """\
objects: [{box: {size: [0.2, 0.2, 0.06]}, stiffness: 400, damping: 2}]
operator: {palpate: {force: 2.0, approach: 0.8, press: 0.6, slide: 1.0, leave: 0.6}}
force: {source: %s}
"""
pytestmark = pytest.mark.filterwarnings("ignore:.*felt twice")  # the sum of two like forces is what is judged


@pytest.fixture(scope="module")
def ticks():
    return {s: as_ticks(build(Scene.parse(WALL % s)).simulation().run(3000)) for s in ("contact", "estimate", "both")}


def test_default_is_the_virtual_contact_and_measures_no_torque(ticks):
    t = ticks["contact"]
    assert not t["tau_follower"].any()
    assert not t["F_estimate_W"].any()
    assert not t["F_touch_W"].any()
    assert np.linalg.norm(t["F_H_L"], axis=1).max() > 1.0


def test_estimated_force_is_the_touch(ticks):
    t = ticks["estimate"]
    touch = np.linalg.norm(t["F_touch_W"], axis=1)
    assert touch.max() > 1.0, "the follower meets the wall"
    pressed = touch > 0.5 * touch.max()
    error = np.linalg.norm(t["F_estimate_W"] - t["F_touch_W"], axis=1)
    assert np.median(error[pressed]) < 0.25 * touch.max()
    assert t["tau_follower"][:, 2].any()


def test_the_hand_is_given_the_estimate_within_the_limits(ticks):
    for source, wanted in (
        ("estimate", lambda t: t["F_estimate_W"]),
        ("both", lambda t: t["F_estimate_W"] + t["F_T_W"]),
    ):
        t = ticks[source]
        free = (t["status"].astype(int) & 0x203F) == 0  # neither limiter nor drives nor passivity have cut
        assert free.sum() > 100
        given, asked = np.linalg.norm(t["F_H_L"], axis=1), np.linalg.norm(wanted(t), axis=1)
        np.testing.assert_allclose(given[free], asked[free], atol=1e-9)
        steps = np.linalg.norm(np.diff(t["F_H_L"], axis=0), axis=1)
        assert steps.max() < 1.0, "the rate cap holds"


def test_law_and_its_energy_stay_out_of_an_estimate(ticks):
    assert ticks["estimate"]["energy_spring"].max() == 0.0
    assert ticks["both"]["energy_spring"].max() > 0.0


def test_the_same_scene_and_seed_give_the_same_rows():
    rows = [build(Scene.parse(WALL % "estimate")).simulation().run(400) for _ in range(2)]
    kept = slice(0, -2)  # without the clock's
    np.testing.assert_array_equal(rows[0][:, kept], rows[1][:, kept])


def test_ideal_joints_have_nothing_to_tell():
    scene = Scene.parse(WALL % "estimate" + "arms: {follower: {bandwidth: 0}}\n")
    with pytest.raises(SceneError, match="ideal joints have no torque"):
        build(scene).simulation()


def test_an_object_that_nobody_feels_is_refused_and_one_felt_twice_is_told():
    text = "objects: [{name: wall, plane: {}, presence: %s}]\nforce: {source: %s}\n"
    for presence, source in (("real", "contact"), ("virtual", "estimate")):
        with pytest.raises(SceneError, match=f"'wall' is {presence} only and force.source is '{source}'"):
            build(Scene.parse(text % (presence, source)))
    with pytest.warns(PalpateWarning, match="'wall' is felt twice"):
        build(Scene.parse(text % ("both", "both")))


def test_dynamics_of_a_scene_are_read_or_refused(tmp_path):
    """A follower believed to be heavier than it is feels its own weight; files that do not fit are told."""
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
    t = as_ticks(rig.simulation().run(200))
    q = t["q_follower"][-1][:6]
    W, J = np.diag(arm.tau_max**-2.0), arm.jacobian(q)[:3]
    F = np.linalg.solve(J @ W @ J.T + 1e-6 * np.eye(3), J @ W @ (0.3 * arm.gravity(q)))
    told = rig.arms.X_WB[:3, :3].T @ t["F_estimate_W"][-1]
    assert told[2] == pytest.approx(F[2], abs=drives.coulomb[2])  # a slow joint hides its dry friction
    for content, why in (("{", "not valid YAML"), ("a: 1", "not a dynamics model"), (None, "cannot be read")):
        if content is None:
            (tmp_path / "psm.yaml").unlink()
        else:
            (tmp_path / "psm.yaml").write_text(content)
        with pytest.raises(SceneError, match=why):
            build(Scene.load(tmp_path / "scene.yaml"))
