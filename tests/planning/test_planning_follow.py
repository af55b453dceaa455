"""A plan as guidance: the hand is led along it, and may leave it."""

from pathlib import Path

import numpy as np
import pytest
from planning_worlds import problem, reaching

from palpate import Scene
from palpate.errors import GuidanceError
from palpate.guidance.files import read_rows
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
    (fixture,) = scene.guidance
    assert fixture.name == "plan"
    assert not fixture.hard
    places, rotations = read_rows(plan_file)
    assert rotations is not None
    np.testing.assert_allclose(places[0], [-0.055, 0.0, -0.12], atol=1e-9)
    np.testing.assert_allclose(places[-1], [0.055, 0.0, -0.12], atol=1e-9)
    simulation = build(scene).simulation()
    rows = simulation.run(400)
    assert np.isfinite(rows).all()


@pytest.mark.parametrize("text", ["{}", "tip_xyz_m: [[0, 0, 0]]", "tip_xyz_m: 3\ntip_wxyz: 4", "a: [",
                                  "tip_xyz_m: [[.nan, 0, 0]]\ntip_wxyz: [[1, 0, 0, 0]]"])  # fmt: skip
def test_a_file_that_is_no_plan_is_named(tmp_path: Path, text: str) -> None:
    file = tmp_path / "plan.yaml"
    file.write_text(text)
    with pytest.raises(GuidanceError, match="plan"):
        read_rows(file)
