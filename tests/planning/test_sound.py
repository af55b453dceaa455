"""A plan file is not trusted: whatever was changed in it is refused before the arm moves."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

pytest.importorskip("coal", reason="motion planning needs the extra planning")
pytest.importorskip("ompl", reason="motion planning needs the extra planning")
pytest.importorskip("ruckig", reason="motion planning needs the extra planning")

from palpate.base.errors import PlanningError
from palpate.planning import Execution, Problem, load
from palpate.ros.same_arm import require_name
from palpate.scene import Scene

SCENE = """
objects:
  - {name: left, box: {size: [0.02, 0.02, 0.02]}, pose: {xyz: [0.083, 0, 0.04]}}
  - {name: right, box: {size: [0.02, 0.02, 0.02]}, pose: {xyz: [-0.083, 0, 0.04]}}
arms:
  leader: {base: {xyz: [0.345, 0.243, 0.219], rpy_deg: [0, 0, -20]}}
  follower: {base: {xyz: [0, 0, 0.12]}}
planning: {arm: PSM1, clearance: 2 mm, speed: 0.2}
operator: {path: [{t: 0, xyz: [0.05, 0, 0]}]}
"""
START, MIDDLE, GOAL = (np.array([yaw, 0.0, 0.12, 0, 0, 0]) for yaw in (-0.3, 0.0, 0.2))


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The problem, and the content of a plan file of two lines."""
    folder = tmp_path_factory.mktemp("sound")
    (folder / "scene.yaml").write_text(SCENE)
    problem = Problem.of(Scene.load(folder / "scene.yaml"))
    plan = problem.through([START, MIDDLE, GOAL])
    assert plan.success, plan.reason
    plan.save(folder / "plan.yaml", problem.robot.arm)
    return problem, yaml.safe_load((folder / "plan.yaml").read_text())


def changed(made, tmp_path, change):
    problem, data = made
    data = yaml.safe_load(yaml.safe_dump(data))
    change(data)
    (tmp_path / "plan.yaml").write_text(yaml.safe_dump(data))
    return problem, load(tmp_path / "plan.yaml")


def test_plan_as_it_was_saved_is_executed(made, tmp_path):
    problem, plan = changed(made, tmp_path, lambda data: None)
    Execution(problem, plan, START)


def jump(data):
    data["curves"][-1][0][2] += 0.05  # 50 mm of insertion


def faster(data):
    data["v_max"] = [3.0 * v for v in data["v_max"]]


def harder(data):
    data["a_max"][1] *= 1.01


def jerkier(data):
    data["j_max"] = [100.0 * j for j in data["j_max"]]


def no_limit(data):
    data["v_max"][0] = float("nan")


def elsewhere(data):
    data["X_WB"][0][3] += 0.003


def turned(data):
    c, s = np.cos(0.02), np.sin(0.02)
    data["X_WB"] = (
        np.array(data["X_WB"]) @ np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    ).tolist()


def other_arm(data):
    data["arm"] = "PSM2"


def other_joints(data):
    data["joint_names"] = data["joint_names"][::-1]


def out_of_range(data):
    data["curves"][-1][-1][2] = 0.4


def other_metric(data):
    data["scale"] = [0.1 * x for x in data["scale"]]


def touching(data):
    data["clearance_asked_m"] = -0.01


def through_the_block(data):
    data["curves"][-1][-1][0] = 1.2


CHANGES = {
    jump: "do not join: insertion would jump by 0.05",
    faster: "speed of up to",
    harder: "acceleration of up to",
    jerkier: "jerk of up to",
    no_limit: "speed of up to nan",
    elsewhere: "3.0 mm and 0.0 deg from where the scene has it",
    turned: "0.0 mm and 1.1 deg from where the scene has it",
    other_arm: "moves PSM2, not PSM1",
    other_joints: "moves the joints",
    out_of_range: "leads insertion to",
    other_metric: "another arm's lengths",
    touching: "a clearance of -10 mm",
    through_the_block: "the plan is not free",
}


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
def test_changed_plan_is_refused(made, tmp_path, change):
    problem, plan = changed(made, tmp_path, change)
    with pytest.raises(PlanningError, match=CHANGES[change].replace("(", r"\(")):
        Execution(problem, plan)


def test_slower_limits_are_allowed(made, tmp_path):
    def slower(data):
        for key in ("v_max", "a_max", "j_max"):
            data[key] = [0.5 * x for x in data[key]]

    Execution(*changed(made, tmp_path, slower), START)


def test_arm_of_another_name_is_refused(made):
    problem, _ = made
    plan = replace(problem.empty_plan(0.002, 0, "straight line"), arm="PSM1")
    for name in ("PSM1", "/PSM1", "right/PSM1"):
        require_name(plan, name)
    for name in ("PSM2", "PSM11", "PSM1/left"):
        with pytest.raises(PlanningError, match="proved for PSM1, not for"):
            require_name(plan, name)
