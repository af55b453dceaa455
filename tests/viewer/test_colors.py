"""Colours of objects: from the scene, from the mesh file, and what lies inside is seen through."""

import io
import json

import numpy as np
import pytest
import trimesh
from PIL import Image

from palpate.base.errors import SceneError
from palpate.scene import Scene
from palpate.scene.rig import build
from palpate.viewer.skins import glb
from palpate.viewer.staging import stage_of
from palpate.world.mesh import Mesh
from palpate.world.mesh.colors import colors_of

BALL = trimesh.creation.icosphere(3, 0.03)
EXPECTED = (BALL.vertices / 0.06 + 0.5) * 255.0
"""Colour by place: red along x, green along y, blue along z."""


def textured():
    picture = np.zeros((64, 64, 3), np.uint8)
    picture[:, :, 0], picture[:, :, 1] = np.linspace(0, 255, 64), np.linspace(255, 0, 64)[:, None]
    uv = BALL.vertices[:, :2] / 0.06 + 0.5
    skin = trimesh.visual.TextureVisuals(uv=uv, image=Image.fromarray(picture))
    return trimesh.Trimesh(BALL.vertices, BALL.faces, visual=skin, process=False)


def painted():
    colors = np.c_[np.rint(EXPECTED), np.full(len(EXPECTED), 255)].astype(np.uint8)
    return trimesh.Trimesh(BALL.vertices, BALL.faces, vertex_colors=colors, process=False)


@pytest.mark.parametrize("name", ["v.ply", "v.obj", "v.glb", "t.obj", "t.glb"])
def test_colors_of_files_are_found_at_their_vertices(tmp_path, name):
    made = painted() if name[0] == "v" else textured()
    made.export(tmp_path / name)
    mesh = Mesh.load(tmp_path / name, "m")
    found = colors_of(tmp_path / name, mesh.vertices)
    expected = (mesh.vertices / 0.06 + 0.5) * 255.0 * ([1, 1, 1] if name[0] == "v" else [1, 1, 0])
    np.testing.assert_allclose(found, expected, atol=4.5)


@pytest.mark.parametrize("name", ["p.ply", "p.obj", "p.glb", "p.stl"])
def test_files_without_colors_have_none(tmp_path, name):
    trimesh.Trimesh(BALL.vertices, BALL.faces, process=False).export(tmp_path / name)
    assert colors_of(tmp_path / name, BALL.vertices) is None
    assert colors_of(tmp_path / "missing.ply", BALL.vertices) is None


def test_scene_color_wins_over_that_of_the_file(tmp_path):
    painted().export(tmp_path / "ball.ply")
    text = "objects: [{mesh: ball.ply, unit: m, pose: {xyz: [0.1, 0, 0]}%s}]\n"
    stage = stage_of(build(Scene.parse(text % "", str(tmp_path / "s.yaml"))))
    assert stage.objects[0].color is None
    assert np.ptp(stage.objects[0].colors, axis=0).min() > 200.0
    for given in ("[140, 40, 32]", '"#8c2820"'):
        stage = stage_of(build(Scene.parse(text % f", color: {given}", str(tmp_path / "s.yaml"))))
        assert stage.objects[0].color == (140, 40, 32)
        assert stage.objects[0].colors is None


@pytest.mark.parametrize("bad", ["red", '"#12345"', "[1, 2]", "[1, 2, 300]", "[0.5, 0.2, 0.1]", "7"])
def test_bad_colors_are_named(bad):
    with pytest.raises(SceneError, match=r"color") as caught:
        Scene.parse(f"objects: [{{sphere: {{radius: 0.03}}, color: {bad}}}]\n")
    assert "mend:" in str(caught.value)


def test_only_objects_that_hold_another_are_seen_through():
    text = "objects: [{name: liver, sphere: {radius: 0.05}}, {name: nodule, sphere: {radius: 0.01}%s}]\n"
    inside = stage_of(build(Scene.parse(text % ", pose: {xyz: [0.02, 0, 0]}")))
    beside = stage_of(build(Scene.parse(text % ", pose: {xyz: [0.055, 0.03, 0.03]}")))
    assert [obj.holds for obj in inside.objects] == [True, False]
    assert [obj.holds for obj in beside.objects] == [False, False]


def test_gltf_of_a_painted_surface_keeps_shape_colors_and_opacity():
    read = trimesh.load(io.BytesIO(glb(np.hstack([BALL.vertices, EXPECTED]), BALL.faces, 0.5)), "glb", force="mesh")
    order = np.argmin(np.linalg.norm(BALL.vertices[:, None] - read.vertices[None], axis=2), axis=1)
    np.testing.assert_allclose(read.vertices[order], BALL.vertices, atol=1e-8)
    np.testing.assert_allclose(read.area, BALL.area, rtol=1e-6)
    data = glb(np.hstack([BALL.vertices, EXPECTED]), BALL.faces, 0.5)
    tree = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    assert tree["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][3] == 0.5
    assert tree["materials"][0]["alphaMode"] == "BLEND"
    assert {"POSITION", "NORMAL", "COLOR_0"} <= set(tree["meshes"][0]["primitives"][0]["attributes"])
