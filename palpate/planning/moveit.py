"""MoveIt 2: its configuration from a planning problem, and its trajectories as plans.

Formats: URDF and SRDF (https://wiki.ros.org/srdf), `joint_limits.yaml` and `kinematics.yaml` of moveit_configs_utils,
and the text of `planning_scene::PlanningScene::loadGeometryFromStream`.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import yaml

from palpate.arm.urdf import SIZES
from palpate.base import limits
from palpate.base.arrays import Array
from palpate.base.arrays.so3 import quaternions
from palpate.base.arrays.yaml_loader import MOST_OF_PLAN, Dumper, load_all
from palpate.base.errors import OutputError, PlanningError
from palpate.planning import moveit_scene, shorten
from palpate.planning.allowed import disabled_pairs
from palpate.planning.checker import Checker
from palpate.planning.curves import line
from palpate.planning.links import Part
from palpate.planning.planners import levers
from palpate.planning.problem import Problem
from palpate.planning.result import Plan
from palpate.planning.robot import Robot
from palpate.planning.shapes import Capsule
from palpate.planning.world import Obstacle

GROUP = "arm"
_REASONS = {"Cannula": "User", "Linkage": "User"}  # reasons that MoveIt has no word for
_SOLVER = {
    "kinematics_solver": "kdl_kinematics_plugin/KDLKinematicsPlugin",
    "kinematics_solver_search_resolution": 0.005,
    "kinematics_solver_timeout": 0.05,
}


def export(problem: Problem, folder: Path) -> list[Path]:
    """Write URDF, SRDF, limits, kinematics and planning scene of a problem; returns the files.

    Raises:
        OutputError: a file cannot be written.
    """
    name = problem.robot.arm.name
    limits, arm = problem.limits, problem.robot.arm
    rows = {joint: {"has_velocity_limits": True, "max_velocity": float(v), "has_acceleration_limits": True,
                    "max_acceleration": float(a), "has_jerk_limits": True, "max_jerk": float(j)}
            for joint, v, a, j in zip(arm.joint_names, limits.v, limits.a, limits.j, strict=True)}  # fmt: skip
    texts = {
        f"{name}.urdf": urdf(problem),
        f"{name}.srdf": srdf(problem),
        "joint_limits.yaml": yaml.safe_dump({"joint_limits": rows}, sort_keys=False),
        "kinematics.yaml": yaml.safe_dump({GROUP: _SOLVER}, sort_keys=False),
        "planning_scene.scene": scene_text(problem.world.obstacles),
        "planning_scene.yaml": yaml.dump(moveit_scene.planning_scene(problem), sort_keys=False, Dumper=Dumper),
    }
    files = []
    for file, text in texts.items():
        files.append(folder / file)
        try:
            files[-1].write_text(text, encoding="utf-8")
        except OSError as error:
            raise OutputError("the file cannot be written", where=str(files[-1]), why=str(error)) from None
    return files


def urdf(problem: Problem) -> str:
    """The arm's URDF with its base fixed in the link `world`, and the geometry of our checks as <collision>.

    Capsules become cylinders with two spheres. Primitives and meshes of the URDF stay as they are; the files of meshes
    get their full path.
    """
    robot = problem.robot.with_jaws(problem.robot.span[0], problem.robot.span[0])  # MoveIt moves the jaws itself
    tree = ElementTree.fromstring(robot.arm.urdf)
    links = {link.get("name"): link for link in tree.findall("link")}
    for link in links.values():
        for old in link.findall("collision"):
            link.remove(old)
    for body in robot.bodies:
        if body.part is not None:
            _add_part(links[body.link], body.part)
        elif body.mesh is None:
            mount = robot.kinematics.mount[body.link][1]
            _add_capsule(links[body.link], body.capsule.moved(np.asarray(np.linalg.inv(mount))))
    if moveit_scene.FRAME not in links:
        _fix_in_world(tree, robot)
    elif robot.arm.frames[0] != moveit_scene.FRAME or np.abs(robot.X_WB - np.eye(4)).max() > 1e-9:
        raise PlanningError(f"the URDF of {robot.arm.name} has a link 'world' of its own, which is not W of the scene",
                            mend="rename this link in the URDF")  # fmt: skip
    ElementTree.indent(tree)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(tree, encoding="unicode") + "\n"


def _fix_in_world(tree: ElementTree.Element, robot: Robot) -> None:
    """Add the link `world` and the fixed joint that carries the arm's base."""
    ElementTree.SubElement(tree, "link", name=moveit_scene.FRAME)
    joint = ElementTree.SubElement(tree, "joint", name="world_to_base", type="fixed")
    ElementTree.SubElement(joint, "parent", link=moveit_scene.FRAME)
    ElementTree.SubElement(joint, "child", link=robot.arm.frames[0])
    _add_origin(joint, robot.X_WB)


