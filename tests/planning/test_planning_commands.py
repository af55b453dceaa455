"""The commands of motion planning and the keys that they write."""

import json
from pathlib import Path

import json_contract
import numpy as np
import planning_worlds  # skips without the packages of the extra
import pytest
from rich.console import Console

from palpate.cli import main
from palpate.planning import Problem
from palpate.scene import Scene
from palpate_lab.verify.bench import planning as bench

SCENE = """
objects: [{name: ball, sphere: {radius: 0.01}, pose: {xyz: [0, 0.03, -0.13]}}]
arms: {follower: {base: {xyz: [0, 0, 0]}}}
operator: {path: [{t: 0, xyz: [-0.03, 0.0, -0.12]}]}
planning:
  states: {there: [0.3, 0, 0.12, 0, 0, 0]}
  instruments: [{name: PSM2, base: {xyz: [0.3, 0, 0], rpy_deg: [0, 0, 90]}}]
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    file = tmp_path / "scene.yaml"
    file.write_text(SCENE)
    return file


def test_plan_writes_its_files_and_keys(scene: Path, tmp_path: Path) -> None:
    out, figure, values = tmp_path / "plan.yaml", tmp_path / "plan.png", tmp_path / "plan.json"
    assert main(["plan", str(scene), "--to", "there", "--out", str(out), "--figure", str(figure), "--json",
                 str(values)]) == 0  # fmt: skip
    found = json.loads(values.read_text())
    assert set(found) == json_contract.keys("plan")
    assert found["success"]
    assert found["clearance_m"] >= 0.003
    np.testing.assert_allclose(found["joints"][-1], [0.3, 0, 0.12, 0, 0, 0], atol=1e-9)
    assert figure.stat().st_size > 5000
    assert out.exists()


def test_plan_without_success_exits_with_one(scene: Path, tmp_path: Path) -> None:
    values = tmp_path / "plan.json"
    assert main(["plan", str(scene), "--to", "pose:0,0,-0.9", "--json", str(values)]) == 1
    assert "unreachable" in json.loads(values.read_text())["reason"]


@pytest.mark.parametrize("change", [["--arm", "PSM7"], ["--clearance", "red"], ["--to", "nowhere"],
                                    ["--trajectory", "missing.yaml"]])  # fmt: skip
def test_a_mistake_exits_with_two(scene: Path, change: list[str]) -> None:
    assert main(["plan", str(scene), *change]) == 2


def test_export_names_its_files(scene: Path, tmp_path: Path) -> None:
    values = tmp_path / "files.json"
    assert main(["export", "moveit", str(scene), "--out", str(tmp_path / "moveit"), "--json", str(values)]) == 0
    found = json.loads(values.read_text())
    assert set(found) == json_contract.keys("export moveit")
    assert all(Path(file).is_file() for file in found["files"])


def test_other_instruments_and_held_objects_are_part_of_the_scene(scene: Path) -> None:
    made = Problem.of(Scene.load(scene))
    assert any(o.name.startswith("PSM2/shaft") for o in made.world.obstacles)
    held = Scene.parse(SCENE + "  attached: [{object: ball, link: tool}]\n", str(scene))
    made = Problem.of(held)
    assert "ball" in [body.name for body in made.robot.bodies]
    assert "ball" not in [o.name for o in made.world.obstacles]


def test_the_bench_finds_every_motion_and_no_violation() -> None:
    rows = bench.run(1)
    assert [row["scene"] for row in rows] == list(bench.SCENES)
    for row in rows:
        assert set(row) == json_contract.keys("bench planning")
        assert row["success_rate"] == 1.0
        assert row["violations"] == 0
        assert row["largest_step_m"] <= 2.5e-4
        assert row["worst_rate"] <= 1.0
    assert planning_worlds is not None


def test_the_study_finds_contacts_and_agrees_with_brute_force(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from palpate_lab.studies.collisions import work
    from palpate_lab.studies.collisions.command import Command

    pytest.importorskip("nrrd")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(work, "STEPS", 12)
    found = Command(figures=tmp_path, poses=60).study(Console(quiet=True))
    assert set(found.json) == json_contract.keys("study collisions")
    assert {row["mesh"] for row in found.json["pairs"]} == {"liver", "skeleton"}
    assert found.json["brute_force"]["disagreements"] == 0
    assert all(file.is_file() for file in found.draw(tmp_path))


def test_queries_of_the_hooks_need_the_search() -> None:
    (row,) = bench.hooks(1, names=("RRTConnect",))
    assert set(row) == json_contract.keys("bench planning")
    assert (row["success_rate"], row["straight"], row["retracted"], row["violations"]) == (1.0, 0, 0, 0)


@pytest.mark.usefixtures("without_figures")
def test_run_executes_a_plan_and_says_what_became_of_it(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, runs = tmp_path / "plan.yaml", str(tmp_path / "runs")
    assert main(["plan", str(scene), "--to", "there", "--retreat", "1cm", "--out", str(out)]) == 0
    run = ["run", str(scene), "--headless", "--duration", "0.3", "--out", runs]
    assert main([*run, "--plan", str(out), "--record-places", str(tmp_path / "places.yaml")]) == 0
    assert "plan: moving at 0." in capsys.readouterr().out
    assert (tmp_path / "places.yaml").is_file()
    assert main([*run, "--plan", str(out), "--speed", "7"]) == 2
    assert "speed must lie in 0 to 1" in capsys.readouterr().err
    assert main(["plan", str(scene), "--to", "there", "--approach", "abc"]) == 2
    assert main(["plan", str(scene), "--through", str(tmp_path / "places.yaml")]) == 2
    assert "no recorded place" in capsys.readouterr().err
