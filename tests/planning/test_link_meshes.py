"""Capsules contain the meshes of the links: every vertex, of every shipped arm drawn as meshes, and of odd shapes."""

from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh
from planning_worlds import psm

from palpate import Arm
from palpate.arm import models_folder
from palpate.errors import PlanningError
from palpate.planning import robot as robots
from palpate.planning import shapes
from palpate.planning.robot import Robot, link_meshes

ARMS = {
    "psm": Arm.psm,
    "mtm": lambda: Arm.mtm("right"),
    "ecm": lambda: Arm.load(models_folder() / "ecm.yaml"),
    "six_axis": lambda: Arm.load(models_folder() / "six_axis.yaml"),
}


def as_mesh(shape: ElementTree.Element):
    if shape.tag == "box":
        return trimesh.creation.box([float(x) for x in shape.get("size").split()])
    if shape.tag == "sphere":
        return trimesh.creation.icosphere(2, float(shape.get("radius")))
    return trimesh.creation.cylinder(float(shape.get("radius")), float(shape.get("length")), sections=48)


def drawn_as_meshes(urdf: str, folder) -> str:
    """The URDF with a mesh file, in millimetres, for each visual primitive."""
    root = ElementTree.fromstring(urdf)
    for k, geometry in enumerate(root.findall("link/visual/geometry")):
        mesh = as_mesh(geometry[0])
        mesh.apply_scale(1e3)
        mesh.export(folder / f"{k}.stl")
        geometry.remove(geometry[0])
        ElementTree.SubElement(geometry, "mesh", filename=str(folder / f"{k}.stl"), scale="0.001 0.001 0.001")
    return ElementTree.tostring(root, encoding="unicode")


def outside(robot: Robot, link: str, vertices: np.ndarray) -> float:
    """How far a vertex of a link is outside of all capsules of the link [m]."""
    X = robot.kinematics.mount[link][1]
    points = vertices @ X[:3, :3].T + X[:3, 3]
    return float(np.min([b.capsule.distances(points) for b in robot.bodies if b.link == link], axis=0).max())


@pytest.mark.parametrize("name", ARMS)
def test_every_vertex_of_every_link_mesh_lies_within_its_capsules(name, tmp_path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    arm = ARMS[name]()
    drawn = Robot(name, arm, np.eye(4))
    meshes = link_meshes(SimpleNamespace(urdf=drawn_as_meshes(arm.urdf, tmp_path)))
    assert set(meshes) == {body.link for body in drawn.bodies}
    monkeypatch.setattr(robots, "link_meshes", lambda _: meshes)
    meshed = Robot(name, arm, np.eye(4))
    assert (drawn.geometry, meshed.geometry) == ("capsules", "meshes")
    for link, (vertices, _) in meshes.items():
        assert outside(drawn, link, vertices) < 1e-7  # files have single precision
        assert outside(meshed, link, vertices) < 1e-9


def test_a_capsule_that_is_too_small_would_be_noticed() -> None:
    robot = psm()
    body = max(robot.bodies, key=lambda b: b.capsule.radius)
    v = shapes.outline("sphere", (body.capsule.radius,), np.eye(4)) / 3**0.5 + body.capsule.b
    assert shapes.Capsule(body.capsule.a, body.capsule.b, 0.999 * body.capsule.radius).distances(v).max() > 1e-6


@pytest.mark.parametrize("rank", [0, 1, 2, 3])
def test_capsules_contain_odd_shapes(rank: int) -> None:
    """A point, a line, a sheet and a cloud, from a hundredth of a millimetre to half a metre."""
    rng = np.random.default_rng(rank)
    for size in (1e-5, 1e-3, 0.05, 0.5):
        for _ in range(20):
            points = rng.normal(size=(30, rank)) @ rng.normal(size=(rank, 3)) * size + rng.normal(size=3)
            assert shapes.around(points).distances(points).max() < 1e-9


URDF = """<robot name="m"><link name="base"/><link name="finger">{}</link></robot>"""
BOX = '<{0}><origin xyz="0 0 0.1"/><geometry><box size="0.02 0.02 0.02"/></geometry></{0}>'
MESH = '<{0}><geometry><mesh filename="{1}"/></geometry></{0}>'


def test_primitives_beside_a_mesh_belong_to_it(tmp_path) -> None:  # type: ignore[no-untyped-def]
    trimesh.creation.box((0.01, 0.01, 0.01)).export(tmp_path / "part.stl")
    for kind in ("visual", "collision"):
        text = URDF.format(MESH.format(kind, tmp_path / "part.stl") + BOX.format(kind))
        vertices = link_meshes(SimpleNamespace(urdf=text))["finger"][0]
        assert vertices[:, 2].max() == pytest.approx(0.11)
        assert vertices[:, 2].min() == pytest.approx(-0.005)


def test_a_mesh_file_that_is_missing_is_refused_by_name() -> None:
    text = URDF.format(MESH.format("visual", "package://robot/gone.stl") + BOX.format("visual"))
    with pytest.raises(PlanningError, match=r"package://robot/gone.stl of link finger is not found"):
        link_meshes(SimpleNamespace(urdf=text))