def _add_part(link: ElementTree.Element, part: Part) -> None:
    """A primitive or mesh of the URDF, at its own place."""
    if part.shape == "capsule":
        half = 0.5 * part.size[1] * np.array([0.0, 0.0, 1.0])
        _add_capsule(link, Capsule(-half, half, part.size[0]).moved(part.X_link_part))
        return
    collision = ElementTree.SubElement(link, "collision")
    _add_origin(collision, part.X_link_part)
    shape = ElementTree.SubElement(ElementTree.SubElement(collision, "geometry"), part.shape)
    if part.file is not None:
        shape.set("filename", part.file.as_uri())
        shape.set("scale", " ".join(repr(x) for x in part.size))
        return
    for key in SIZES[part.shape]:
        values = part.size if key == "size" else (part.size[SIZES[part.shape].index(key)],)
        shape.set(key, " ".join(repr(x) for x in values))


def _add_capsule(link: ElementTree.Element, capsule: Capsule) -> None:
    """A capsule as a cylinder and two spheres: URDF has no capsules."""
    X = capsule.pose()
    parts: list[tuple[str, dict[str, str], Array]] = []
    if capsule.length > 1e-9:
        parts.append(("cylinder", {"radius": repr(capsule.radius), "length": repr(capsule.length)}, X))
    for end in (capsule.a, capsule.b)[: 2 if capsule.length > 1e-9 else 1]:
        ball = np.eye(4)
        ball[:3, 3] = end
        parts.append(("sphere", {"radius": repr(capsule.radius)}, ball))
    for shape, size, pose in parts:
        collision = ElementTree.SubElement(link, "collision")
        _add_origin(collision, pose)
        ElementTree.SubElement(ElementTree.SubElement(collision, "geometry"), shape, size)


def _add_origin(element: ElementTree.Element, X: Array) -> None:
    roll, pitch, yaw = np.arctan2(X[2, 1], X[2, 2]), -np.arcsin(np.clip(X[2, 0], -1, 1)), np.arctan2(X[1, 0], X[0, 0])
    if abs(X[2, 0]) > 1.0 - 1e-12:  # gimbal lock: roll and yaw turn about one axis
        roll, yaw = np.arctan2(-X[1, 2], X[1, 1]), 0.0
    xyz, rpy = (" ".join(repr(float(x)) for x in row) for row in (X[:3, 3], (roll, pitch, yaw)))
    ElementTree.SubElement(element, "origin", xyz=xyz, rpy=rpy)


def srdf(problem: Problem) -> str:
    """Group, named states and disabled pairs, with the reason for each pair."""
    arm = problem.robot.arm
    tree = ElementTree.Element("robot", name=ElementTree.fromstring(arm.urdf).get("name", arm.name))
    group = ElementTree.SubElement(tree, "group", name=GROUP)
    ElementTree.SubElement(group, "chain", base_link=arm.frames[0], tip_link=arm.frames[1])
    for name, q in problem.states.items():
        state = ElementTree.SubElement(tree, "group_state", name=name, group=GROUP)
        for joint, value in zip(arm.joint_names, q, strict=True):
            ElementTree.SubElement(state, "joint", name=joint, value=repr(float(value)))
    for pair in disabled_pairs(problem.robot):
        reason = _REASONS.get(pair.reason, pair.reason)
        ElementTree.SubElement(tree, "disable_collisions", link1=pair.one, link2=pair.two, reason=reason)
    ElementTree.indent(tree)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(tree, encoding="unicode") + "\n"


def scene_text(obstacles: Sequence[Obstacle]) -> str:
    """The obstacles as text of MoveIt's planning scene."""
    lines = ["palpate"]
    for obstacle in obstacles:
        lines += [f"* {obstacle.name.replace(' ', '_')}", *_pose_lines(obstacle.X_WO), "1", *_shape_lines(obstacle)]
        lines += [*_pose_lines(np.eye(4)), "0 0 0 0", "0"]
    return "\n".join([*lines, "."]) + "\n"


def _pose_lines(X: Array) -> list[str]:
    w, x, y, z = quaternions(X[None, :3, :3], canonical=True)[0]
    return [" ".join(f"{v:.9g}" for v in X[:3, 3]), " ".join(f"{v:.9g}" for v in (x, y, z, w))]


