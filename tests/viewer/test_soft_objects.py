"""The drawing of a soft object: deformed instead of dented, and coloured by displacement."""

from types import SimpleNamespace
from unittest.mock import MagicMock

import numpy as np
import pytest

from palpate.viewer.organs import OrganDrawing
from palpate.viewer.skins import BANDS
from palpate.viewer.soft_objects import SCALES, SoftObjects, bands, legend
from palpate.viewer.stage import TouchedObject
from palpate.viewer.strain import SurfaceStrain
from palpate.world.shapes.organs import organ


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
    drawing, made, vertices, triangles = drawn()
    number = np.arange(len(triangles)) % len(BANDS)
    drawing.deform(vertices, number)
    assert not made["/objects/liver/0"].visible
    for k in range(len(BANDS)):
        assert np.array_equal(made[f"/objects/liver/coloured/{k}"].faces, triangles[number == k])
    drawing.deform(vertices)
    assert made["/objects/liver/0"].visible
    assert not any(made[f"/objects/liver/coloured/{k}"].visible for k in range(len(BANDS)))


def test_vertices_of_a_coloured_surface_move_without_new_nodes():
    drawing, made, vertices, triangles = drawn()
    number = np.zeros(len(triangles), np.int64)
    drawing.deform(vertices, number)
    nodes = dict(made)
    drawing.deform(vertices - [0.0, 0.0, 0.001], number)
    assert made == nodes
    assert np.array_equal(made["/objects/liver/coloured/0"].vertices, (vertices - [0, 0, 0.001]).astype(np.float32))


def test_bands_run_from_the_first_to_the_last():
    assert bands(np.array([0.0, 0.5, 1.0, 2.0])).tolist() == [0, 5, 10, 10]
    marks = legend(SCALES[0], 0.005)
    assert "displacement [mm]" in marks
    assert "<span>5</span>" in marks
    assert "strain [%]" in legend(SCALES[1], 0.2)


@pytest.mark.parametrize("stretch", [0.2, -0.1])
def test_strain_of_a_stretched_surface_is_that_of_the_closed_form(stretch):
    vertices, triangles = organ(2000)
    F = np.diag([1.0 + stretch, 1.0, 1.0])
    found = SurfaceStrain(vertices, triangles).of(vertices @ F.T)
    assert found.max() == pytest.approx(abs((1.0 + stretch) ** 2 - 1.0) / 2.0, rel=0.02)
    turned = vertices @ np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    assert SurfaceStrain(vertices, triangles).of(turned).max() < 1e-9, "a rotation strains nothing"


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
    gui.add_dropdown.return_value.value = "displacement"
    soft = SoftObjects(gui, stage, drawing, source)
    soft.show()
    soft.show()
    assert soft.frames == 1
    moved[5, 2] -= 1e-5
    soft.show()
    assert soft.frames == 1, "10 um are not seen"
    moved[5, 2] -= 9e-3
    soft.show()
    assert soft.frames == 2
    index, shape, number = drawing.deform.call_args.args
    assert index == 1
    assert np.array_equal(shape, moved)
    near = (triangles == 5).any(axis=1)
    assert (number[near] > 0).all(), "a third of 9 mm on a scale of 5 mm"
    assert not number[~near].any()
    assert "<span>5</span>" in soft._legend.content
