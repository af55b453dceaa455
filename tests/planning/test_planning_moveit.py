"""MoveIt: the files that it reads, and its trajectories as plans."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml
from planning_worlds import posts, problem, reaching

from palpate import Arm
from palpate.errors import PlanningError
from palpate.planning import moveit

A, B = reaching(-0.055, 0.0, -0.12), reaching(0.055, 0.0, -0.12)


def _message(rows: np.ndarray, names: list[str]) -> dict:
    points = [{"positions": row.tolist(), "time_from_start": {"sec": k, "nanosec": 0}} for k, row in enumerate(rows)]
    return {"joint_trajectory": {"joint_names": names, "points": points}}


def test_the_files_agree_with_each_other_and_with_the_arm(tmp_path: Path) -> None:
    made = problem()
    files = {file.name: file for file in moveit.export(made, tmp_path)}
    xml = files["psm_lnd.urdf"].read_text()
    arm = Arm(xml, "world", "tip")  # read by urdfdom
    np.testing.assert_allclose(arm.fk(B), made.robot.X_WB @ made.robot.arm.fk(B), atol=1e-12)
    urdf, srdf = ElementTree.fromstring(xml), ElementTree.fromstring(files["psm_lnd.srdf"].read_text())
    links = {link.get("name") for link in urdf.findall("link")}
    joints = {joint.get("name") for joint in urdf.findall("joint")}
    assert urdf.get("name") == srdf.get("name")
    for pair in srdf.findall("disable_collisions"):
        assert {pair.get("link1"), pair.get("link2")} <= links
        assert pair.get("reason") in ("Adjacent", "Never", "Default", "User")
    for state in srdf.findall("group_state"):
        assert [joint.get("name") for joint in state] == made.robot.arm.joint_names
    limits = yaml.safe_load(files["joint_limits.yaml"].read_text())["joint_limits"]
    assert set(limits) <= joints
    assert limits["yaw"]["max_velocity"] == pytest.approx(made.limits.v[0])
    (group,) = srdf.findall("group")
    assert yaml.safe_load(files["kinematics.yaml"].read_text()).keys() == {group.get("name")}


def test_exported_capsules_are_those_of_the_checks(tmp_path: Path) -> None:
    made = problem()
    tree = ElementTree.fromstring(moveit.urdf(made))
    radii = sorted(float(c.get("radius", "0")) for c in tree.iterfind("link/collision/geometry/cylinder"))
    expected = sorted(b.capsule.radius for b in made.robot.bodies if b.capsule.length > 1e-9)
    np.testing.assert_allclose(radii, expected)


def test_the_planning_scene_lists_every_obstacle() -> None:
    lines = moveit.scene_text(posts().obstacles).splitlines()
    assert [line[2:] for line in lines if line.startswith("* ")] == ["vessel", "post", "ball"]
    assert lines[-1] == "."
    box = lines.index("box")
    assert [float(x) for x in lines[box + 1].split()] == pytest.approx([0.004, 0.05, 0.06])
    mesh = lines.index("mesh")
    vertices, triangles = map(int, lines[mesh + 1].split())
    body = lines[mesh + 2 : mesh + 2 + vertices + triangles]
    assert max(int(i) for row in body[vertices:] for i in row.split()) == vertices - 1


def test_a_trajectory_of_moveit_is_a_plan_after_our_check() -> None:
    made = problem()
    ours = made.plan(A, B, seed=2, timeout=60.0)
    names = list(reversed(made.robot.arm.joint_names))
    rows = np.array([curve.controls[0] for curve in ours.curves] + [B])
    # a polyline through the plan's junctions may cut a corner: a smaller clearance is asked for
    plan = moveit.checked(made, _message(rows[:, ::-1], names), 0.0005)
    assert plan.success, plan.reason
    np.testing.assert_allclose(plan.joints[[0, -1]], [A, B], atol=1e-9)


def test_a_trajectory_that_collides_is_refused_with_its_pair() -> None:
    made = problem()
    plan = moveit.checked(made, _message(np.stack([A, B]), made.robot.arm.joint_names))
    assert not plan.success
    assert plan.nearest[1] in ("vessel", "post")


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ({}, "no trajectory"),
        ({"joint_names": ["yaw"], "points": [{"positions": [0.0]}]}, "does not move pitch"),
        (_message(np.full((2, 6), np.nan), Arm.psm().joint_names), "not finite"),
        (_message(np.zeros((2, 3)), Arm.psm().joint_names), "one position per joint"),
    ],
)
def test_a_message_that_is_no_trajectory_is_explained(message: dict, words: str) -> None:
    with pytest.raises(PlanningError, match=words):
        moveit.checked(problem(), message)


def test_rosbags_reads_and_writes_the_same_trajectory() -> None:
    """The message as ROS 2 serialises it, by an independent package."""
    rosbags = pytest.importorskip("rosbags.typesys")
    store = rosbags.get_typestore(rosbags.Stores.ROS2_HUMBLE)
    types = store.types
    Header, Time = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    Duration = types["builtin_interfaces/msg/Duration"]
    Point, Trajectory = types["trajectory_msgs/msg/JointTrajectoryPoint"], types["trajectory_msgs/msg/JointTrajectory"]
    empty = np.zeros(0)
    points = [Point(q, empty, empty, empty, Duration(k, 0)) for k, q in enumerate((A, B))]
    sent = Trajectory(Header(Time(0, 0), "psm"), problem().robot.arm.joint_names, points)
    data = store.serialize_cdr(sent, "trajectory_msgs/msg/JointTrajectory")
    read = store.deserialize_cdr(data, "trajectory_msgs/msg/JointTrajectory")
    np.testing.assert_array_equal(moveit.waypoints(read, problem().robot.arm.joint_names), [A, B])
