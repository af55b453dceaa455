"""MoveIt: the files that it reads, and its trajectories as plans."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml
from planning_worlds import posts, problem, reaching

from palpate import Arm
from palpate.base.errors import PlanningError
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


def _built(store, kind: str, value):  # type: ignore[no-untyped-def]
    """An object of a message type from a mapping; fields that the type does not have are refused."""
    fields = dict(store.fielddefs[kind][1])
    assert set(value) <= set(fields), set(value) - set(fields)
    assert set(value) == set(fields) - {"polygon"}
    made = {}
    for name, (what, spec) in fields.items():
        if name == "polygon":  # of prisms
            made[name] = _built(store, "geometry_msgs/msg/Polygon", {"points": []})
        elif what.name == "NAME":
            made[name] = _built(store, spec, value[name])
        elif what.name == "BASE":
            made[name] = value[name]
        elif spec[0][0].name == "NAME":
            made[name] = [_built(store, spec[0][1], one) for one in value[name]]
        else:
            types = {"float64": np.float64, "uint32": np.uint32}
            made[name] = np.array(value[name], dtype=types[spec[0][1][0]])
    return store.types[kind](**made)


def test_the_planning_scene_message_has_the_shapes_of_its_types(tmp_path: Path) -> None:
    """Shapes and poses go through the definitions of rosbags, which knows no messages of MoveIt itself."""
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    made = problem()
    moveit.export(made, tmp_path)
    message = yaml.safe_load((tmp_path / "planning_scene.yaml").read_text())
    assert set(message) == {"name", "robot_model_name", "world", "is_diff"}
    objects = message["world"]["collision_objects"]
    assert [one["id"] for one in objects] == ["vessel", "post", "ball"]
    kinds = {"primitives": "SolidPrimitive", "meshes": "Mesh", "planes": "Plane"}
    poses = {"primitives": "primitive_poses", "meshes": "mesh_poses", "planes": "plane_poses"}
    for one, obstacle in zip(objects, made.world.obstacles, strict=True):
        assert (one["header"], one["operation"]) == ({"frame_id": "world"}, 0)
        (key,) = set(one) & set(kinds)
        (shape,), (pose,) = one[key], one[poses[key]]
        kind = f"shape_msgs/msg/{kinds[key]}"
        built = _built(store, kind, shape)
        assert store.deserialize_cdr(store.serialize_cdr(built, kind), kind)
        placed = _built(store, "geometry_msgs/msg/Pose", pose)
        np.testing.assert_allclose(
            [placed.position.x, placed.position.y, placed.position.z], obstacle.X_WO[:3, 3], atol=1e-12
        )
    post = objects[1]["primitives"][0]
    assert post["type"] == store.types["shape_msgs/msg/SolidPrimitive"].BOX
    np.testing.assert_allclose(post["dimensions"], [0.004, 0.05, 0.06])
    assert objects[2]["primitives"][0]["type"] == store.types["shape_msgs/msg/SolidPrimitive"].SPHERE
    with pytest.raises(AssertionError):
        _built(store, "geometry_msgs/msg/Pose", {"position": pose["position"], "rotation": pose["orientation"]})
