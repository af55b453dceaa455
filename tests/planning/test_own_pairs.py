"""Pairs of an arm's own bodies, judged by Coal on the geometry that Pinocchio reads from the same URDF."""

import numpy as np
import pytest
import trimesh
from planning_worlds import at
from urdf_judge import Judge

from palpate import Arm
from palpate.planning.allowed import disabled_pairs
from palpate.planning.checker import Checker
from palpate.planning.curves import corner, line
from palpate.planning.problem import Problem
from palpate.planning.robot import Robot
from palpate.planning.timing import Limits
from palpate.planning.verify import verify
from palpate.planning.world import World

HOOK = [((0.3, 0.04, 0.04), (0.15, 0.0, 0.0)), ((0.04, 0.04, 0.16), (0.28, 0.0, 0.06))]  # boxes: size, place
LINK = """<link name="{0}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>
</inertial>{1}</link>"""
JOINT = """<joint name="j{k}" type="revolute"><parent link="{a}"/><child link="{b}"/><origin xyz="{xyz}"/>
<axis xyz="{axis}"/><limit lower="-2.8" upper="2.8" velocity="1" effort="50"/></joint>"""
FORMS = ("box", "mesh")
ORDER = ["base", "link0", "link1", "link2", "link3"]
PAIRS = {frozenset((a, b)) for i, a in enumerate(ORDER) for j, b in enumerate(ORDER) if abs(i - j) > 1}


def made(folder, form: str):
    """An arm of four hooks, whose capsules overlap where the hooks do not, with its judge."""
    hook = trimesh.util.concatenate([trimesh.creation.box(size, at(*place)) for size, place in HOOK])
    hook.export(folder / "hook.stl")
    if form == "mesh":
        body = '<collision><geometry><mesh filename="hook.stl"/></geometry></collision>'
    else:
        body = "".join(
            f'<collision><origin xyz="{" ".join(map(str, place))}"/><geometry><box size="{" ".join(map(str, size))}"/>'
            "</geometry></collision>"
            for size, place in HOOK
        )
    base = '<collision><origin xyz="0.1 0 -0.05"/><geometry><box size="0.4 0.3 0.06"/></geometry></collision>'
    links = f'<link name="base">{base}</link>' + "".join(LINK.format(name, body) for name in ORDER[1:])
    places = ("0 0 0.05", "0.28 0 0.16", "0.28 0 0.16", "0.28 0 0.16")
    axes = ("0 0 1", "0 1 0", "0 1 0", "1 0 0")
    joints = "".join(
        JOINT.format(k=k, a=ORDER[k], b=ORDER[k + 1], xyz=places[k], axis=axes[k]) for k in range(len(places))
    )
    (folder / "arm.urdf").write_text(f'<robot name="hooks">{links}{joints}</robot>')
    (folder / "arm.yaml").write_text("urdf: arm.urdf\n")
    return Robot("H", Arm.load(folder / "arm.yaml"), np.eye(4)), Judge(folder / "arm.urdf")


@pytest.mark.parametrize("form", FORMS)
def test_configurations_are_refused_exactly_where_the_geometry_touches(form, tmp_path) -> None:
    robot, judge = made(tmp_path, form)
    checker, rng = Checker(robot, World()), np.random.default_rng(0)
    rows = rng.uniform(robot.arm.q_min, robot.arm.q_max, (300, robot.arm.n))
    truth = np.array([bool(judge.touching(q, PAIRS)) for q in rows])
    ours = np.array([checker.refusal(q, 0.0) is not None for q in rows])
    assert 60 < truth.sum() < 240
    np.testing.assert_array_equal(ours, truth)


