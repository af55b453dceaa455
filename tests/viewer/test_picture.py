"""The picture is light where a browser renders by software, says so, and can be chosen."""

import json
from types import SimpleNamespace
from unittest.mock import MagicMock

import numpy as np
import pytest

pytest.importorskip("viser", reason="the viewer is not installed (extra viewer)")

from palpate import _core
from palpate.arm import Arm
from palpate.record.ticks import TICK
from palpate.scene import Scene
from palpate.scene.rig import build
from palpate.viewer import fixtures
from palpate.viewer.arms import ArmDrawing
from palpate.viewer.fixtures import FixtureDrawing
from palpate.viewer.organs import LIGHT_TRIANGLES, OrganDrawing
from palpate.viewer.page import write_page
from palpate.viewer.picture import FULL, LIGHT, Picture, in_words, read
from palpate.viewer.stage import ArmPlace, TouchedObject
from palpate.viewer.staging import stage_of
from palpate.world.shapes.organs import organ

GPU = {"renderer": "ANGLE (a card)", "software": False, "slow": False, "fps": 60, "width": 640, "height": 700}
NO_GPU = GPU | {"renderer": "SwiftShader <b>", "software": True, "fps": 28.4}


@pytest.fixture
def picture():
    server = MagicMock()
    server.gui.add_dropdown.return_value = SimpleNamespace(value="automatic", on_update=lambda _: None)
    server.gui.add_text.return_value = SimpleNamespace(
        value="", on_update=lambda _: None, _impl=SimpleNamespace(uuid="u")
    )
    server.gui.add_html.side_effect = lambda content: SimpleNamespace(content=content)
    return Picture(server)


def report(picture, client, content):
    picture._field.value = content if isinstance(content, str) else json.dumps(content)
    picture._reported(SimpleNamespace(client_id=client))


def test_starts_light_becomes_full_with_a_graphics_card_and_light_while_one_browser_has_none(picture):
    node = picture.scene.add_box("/box")
    picture.scene.configure_environment_map("studio")
    assert picture.light
    assert node.material == LIGHT
    report(picture, 1, GPU)
    assert not picture.light
    assert node.material == FULL
    assert picture._server.scene.configure_environment_map.call_args.args == ("studio",)
    report(picture, 2, NO_GPU)
    assert picture.light
    assert node.material == LIGHT
    assert picture._server.scene.configure_environment_map.call_args.args == (None,)
    assert "no graphics card" in picture._words.content
    assert 'title="SwiftShader &lt;b&gt;"' in picture._words.content
    picture._left(SimpleNamespace(client_id=2))
    report(picture, 1, GPU | {"fps": 59})
    assert not picture.light


def test_a_slow_browser_gets_the_light_picture_and_a_choice_wins(picture):
    report(picture, 1, GPU | {"slow": True, "fps": 8})
    assert picture.light
    picture.choose("full")
    assert not picture.light
    report(picture, 1, NO_GPU)
    assert not picture.light
    picture.choose("light")
    report(picture, 1, GPU)
    assert picture.light


def test_a_slow_browser_gets_as_many_updates_as_it_draws_and_can_become_faster(picture):
    from palpate.viewer.picture import Browser

    assert picture.rate(30.0) == 30.0, "no browser has reported"
    rates = []
    for fps in (4.0, 12.0, 20.0, 24.0, 30.0):
        picture.browsers[1] = Browser(fps=fps)
        rates.append(picture.rate(30.0))
    assert rates == [15.0, 18.0, 30.0, 30.0, 30.0]
    picture.browsers[2] = Browser(fps=10.0)
    assert picture.rate(30.0) == 30.0, "the fastest browser decides"


def test_a_scene_that_stands_still_is_drawn_sharp_until_it_moves(picture):
    from palpate.viewer.picture import STILL

    for k in range(2 * STILL):
        picture.at(0.001 * k)
    assert "'automatic',false)" in picture._bridge.content
    for _ in range(STILL):
        picture.at(1.0)
    assert "'automatic',false)" in picture._bridge.content
    picture.at(1.0)
    assert "'automatic',true)" in picture._bridge.content
    picture.at(1.001)
    assert "'automatic',false)" in picture._bridge.content


def test_new_nodes_have_the_material_of_the_moment(picture):
    assert picture.scene.add_mesh_simple("/a").material == LIGHT
    report(picture, 1, GPU)
    assert picture.scene.add_mesh_simple("/b").material == FULL


