"""The tool of a remote site in the viewer: where it was, and what the link says."""

from types import SimpleNamespace
from unittest.mock import MagicMock

import numpy as np
from fake_session import FakeSession, stage
from viser.transforms import SO3

from palpate import _network, scene
from palpate.scene.rig import build
from palpate.viewer.gauges import _remote
from palpate.viewer.organs import OrganDrawing
from palpate.viewer.plane import PlaneDrawing
from palpate.viewer.staging import stage_of
from palpate.viewer.tool import ToolDrawing


def made():
    balls = {}

    def ball(name, *_, **given):
        balls[name] = MagicMock(**{"position": np.zeros(3), "visible": True, **given})
        return balls[name]

    scene = MagicMock()
    scene.add_icosphere.side_effect = ball
    return ToolDrawing(scene, stage()), balls


def test_the_remote_tool_is_drawn_where_its_newest_packet_saw_it():
    drawing, balls = made()
    tick = FakeSession().latest()
    drawing.show(tick, {}, np.zeros(3))
    assert not balls["/remote"].visible
    tick["remote_received"], tick["p_WR"] = 5.0, [0.01, 0.02, 0.03]
    drawing.show(tick, {}, np.zeros(3))
    assert balls["/remote"].visible
    np.testing.assert_allclose(balls["/remote"].position, [0.01, 0.02, 0.03])


def test_the_read_outs_have_delays_link_and_both_forces():
    tick = FakeSession().latest()
    assert _remote(tick, "") == ""
    tick["remote_link"], tick["remote_age"], tick["remote_delay"] = 2.0, 0.105, 0.135
    tick["F_remote_W"], tick["F_T_W"], tick["remote_received"] = [0.0, 0.0, 1.25], [0.0, 0.0, 1.5], 812.0
    words = _remote(tick, "")
    for part in ("stands", "105 ms ago, here in 135 ms", "812", "1.25 / 1.50 N"):
        assert part in words
    tick["remote_link"] = 1.0
    assert "down: everything holds" in _remote(tick, "")


class Nodes:
    """The part of viser that a plane uses."""

    def __init__(self):
        self.nodes = {}

    def _add(self, name, **given):
        self.nodes[name] = SimpleNamespace(**{"visible": True, **given})
        return self.nodes[name]

    def add_mesh_simple(self, name, vertices, faces, **given):
        return self._add(name, vertices=vertices, **given)

    def add_label(self, name, text, **given):
        return self._add(name, text=text, **given)


def plane(normal=(0.0, 0.6, 0.8), sd=1e-4):
    out = _network.ModelEstimate()
    out.shift, out.normal = np.array([0.2, 0.0, 0.0]), np.array(normal)
    out.K, out.sd_K, out.sd_shift = 450.0, 12.0, sd
    return out


def test_the_plane_that_is_felt_is_drawn_below_the_tool_with_its_confidence():
    nodes = Nodes()
    drawing, tool = PlaneDrawing(nodes), np.array([0.1, 0.006, 0.008])  # 10 mm above it
    drawing.show(None, tool)
    assert nodes.nodes == {}
    drawing.show(plane(), tool)
    square, label = nodes.nodes["/plane"], nodes.nodes["/plane_words"]
    np.testing.assert_allclose(square.position, [0.1, 0.0, 0.0], atol=1e-9)
    corners = square.vertices @ SO3(square.wxyz).as_matrix().T + square.position
    np.testing.assert_allclose(corners @ [0.0, 0.6, 0.8], 0.0, atol=1e-7)
    assert label.text == "unknown surface: 450 N/m (sd 12), place sd 0.10 mm"
    sure = square.color
    drawing.show(plane(sd=2e-3), tool)
    assert square.color[0] > sure[0]  # less green
    assert square.color[1] < sure[1]
    drawing.show(plane(), tool + 0.05)  # far from it
    assert not square.visible
    assert not label.visible


def test_objects_of_the_site_alone_are_told_from_those_that_the_hand_feels():
    given = {"objects": [{"name": "seen", "plane": {}}, {"name": "lump", "sphere": {"radius": 0.01}}],
             "remote": {"planes": True, "hidden": ["lump"]}}  # fmt: skip
    objects = stage_of(build(scene.Scene.model_validate(given))).objects
    assert [one.hidden for one in objects] == [False, True]
    drawn = MagicMock()
    for obj in objects:
        OrganDrawing(drawn, obj, (140, 40, 32))
    assert [call.args[1] for call in drawn.add_label.call_args_list] == ["lump: hidden from the hand"]
