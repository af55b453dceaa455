"""A plan as guidance: the hand is led along it, and may leave it."""

from pathlib import Path

import numpy as np
import pytest
from planning_worlds import problem, reaching

from palpate import Scene
from palpate.base.errors import GuidanceError
from palpate.scene.guidance.files import read_rows
from palpate.scene.guidance.fixture import Fixture
from palpate.scene.guidance.one_line import WALL
from palpate.scene.rig import build

SCENE = """
objects: [{name: floor, box: {size: [0.3, 0.3, 0.01]}, pose: {xyz: [0, 0, -0.20]}}]
arms: {follower: {base: {xyz: [0, 0, 0]}}}
operator: {path: [{t: 0, xyz: [-0.05, 0.02, -0.12]}]}
guidance: [{follow: {plan: plan.yaml}}]
"""


@pytest.fixture
def plan_file(tmp_path: Path) -> Path:
    found = problem().plan(reaching(-0.055, 0.0, -0.12), reaching(0.055, 0.0, -0.12), seed=2, timeout=60.0)
    found.save(tmp_path / "plan.yaml", problem().robot.arm)
    return tmp_path / "plan.yaml"


def test_the_hand_is_pulled_to_the_plan(plan_file: Path) -> None:
    scene = Scene.parse(SCENE, str(plan_file.parent / "scene.yaml"))
    guide, tube = scene.guidance
    assert (guide.name, guide.role.name, guide.hard) == ("plan", "guide", False)
    assert (tube.name, tube.role.name, tube.hard) == ("plan-tube", "keep-in", False)
    places, rotations = read_rows(plan_file)
    assert rotations is not None
    np.testing.assert_allclose(places[0], [-0.055, 0.0, -0.12], atol=1e-9)
    np.testing.assert_allclose(places[-1], [0.055, 0.0, -0.12], atol=1e-9)
    simulation = build(scene).simulation()
    rows = simulation.run(400)
    assert np.isfinite(rows).all()


def test_the_wall_of_the_tube_stands_at_the_clearance_of_the_plan(plan_file: Path) -> None:
    scene = Scene.parse(SCENE, str(plan_file.parent / "scene.yaml"))
    places, _ = read_rows(plan_file)
    along = places[len(places) // 2 + 1] - places[len(places) // 2 - 1]
    side = np.cross(along, [0.0, 1.0, 0.0])
    side *= 1.0 / np.linalg.norm(side)
    context = build(scene).context
    for away, force in ((0.0029, 0.0), (0.0031, 0.0001 * WALL)):
        X = np.eye(4)
        X[:3, 3] = places[len(places) // 2] + away * side
        F = scene.guidance[1].make(context).evaluate(X, 0.0, np.zeros(6))["F"]
        assert np.linalg.norm(F[:3]) == pytest.approx(force, abs=0.004), away


def test_keys_of_the_line_go_to_the_path_or_to_its_tube(plan_file: Path) -> None:
    line = "guidance: [{follow: {plan: plan.yaml}, hard: true, role: {name: guide, margin: 3 mm}, authority: 0.5}]"
    scene = Scene.parse(
        SCENE.replace("guidance: [{follow: {plan: plan.yaml}}]", line), str(plan_file.parent / "s.yaml")
    )
    guide, tube = scene.guidance
    assert (guide.hard, guide.role.margin, guide.authority) == (False, 0.003, 0.5)
    assert (tube.hard, tube.role.margin, tube.authority) == (True, 0.0, 0.5)
    again = Scene.parse(build(scene).resolved_yaml(), str(plan_file.parent / "s.yaml"))
    assert [f.name for f in again.guidance] == ["plan", "plan-tube"]


def test_a_tube_without_radius_needs_a_plan() -> None:
    with pytest.raises(GuidanceError, match="radius"):
        Fixture.from_yaml("{geometry: {tube: {file: a.csv}}, role: keep-in}")


@pytest.mark.parametrize("text", ["{}", "tip_xyz_m: [[0, 0, 0]]", "tip_xyz_m: 3\ntip_wxyz: 4", "a: [",
                                  "tip_xyz_m: [[.nan, 0, 0]]\ntip_wxyz: [[1, 0, 0, 0]]"])  # fmt: skip
def test_a_file_that_is_no_plan_is_named(tmp_path: Path, text: str) -> None:
    file = tmp_path / "plan.yaml"
    file.write_text(text)
    with pytest.raises(GuidanceError, match="plan"):
        read_rows(file)
