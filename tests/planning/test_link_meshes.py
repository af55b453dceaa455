"""Capsules contain the meshes of the links: every vertex, of every shipped arm drawn as meshes, and of odd shapes."""

from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh
from planning_worlds import psm

from palpate import Arm
from palpate.arm import models_folder
from palpate.planning import shapes
from palpate.planning.robot import Robot

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
def test_every_vertex_of_every_link_mesh_lies_within_its_capsules(name, tmp_path) -> None:  # type: ignore[no-untyped-def]
    arm = ARMS[name]()
    drawn = Robot(name, arm, np.eye(4))
    meshed = Robot(name, Arm(drawn_as_meshes(arm.urdf, tmp_path), *arm.frames), np.eye(4))
    assert {body.link for body in meshed.bodies} == {body.link for body in drawn.bodies}
    assert (drawn.geometry, meshed.geometry) == ("capsules", "meshes")
    assert meshed.notes == drawn.notes == []
    for body in meshed.bodies:
        assert body.part is not None
        v, X = body.part.vertices, body.part.X_link_part
        vertices = v @ X[:3, :3].T + X[:3, 3]
        assert outside(drawn, body.link, vertices) < 1e-7  # files have single precision
        assert outside(meshed, body.link, vertices) < 1e-9


def test_a_tube_is_not_as_thick_as_the_sleeve_around_it() -> None:
    """The trocar of the PSM: its tube of 5.8 mm stands out of a sleeve of 11.5 mm."""
    robot = Robot("psm", Arm.psm(), np.eye(4))
    tube = next(part for part in robot.arm.visuals if part.shape == "cylinder" and part.size == (0.0058, 0.11))
    thin = [b.capsule for b in robot.bodies if b.link == tube.link and b.capsule.radius < 1.02 * 0.0058]
    X = robot.kinematics.mount[tube.link][1] @ tube.X_link_visual
    along = X[:3, 3] + X[:3, 2] * np.linspace(-0.05, 0.05, 11)[:, None]
    side = along + 0.007 * X[:3, 0]  # 1.2 mm beside the tube
    assert min(c.distances(along).max() for c in thin) < 0.0
    others = [b.capsule for b in robot.bodies if b.link == tube.link]
    free = np.min([c.distances(side) for c in others], axis=0) > 1e-3
    assert free.sum() >= 6  # the sleeve covers the rest
    two = [
        shapes.Capsule(np.zeros(3), np.array([0, 0, 0.1]), 0.005),
        shapes.Capsule(np.zeros(3), np.array([0, 0, 0.02]), 0.01),
    ]
    assert len(shapes.merged(two, 1e-3)) == 2
    inner = shapes.Capsule(np.zeros(3), np.array([0, 0, 0.01]), 0.005)
    assert len(shapes.merged([two[1], inner], 1e-3)) == 1


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