def _shape_lines(obstacle: Obstacle) -> list[str]:
    solid, size = obstacle.solid, np.ptp(obstacle.solid.bounds, axis=0)
    if solid.kind == "box":
        return ["box", " ".join(f"{x:.9g}" for x in size)]
    if solid.kind == "sphere":
        return ["sphere", f"{0.5 * size[0]:.9g}"]
    if solid.kind == "cylinder":
        return ["cylinder", f"{0.5 * size[0]:.9g} {size[2]:.9g}"]
    if solid.kind == "half-space":
        return ["plane", "0 0 1 0"]
    vertices, triangles = moveit_scene.triangles_of(obstacle)
    return ["mesh", f"{len(vertices)} {len(triangles)}", *(" ".join(f"{x:.9g}" for x in row) for row in vertices),
            *(" ".join(str(i) for i in row) for row in triangles)]  # fmt: skip


def waypoints(message: Any, joint_names: Sequence[str]) -> Array:
    """Joint positions (k, n) of a RobotTrajectory or JointTrajectory, in the order of `joint_names`.

    message: the message as an object of rclpy or rosbags, or as the mapping that `ros2 topic echo` prints.

    Raises:
        PlanningError: the message has no trajectory of these joints.
    """

    def get(value: Any, key: str) -> Any:
        return value.get(key) if isinstance(value, dict) else getattr(value, key, None)

    inner = get(message, "joint_trajectory") or message
    names, points = get(inner, "joint_names"), get(inner, "points")
    if not names or points is None or len(points) == 0:
        raise PlanningError("the message is no trajectory", mend="give a RobotTrajectory or a JointTrajectory")
    missing = [name for name in joint_names if name not in names]
    if missing:
        what = f"the trajectory does not move {', '.join(missing)}"
        raise PlanningError(
            what, why=f"its joints are {', '.join(names)}", mend="rename its joints, or use another arm"
        )
    order = [list(names).index(name) for name in joint_names]
    try:
        rows = np.array([np.asarray(get(point, "positions"), dtype=np.float64)[order] for point in points])
    except (IndexError, TypeError, ValueError) as error:
        raise PlanningError("a point of the trajectory has not one position per joint", why=str(error)) from None
    if not np.isfinite(rows).all():
        raise PlanningError("a position of the trajectory is not finite", mend="record it again")
    return rows


def read(path: Path) -> Any:
    """A trajectory message from a YAML or JSON file.

    Raises:
        PlanningError: the file cannot be read.
    """
    try:
        documents = [d for d in load_all(limits.read_text(path), MOST_OF_PLAN) if d]
        if not isinstance(documents[0], dict):
            raise yaml.YAMLError(f"it holds a {type(documents[0]).__name__}")
        return documents[0]
    except (OSError, UnicodeDecodeError, yaml.YAMLError, IndexError) as error:
        raise PlanningError("the trajectory cannot be read", where=str(path), why=str(error)) from None


def checked(problem: Problem, message: Any, clearance: float | None = None) -> Plan:
    """A trajectory of MoveIt as a plan of ours: proved to keep the clearance [m], with times of our own.

    Without success, `reason` names the first pair that comes too near.

    Raises:
        PlanningError: the message is no trajectory of the arm.
    """
    begin, arm = time.monotonic(), problem.robot.arm
    asked = problem.clearance if clearance is None else clearance
    rows = waypoints(message, arm.joint_names)
    rows = rows[np.r_[True, np.abs(np.diff(rows, axis=0)).max(axis=1) > 1e-9]]
    base = problem.empty_plan(asked, 0, "trajectory")
    outside = ((rows < arm.q_min - 1e-9) | (rows > arm.q_max + 1e-9)).any(axis=0)
    if outside.any():
        names = ", ".join(np.array(arm.joint_names)[outside])
        return problem.failed(base, f"the trajectory leaves the limits of {names}", begin=begin)
    checker = Checker(problem.robot, problem.world)
    refusal = checker.refusal(rows[0], asked)
    if refusal is not None:
        return problem.failed(
            base, f"the trajectory starts too near: {' and '.join(refusal.pair)}", refusal.pair, begin
        )
    for k in range(len(rows) - 1):
        found = checker.blocked(line(rows[k], rows[k + 1]), asked)
        if found is not None:
            reason = (
                f"{' and '.join(found.pair)} come nearer than {1e3 * asked:g} mm after point {k + 1} of {len(rows)}"
            )
            return problem.failed(base, reason, found.pair, begin)
    curves = shorten.rounded(checker, rows, levers(arm), asked, begin + 60.0)
    return problem.finished(base, checker, curves, begin)
