"""Objects other than meshes in a scene file: rendering, drawing, checks and records."""

import json

import numpy as np
import pytest

from palpate import Scene, Session
from palpate.base.errors import PalpateWarning, SceneError, SurfaceError
from palpate.scene.rig import build
from palpate.viewer.staging import stage_of
from palpate.world import surfaces

HAND = "operator: {palpate: {approach: 0.4, press: 0.3, slide: 0.5, leave: 0.2, length: 0.01}}\n"
SOLIDS = {
    "plane": "{}",
    "sphere": "{radius: 0.03}",
    "box": "{size: [0.06, 0.06, 0.02]}",
    "cylinder": "{radius: 0.03, length: 0.02}",
    "capsule": "{radius: 0.02, length: 0.04}",
    "implicit": "{half: [0.04, 0.03, 0.02], exponents: [4, 2, 4]}",
}


def write_ball(path, spacing=0.002):
    x = np.arange(-0.024, 0.025, spacing)
    at = np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1)
    surfaces.DistanceGrid(np.linalg.norm(at, axis=-1) - 0.02, np.full(3, x[0]), spacing).save(path)


@pytest.mark.parametrize("kind", SOLIDS)
def test_objects_of_every_kind_are_rendered(kind):
    rig = build(Scene.parse(f"objects:\n  - {kind}: {SOLIDS[kind]}\n    stiffness: 400\n{HAND}"))
    assert rig.scene.objects[0].name == rig.scene.objects[0].source == kind
    stage = stage_of(rig)
    assert len(stage.objects[0].triangles) >= 2
    session = Session(rig.scene)
    depths = [float(session.step().tick["depth"]) for _ in range(1000)]
    assert 1e-3 < max(depths) < 0.01
    assert (np.array(depths)[:300] == 0).all()


def test_grid_file_is_found_next_to_the_scene(tmp_path):
    write_ball(tmp_path / "ball.npz")
    (tmp_path / "s.yaml").write_text(f"objects:\n  - sdf: ball.npz\n    stiffness: 400\n{HAND}")
    rig = build(Scene.load(tmp_path / "s.yaml"))
    assert rig.scene.objects[0].name == "ball"
    np.testing.assert_allclose(rig.surfaces[0].bounds, [[-0.02] * 3, [0.02] * 3], atol=2e-4)
    assert str(tmp_path / "ball.npz") in rig.resolved_yaml(absolute=True)


def test_grid_coarser_than_the_tool_gives_a_warning(tmp_path):
    write_ball(tmp_path / "ball.npz", 0.003)
    (tmp_path / "s.yaml").write_text(f"objects:\n  - sdf: ball.npz\n    stiffness: 400\n{HAND}")
    with pytest.warns(PalpateWarning, match="coarser than the tool's sphere: 3 mm between its nodes, 2 mm radius"):
        build(Scene.load(tmp_path / "s.yaml"))


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        ("objects: [{sphere: {radius: 0.01}, box: {size: [1, 1, 1]}}]", SceneError, "sphere and box are given"),
        ("objects: [{sphere: {radius: -1}}]", SceneError, r"objects\[0\].sphere.radius must be greater than 0"),
        ("objects: [{sphere: {}}]", SceneError, r"'objects\[0\].sphere.radius' is missing"),
        ("objects: [{sphere: {radus: 1}}]", SceneError, "did you mean 'radius'"),
        ("objects: [{box: {size: [1, 1]}}]", SceneError, r"objects\[0\].box.size"),
        ("objects: [{implicit: {half: [1, 1, 1], exponents: [2, 3, 2]}}]", SceneError, "must be a multiple of 2"),
        ("objects: [{sdf: nowhere.npz}]", SurfaceError, r"s.yaml:1: grid file not found\n  why: nowhere.npz"),
    ],
)
def test_mistakes_are_reported(text, error, message):
    with pytest.raises(error, match=message):
        build(Scene.parse(text, "s.yaml"))


def test_methods_that_need_triangles_report_it():
    scene = Scene.parse(f"objects: [{{name: pea, sphere: {{radius: 0.03}}}}]\ncontact: {{method: paper-alg1}}\n{HAND}")
    with pytest.raises(SceneError, match="object 'pea' has no triangles"):
        build(scene)


def test_check_reports_a_grid(tmp_path, capsys):
    from palpate.cli import main

    write_ball(tmp_path / "ball.npz")
    assert main(["check", str(tmp_path / "ball.npz"), "--json", str(tmp_path / "c.json")]) == 0
    report = json.loads((tmp_path / "c.json").read_text())["grid"]
    assert report["nodes"] == [25, 25, 25]
    assert report["volume_m3"] == pytest.approx(4 / 3 * np.pi * 0.02**3, rel=0.02)
    assert "25 x 25 x 25" in capsys.readouterr().out
