"""User-defined arms: a model file for a URDF, its defaults, and error messages with remedies."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import palpate
from palpate.arm import models_folder
from palpate.base.errors import ArmError, SceneError
from palpate.scene.rig import build
from palpate.scene.scene import Scene

JOINT = """<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="0 0 {z}"/>
<axis xyz="0 1 0"/>{limit}</joint>"""
LIMIT = '<limit lower="-1.5" upper="1.6" effort="4" velocity="3"/>'
MASS = """<inertial><origin xyz="0 0 0.1"/><mass value="0.3"/>
<inertia ixx="1e-3" iyy="1e-3" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>"""


def urdf(*, limit=LIMIT, kind="revolute", mass=MASS):
    joints = [
        JOINT.format(name="shoulder", kind="revolute", parent="base", child="upper", z=0.1, limit=LIMIT),
        JOINT.format(name="elbow", kind=kind, parent="upper", child="lower", z=0.2, limit=limit),
        JOINT.format(name="mount", kind="fixed", parent="lower", child="tool", z=0.2, limit=""),
    ]
    links = f'<link name="base"/><link name="upper">{MASS}</link><link name="lower">{mass}</link><link name="tool"/>'
    return f'<robot name="two">{links}{"".join(joints)}</robot>'


@pytest.fixture
def write(tmp_path):
    def write(yaml="urdf: two.urdf\n", **changes):
        (tmp_path / "two.urdf").write_text(urdf(**changes))
        path = tmp_path / "two.yaml"
        path.write_text(yaml)
        return path

    return write


def test_model_file_needs_only_the_urdf(write):
    arm = palpate.Arm.load(write())
    assert (arm.name, arm.n, arm.orients) == ("two", 2, False)
    q = np.array([0.3, 0.4])
    x = 0.2 * np.sin(0.3) + 0.2 * np.sin(0.7)
    z = 0.1 + 0.2 * np.cos(0.3) + 0.2 * np.cos(0.7)
    assert np.allclose(arm.fk(q)[:3, 3], [x, 0, z], atol=1e-15)  # the tip is the end of the chain
    assert np.allclose(arm.home, [0.05, 0.05])  # middle of the limits
    options = arm.leader_options()
    assert np.array_equal(options.coupling, np.eye(2))
    assert not options.encoder_step.any()
    assert np.array_equal(options.tau_max, [4, 4])
    assert {v.link for v in arm.visuals} == {"base", "upper", "lower"}  # sticks, as the URDF has no visuals


@pytest.mark.parametrize("limit", ["", '<limit effort="4" velocity="3"/>', LIMIT])
def test_continuous_joints_turn_two_times_to_both_sides(write, limit):
    arm = palpate.Arm.load(write(kind="continuous", limit=limit))
    assert np.allclose([arm.q_min[1], arm.q_max[1], arm.home[1]], [-2 * np.pi, 2 * np.pi, 0.0])
    q = np.array([0.3, -5.9])
    assert np.allclose(arm.fk(q)[:3, 3], [0.2 * np.sin(q[0]) + 0.2 * np.sin(q.sum()), 0,
                                          0.1 + 0.2 * np.cos(q[0]) + 0.2 * np.cos(q.sum())], atol=1e-14)  # fmt: skip
    assert arm.v_max[1] == (3.0 if limit else 0.0)
    if not limit:
        with pytest.raises(ArmError, match="'elbow' has no speed limit"):
            arm.follower_options()


def test_values_of_a_model_file_are_used(write):
    text = "urdf: two.urdf\ntip_frame: lower\nhome: [0.1, 0.2]\ncoulomb: [0.1, 0.2]\nencoder_step_deg: [0.5, 1]\n"
    arm = palpate.Arm.load(write(text))
    assert np.allclose(arm.fk(np.zeros(2))[:3, 3], [0, 0, 0.3])
    assert np.array_equal(arm.home, [0.1, 0.2])
    assert np.array_equal(arm.leader_options().coulomb, [0.1, 0.2])
    assert np.allclose(arm.follower_options().encoder_step, np.radians([0.5, 1]))


@pytest.mark.parametrize(
    ("yaml", "changes", "message"),
    [
        ("urdf: two.urdf\ntip_frame: gripper\n", {}, r"tip frame 'gripper' is not a link.*base, upper, lower, tool"),
        ("urdf: other.urdf\n", {}, r"URDF cannot be read"),
        ("urdf: two.urdf\ncolomb: [0, 0]\n", {}, r"unknown key 'colomb'[\s\S]*did you mean 'coulomb'"),
        ("urdf: two.urdf\ncoulomb: [0.1]\n", {}, r"coulomb needs 2 numbers[\s\S]*shoulder, elbow"),
        ("urdf: two.urdf\nhome: [0, 9]\n", {}, r"home puts elbow at 9, outside its limits -1.5 to 1.6"),
        ("urdf: two.urdf\n", {"kind": "planar", "limit": ""}, r"'elbow'.*unsupported type \(planar\)"),
        ("urdf: two.urdf\n", {"kind": "floating", "limit": ""}, r"'elbow'.*unsupported type|degrees of freedom"),
        ("urdf: two.urdf\n", {"limit": '<limit lower="1" upper="0" effort="1" velocity="1"/>'}, r"'elbow'.*limits 1"),
        ("name: nothing\n", {}, r"no arm is named"),
        ("- 1\n", {}, r"a model file is a mapping"),
        ("urdf: [\n", {}, r"not valid YAML"),
        ("device: delta\nparameters: {upper: 0.1}\n", {}, r"device delta: base_radius is missing"),
        ("device: hexapod\n", {}, r"no kind of device 'hexapod'"),
    ],
)
def test_mistakes_are_reported(write, yaml, changes, message):
    with pytest.raises(ArmError, match=message):
        palpate.Arm.load(write(yaml, **changes))


def test_leader_needs_mass_and_drives_and_follower_needs_speed_limits(write):
    no_mass = palpate.Arm.load(write(mass=""))
    with pytest.raises(ArmError, match=r"joint 'elbow' moves no mass[\s\S]*<inertial>"):
        no_mass.leader_options()
    weak = palpate.Arm.load(write(limit='<limit lower="-1" upper="1" effort="0" velocity="0"/>'))
    with pytest.raises(ArmError, match=r"joint 'elbow' has no drive limit[\s\S]*effort"):
        weak.leader_options()
    with pytest.raises(ArmError, match=r"joint 'elbow' has no speed limit[\s\S]*velocity"):
        weak.follower_options()


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(0, 1), min_size=6, max_size=6))
def test_inverse_kinematics_of_a_six_axis_arm(share):
    arm = palpate.Arm.model("six_axis")
    q = arm.q_min + np.array(share) * (arm.q_max - arm.q_min)
    X = arm.fk(q)
    assert np.abs(arm.fk(arm.ik(X, q)) - X).max() < 1e-6
    near = np.clip(q + 0.05, arm.q_min, arm.q_max)
    assert np.abs(arm.fk(arm.ik(X, near)) - X).max() < 1e-6


SCENE = "objects: [{shape: organ, triangles: 4000}]\narms: {leader: {model: %s}, follower: {model: %s}}\n"


@pytest.mark.parametrize(
    ("leader", "follower"),
    [("six_axis", "psm_lnd"), ("delta", "psm_lnd"), ("mtm_left", "six_axis"), ("delta", "delta")],
)
def test_session_with_an_own_arm_renders_contact_forces(leader, follower):
    session = palpate.Session(palpate.Scene.parse(SCENE % (leader, follower)))
    summary = session.run(3.0)
    assert summary.peak_force_N > 1.0
    assert summary.contact_s > 1.0
    assert not summary.faults
    tick = session.latest()
    n = session.rig.arms.follower.n
    assert np.allclose(
        (session.rig.arms.X_WB @ session.rig.arms.follower.fk(tick["q_follower"][:n]))[:3, 3], tick["p_WT"]
    )
    felt = np.linalg.norm(tick["F_cell_L"])
    assert felt == pytest.approx(np.linalg.norm(tick["F_H_L"]), abs=0.4)  # tolerance for the arm's friction


def test_scene_finds_the_model_file_in_its_folder(tmp_path, write):
    write()
    for name in ("six_axis.urdf", "six_axis.yaml"):
        (tmp_path / f"my_{name}").write_text((models_folder() / name).read_text().replace("six_axis", "my_six_axis"))
    scene = tmp_path / "scene.yaml"
    scene.write_text(SCENE % ("my_six_axis.yaml", "psm_lnd"))
    assert palpate.Scene.load(scene).arm("leader").name == "my_six_axis"
    scene.write_text(SCENE % ("absent.yaml", "psm_lnd"))
    with pytest.raises(SceneError, match=r"scene.yaml:2: arms.leader.model: .*cannot be read[\s\S]*absent.yaml"):
        palpate.Scene.load(scene).arm("leader")
    scene.write_text(SCENE % ("two.yaml", "psm_lnd") + "operator: {path: [{t: 0, xyz: [0, 0, 9]}]}\n")
    with pytest.raises(SceneError, match="cannot reach"):
        palpate.Session(palpate.Scene.load(scene))


def test_gravity_follows_the_mounting_of_a_leader():
    text = SCENE % ("delta", "psm_lnd")
    session = palpate.Session(
        palpate.Scene.parse(
            text.replace("model: delta", "model: delta, base: {rpy_deg: [0, 90, 0], xyz: [0.4, 0, 0.2]}")
        )
    )
    arm = session.rig.arms.leader
    R_WL = session.rig.arms.X_WL[:3, :3]
    J = arm.jacobian(arm.home)[:3]
    expected = J.T @ R_WL.T @ [0, 0, 9.81 * (0.12 + 1.5 * 0.03)]
    upper = arm.gravity(arm.home) - expected  # part of the driven arms, smaller than that of the platform
    assert np.linalg.norm(upper) < np.linalg.norm(expected)
    assert np.linalg.norm(arm.gravity(arm.home) - palpate.Arm.model("delta").gravity(arm.home)) > 0.05


REACH = "objects: [{sphere: {radius: 0.02}}]\narms: {leader: {model: %s}}\nmapping: {scale: %g}\n"


def test_what_no_base_can_mend_is_told_before_the_reach(tmp_path):
    """A URDF without <inertial>, as the public ones of desktop devices: its reach does not matter yet."""
    urdf = (models_folder() / "six_axis.urdf").read_text()
    (tmp_path / "bare.urdf").write_text(re.sub(r"<inertial>.*?</inertial>", "", urdf, flags=re.DOTALL))
    (tmp_path / "bare.yaml").write_text("urdf: bare.urdf\n")
    with pytest.raises(ArmError, match="moves no mass"):
        build(Scene.parse(REACH % (tmp_path / "bare.yaml", 0.01)))


def test_remedy_for_a_leader_out_of_reach_is_what_was_not_done_yet():
    with pytest.raises(SceneError) as refused:
        build(Scene.parse(REACH % ("six_axis", 0.01)))
    words = str(refused.value)
    assert "leader six_axis cannot reach" in words
    assert "mapping.scale 1 instead of 0.01" in words
    assert "home in its model file" in words
    assert "leave out arms.leader.base" not in words
    placed = (REACH % ("six_axis", 0.01)).replace("six_axis}", "six_axis, base: {xyz: [0.3, 0, 0]}}")
    with pytest.raises(SceneError, match=r"leave out arms\.leader\.base|cannot give its handle"):
        build(Scene.parse(placed))
