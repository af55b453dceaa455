"""Section `tissue` of an object: values, preset, parts, fixed nodes; what cannot be soft is refused with the mend."""

import numpy as np
import pytest

import palpate
from palpate.base.errors import MeshError, PalpateWarning, SceneError
from palpate.scene import Scene
from palpate.scene.gains import felt_stiffness, touched_stiffness
from palpate.scene.operator import OperatorSection
from palpate.scene.rig import build
from palpate.world.tissue import PRESETS, TetMesh, Tissue, indentation, save
from palpate.world.tissue.blocks import block

OBJECT = "objects:\n  - {{name: cube, box: {{size: [0.04, 0.04, 0.04]}}, unit: m, tissue: {{{}}}}}\n"
_PRESS = {"palpate": {"approach": 0.3, "press": 1.0, "force": 0.1}}
FIXED = "fixed: [{at: [0, 0, -0.02], box: [0.1, 0.1, 0.002]}]"


@pytest.fixture
def scene_with(tmp_path):
    """A scene of a cube of tetrahedra around the origin, given as a file, with some keys of `tissue`."""
    pytest.importorskip("meshio", reason="extra tissue")
    nodes, tets = block((4, 4, 4), (0.04, 0.04, 0.04))
    save(TetMesh(nodes - 0.02, tets), tmp_path / "cube.vtk", unit="m")

    def scene(keys):
        return Scene.parse(OBJECT.format(f"volume: cube.vtk, {keys}"), str(tmp_path / "scene.yaml"))

    return scene


def test_left_out_values_are_those_of_the_preset():
    tissue = Scene.parse(OBJECT.format("preset: kidney, young: 9e3")).objects[0].tissue
    kidney = PRESETS["kidney"]
    assert (tissue.material.young, tissue.material.prony) == (9e3, kidney.prony)
    assert Scene.parse(OBJECT.format("")).objects[0].tissue.material.young == PRESETS["liver"].young


def test_a_tissue_survives_a_round_trip():
    scene = Scene.parse(
        OBJECT.format(
            f"prony: [{{g: 0.5, tau: 100 ms}}], {FIXED}, parts: [{{at: [0, 0, 0], radius: 0.01, young: 5e4}}]"
        )
    )
    assert Scene.parse(scene.to_yaml()).model_dump() == scene.model_dump()
    assert scene.objects[0].tissue.material.prony == ((0.5, 0.1),)


def test_parts_and_fixed_nodes_reach_the_body(scene_with):
    rig = build(scene_with(FIXED + ", parts: [{name: lump, at: [0, 0, 0], radius: 0.01, young: 50e3}]"))
    soft = rig.surfaces[0].body
    assert isinstance(soft, Tissue)
    section = rig.scene.objects[0].tissue
    volume = section.tetrahedra(rig.surfaces[0].body, rig.scene.path_to("cube.vtk", ""), "m", print)
    centre = np.linalg.norm(volume.centres, axis=1) <= 0.01
    assert np.array_equal(volume.region == 1, centre)
    assert 0 < centre.sum() < len(centre)
    assert np.array_equal(section.held(volume), volume.nodes[:, 2] < -0.0199)


def test_a_session_presses_the_tissue(scene_with):
    """A tool at the centre of the cube's upper side, pressed by a simulated hand: the body stores energy."""
    scene = scene_with(f"preset: liver, {FIXED}")
    scene = scene.model_copy(update={"operator": OperatorSection.model_validate(_PRESS)}).with_file_of(scene)
    with palpate.Session(scene) as session:
        session.run(2.0)
        tick = session.latest()
    assert float(tick["depth"]) > 1e-3
    assert float(tick["tissue_potential"]) > 1e-7
    assert 0.01 < float(np.linalg.norm(tick["F_T_W"])) < 1.0


def test_springs_share_the_area_of_the_surface(scene_with):
    from palpate.scene import soft

    volume = TetMesh(*block((4, 4, 4), (0.04, 0.04, 0.04)))
    areas = soft._areas(volume)
    assert areas.sum() == pytest.approx(6 * 0.04**2)
    assert np.all((areas > 0) == np.isin(np.arange(len(areas)), volume.surface))


def test_stiffness_bounds_the_slope_of_the_force():
    scene = Scene.parse(OBJECT.format("young: 5000, poisson: 0.45, prony: []"))
    R = scene.contact.radius
    d = np.linspace(0, R, 100)
    slope = np.diff(indentation.hertz(R, d, 5000, 0.45)) / np.diff(d)
    assert slope.max() == pytest.approx(touched_stiffness(scene, 0), rel=0.01)
    assert felt_stiffness(scene, 0) == pytest.approx(touched_stiffness(scene, 0) * scene.mapping.scale)
    tissue = scene.objects[0].tissue
    assert indentation.hertz(R, tissue.depth(0.02, R), 5000, 0.45) == pytest.approx(0.02)


def test_tissue_that_nothing_holds_is_told(scene_with):
    with pytest.warns(PalpateWarning, match="nothing holds 'cube': it floats away"):
        build(scene_with("young: 5e3"))


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ("poisson: 0.5", "poisson: must lie from 0 to 0.495: an incompressible body"),
        ("poisson: -0.1", "poisson: must lie from 0"),
        ("young: -5e3", "young"),
        ("density: 0", "density"),
        ("preset: brain", "there is no tissue 'brain'"),
        ("prony: [{g: 0.5, tau: 0}]", "tau"),
        ("prony: [" + ", ".join(["{g: 1, tau: 1}"] * 5) + "]", "prony"),
        ("fixed: [{at: [0, 0, 0]}]", "a ball or a box is needed"),
        ("parts: [{at: [0, 0, 0], radius: 0.01}]", "young"),
        ("resolution: 0", "resolution"),
    ],
)
def test_wrong_values_are_refused(keys, words):
    with pytest.raises(SceneError, match=words):
        Scene.parse(OBJECT.format(keys))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{shape: organ, stiffness: 300, tissue: {}}", "tissue and stiffness are given"),
        ("{plane: {}, tissue: {}}", "a plane has no closed surface"),
        ("{sdf: a.npz, tissue: {}}", "a sdf has no closed surface"),
        ("{shape: organ, presence: real, tissue: {}}", "tissue is virtual"),
    ],
)
def test_objects_that_cannot_be_soft_are_refused(text, words):
    with pytest.raises(SceneError, match=words):
        Scene.parse(f"objects: [{text}]")


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ("parts: [{name: lump, at: [1, 0, 0], radius: 0.01, young: 5e4}]", "no tetrahedron lies in part 'lump'"),
        ("fixed: [{at: [1, 0, 0], radius: 0.01}]", r"tissue.fixed\[0\] contains no node"),
    ],
)
def test_spots_outside_are_refused(scene_with, keys, words):
    with pytest.raises(MeshError, match=words) as error:
        build(scene_with(keys))
    assert "scene.yaml:2" in error.value.where


def test_a_missing_volume_is_named(tmp_path):
    scene = Scene.parse(OBJECT.format("volume: absent.vtk"), str(tmp_path / "scene.yaml"))
    with pytest.raises(MeshError, match="no such file"):
        build(scene)