@pytest.mark.parametrize(
    "content",
    ["", "{", "[]", "null", "3", json.dumps({"renderer": "x"}), json.dumps(GPU | {"width": "wide"}), "9" * 10**5],
)
def test_bad_reports_change_nothing(picture, content):
    report(picture, 1, content)
    assert picture.browsers == {}
    assert read(content) is None


def test_words_say_quality_reason_and_rate():
    light = in_words(read(json.dumps(NO_GPU)), True)
    assert "light, without shadows" in light
    assert "28 frames/s, 640 x 700 pixels" in light
    assert in_words(None, True) == "waiting for the browser"


def test_page_has_the_script_before_those_of_the_library(tmp_path):
    write_page(tmp_path)
    page = (tmp_path / "index.html").read_text()
    assert 0 < page.index("palpatePicture") < page.index("<script", page.index("<script") + 1)


def test_organ_is_coarser_in_the_light_picture_within_the_error_that_it_says():
    vertices, triangles = organ(30000)
    made = {}
    scene = MagicMock()
    scene.add_mesh_simple.side_effect = lambda name, v, t, **_: made.setdefault(
        name, MagicMock(vertices=v, faces=t, visible=True)
    )
    drawing = OrganDrawing(scene, TouchedObject("liver", vertices, triangles, np.eye(4)), (1, 2, 3))
    node = made["/objects/liver/0"]
    drawing.set_light(True)
    assert len(node.faces) < 1.4 * LIGHT_TRIANGLES
    away = [np.linalg.norm(node.vertices - p, axis=1).min() for p in vertices[::300]]
    assert max(away) < drawing.error() + 0.006, "a vertex of the drawn surface is near"
    assert 0.0 < drawing.error() < 0.004
    drawing.set_light(False)
    assert np.array_equal(node.faces, triangles)
    assert drawing.error() == 0.0


def test_fixture_is_coarser_in_the_light_picture_and_as_fine_again_in_the_full_one():
    """The cone of 15 cm, with a sixth of its triangles, stays within 5 mm of itself at its rim, and 1 mm elsewhere."""
    mark = stage_of(build(Scene.load("guided"))).fixtures[2]
    made = {}
    scene = MagicMock()
    scene.add_mesh_simple.side_effect = lambda name, v, t, **_: made.setdefault(name, MagicMock(vertices=v, faces=t))
    drawing = FixtureDrawing(scene, mark)
    (node,) = made.values()
    assert len(mark.triangles) > 2 * fixtures.LIGHT_TRIANGLES
    drawing.set_light(True)
    assert len(node.faces) < 1.4 * fixtures.LIGHT_TRIANGLES
    drawn = node.vertices[np.unique(node.faces)].astype(float)
    far = _core.Mesh(mark.vertices, mark.triangles).nearest(drawn)[0]
    assert np.abs(far).max() < 5e-3
    assert np.quantile(np.abs(far), 0.9) < 1e-3
    drawing.set_light(False)
    assert np.array_equal(node.faces, mark.triangles)
    assert np.allclose(node.vertices, mark.vertices, atol=1e-6)


@pytest.mark.parametrize("arm", [Arm.mtm("right"), Arm.psm("lnd")])
def test_vertices_of_an_arm_follow_its_links(arm):
    made = []
    scene = MagicMock()
    scene.add_mesh_simple.side_effect = lambda name, v, t, **_: made.append(MagicMock(vertices=v, faces=t)) or made[-1]
    drawing = ArmDrawing(scene, ArmPlace("leader", arm, np.eye(4)))
    assert len(made) <= 6, "a mesh a colour"
    q = arm.home + 0.05 * np.arange(1, arm.n + 1)
    padded = np.zeros(TICK["q"].shape)
    padded[: arm.n] = q
    poses = drawing.show(padded, 0.3)
    every = np.concatenate([node.vertices for node in made])
    for visual in arm.visuals:
        X = poses[visual.link] @ visual.X_link_visual
        if visual.shape == "box":
            corner = X[:3, :3] @ (0.5 * np.array(visual.size)) + X[:3, 3]
        else:
            corner = X[:3, 3] + X[:3, 0] * visual.size[0] + X[:3, 2] * (visual.size[1] / 2 if visual.size[1:] else 0.0)
        limit = 1e-6 if visual.shape != "sphere" else 0.2 * visual.size[0]
        assert np.linalg.norm(every - corner, axis=1).min() < limit