@pytest.mark.parametrize("form", FORMS)
def test_plans_do_not_lead_the_arm_through_itself(form, tmp_path) -> None:
    robot, judge = made(tmp_path, form)
    arm, rng = robot.arm, np.random.default_rng(1)
    problem = Problem(robot, World(), {"home": arm.home, "current": arm.home}, Limits.of(arm, 0.5), 0.002)
    found = 0
    for seed in range(6):
        ends = []
        while len(ends) < 2:
            q = rng.uniform(arm.q_min, arm.q_max)
            ends += [] if judge.touching(q, PAIRS) else [q]
        plan = problem.plan(*ends, seed=seed, timeout=5.0)
        found += plan.success
        for q in np.concatenate([curve.at(np.linspace(0.0, 1.0, 60)) for curve in plan.curves] or [np.empty((0, 4))]):
            assert not judge.touching(q, PAIRS)
        if plan.success:
            assert verify(problem, plan).own_contacts == 0
    assert found >= 4


def test_the_dense_check_sees_an_arm_in_itself(tmp_path) -> None:
    robot, judge = made(tmp_path, "mesh")
    arm = robot.arm
    problem = Problem(robot, World(), {"home": arm.home, "current": arm.home}, Limits.of(arm, 0.5), 0.002)
    plan = problem.plan(np.array([0.0, 0.3, 0.3, 0.0]), np.array([0.0, 0.2, 0.2, 0.0]))
    assert plan.success
    rng = np.random.default_rng(2)
    while True:
        q = rng.uniform(arm.q_min, arm.q_max)
        if judge.touching(q, PAIRS):
            break
    from dataclasses import replace

    through = replace(plan, curves=(line(plan.curves[0].controls[0], q),))
    assert verify(problem, through).own_contacts > 0
    assert Checker(robot, World()).blocked(line(plan.curves[0].controls[0], q), 0.0) is not None


def test_a_pair_that_touches_at_home_is_still_checked(tmp_path) -> None:
    robot, judge = made(tmp_path, "mesh")
    rng = np.random.default_rng(3)
    while True:
        q = rng.uniform(robot.arm.q_min, robot.arm.q_max)
        if judge.touching(q, PAIRS):
            break
    (tmp_path / "arm.yaml").write_text(f"urdf: arm.urdf\nhome: [{', '.join(map(str, q))}]\n")
    robot = Robot("H", Arm.load(tmp_path / "arm.yaml"), np.eye(4))
    assert Checker(robot, World()).refusal(q, 0.0) is not None
    assert {pair.reason for pair in disabled_pairs(robot)} <= {"Adjacent", "Never"}


def test_the_user_may_allow_two_links_to_touch(tmp_path) -> None:
    robot, judge = made(tmp_path, "mesh")
    rng = np.random.default_rng(4)
    while True:
        q = rng.uniform(robot.arm.q_min, robot.arm.q_max)
        pairs = judge.touching(q, PAIRS)
        if pairs:
            break
    assert Checker(robot, World((), frozenset(pairs))).refusal(q, 0.0) is None


def test_no_point_moves_against_another_body_farther_than_the_bound(tmp_path) -> None:
    robot, _ = made(tmp_path, "box")
    rng = np.random.default_rng(5)
    pairs = np.array([(i, j) for i in range(len(robot.bodies)) for j in range(i)])
    tight = 0.0
    for _ in range(30):
        a, b = rng.uniform(robot.arm.q_min, robot.arm.q_max, (2, robot.arm.n))
        curve = line(a, b) if rng.uniform() < 0.5 else corner(a, 0.5 * (a + b) + 0.05 * rng.normal(size=len(a)), b)
        half = rng.uniform(0.01, 0.3)
        placed = robot.placed(curve.at(np.array([0.5])))
        bound = robot.reach_between(placed, pairs, curve.rate, np.array([half]))[0]
        others = robot.placed(curve.at(np.linspace(0.5 - half, 0.5 + half, 31)))

        def seen(where, pair):  # ends of one body in the frame of the other
            i, j = pair
            X = where.X_W[:, j]
            return np.einsum("kji,kej->kei", X[:, :3, :3], where.ends_W[:, i] - X[:, None, :3, 3])

        for pair, limit in zip(pairs, bound, strict=True):
            moved = np.linalg.norm(seen(others, pair) - seen(placed, pair), axis=-1).max()
            assert moved <= limit + 1e-12
            tight = max(tight, float(moved / max(limit, 1e-9)))
    assert tight > 0.5
