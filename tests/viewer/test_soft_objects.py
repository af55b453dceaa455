"""The drawing of a soft object: deformed instead of dented, and coloured by displacement."""

from types import SimpleNamespace
from unittest.mock import MagicMock

import numpy as np

from palpate.shapes.organ import organ
from palpate.viewer.organs import OrganDrawing
from palpate.viewer.soft_objects import COLORS, SoftObjects, colors
from palpate.viewer.stage import TouchedObject


def drawn():
    """The drawing of a soft organ, the nodes that it makes, its vertices and triangles."""
    vertices, triangles = organ(2000)
    scene, made = MagicMock(), {}
    scene.add_mesh_simple.side_effect = lambda name, v, t, **_: made.setdefault(
        name, MagicMock(vertices=v, faces=t, visible=True)
    )
    scene.add_glb.side_effect = lambda name, data: made.setdefault(name, MagicMock(glb_data=data, visible=True))
    obj = TouchedObject("liver", vertices, triangles, np.eye(4), soft=True)
    return OrganDrawing(scene, obj, (1, 2, 3)), made, vertices, triangles


def test_deformed_surface_replaces_the_dent():
    drawing, made, vertices, triangles = drawn()
    press = [(vertices[100], 0.002, vertices[100], None)]
    drawing.press(press)
    assert made["/objects/liver/0_pressed"].visible
    lower = vertices - [0.0, 0.0, 0.003]
    drawing.deform(lower)
    drawing.press(press)
    base = made["/objects/liver/0"]
    assert np.array_equal(base.vertices, lower.astype(np.float32))
    assert np.array_equal(base.faces, triangles)
    assert not made["/objects/liver/0_pressed"].visible


def test_colours_replace_the_plain_surface_and_go_again():
    drawing, made, vertices, _ = drawn()
    drawing.deform(vertices, np.full(vertices.shape, 200.0))
    assert not made["/objects/liver/0"].visible
    assert made["/objects/liver/coloured"].glb_data.startswith(b"glTF")
    drawing.deform(vertices)
    assert made["/objects/liver/0"].visible
    assert not made["/objects/liver/coloured"].visible


def test_colours_run_from_the_first_to_the_last():
    assert np.array_equal(colors(np.array([0.0, 1.0])), COLORS[[0, -1]])
    assert np.array_equal(colors(np.array([0.125])), COLORS[:2].mean(axis=0, keepdims=True))


def test_still_surfaces_are_not_sent_and_the_scale_grows_with_the_displacement():
    vertices, triangles = organ(2000)
    moved = vertices.copy()
    source, drawing, gui = SimpleNamespace(soft_vertices=lambda _: moved.copy()), MagicMock(), MagicMock()
    stage = SimpleNamespace(
        objects=[
            TouchedObject("table", vertices, triangles, np.eye(4)),
            TouchedObject("liver", vertices, triangles, np.eye(4), soft=True),
        ]
    )
    gui.add_checkbox.return_value.value = True
    soft = SoftObjects(gui, stage, drawing, source)
    soft.show()
    soft.show()
    assert soft.frames == 1
    moved[5, 2] -= 1e-5
    soft.show()
    assert soft.frames == 1, "10 um are not seen"
    moved[5, 2] -= 3e-3
    soft.show()
    assert soft.frames == 2
    index, shape, shades = drawing.deform.call_args.args
    assert index == 1
    assert np.array_equal(shape, moved)
    size = np.linalg.norm(moved[5] - vertices[5])
    assert np.allclose(shades[5], colors(np.array([size / 0.005]))[0])
    assert np.array_equal(shades[6], COLORS[0])
