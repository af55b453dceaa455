"""Arms of other people's URDFs: their collision geometry against Pinocchio and Coal, which read the same file."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh
from planning_worlds import at
from urdf_judge import Judge

from palpate import Arm
from palpate.base.errors import PlanningError
from palpate.planning import moveit
from palpate.planning.checker import Checker
from palpate.planning.problem import Problem
from palpate.planning.robot import Robot
from palpate.planning.timing import Limits
from palpate.planning.world import World, obstacle
from palpate.world import surfaces

LINK = """<link name="{name}"><inertial><mass value="1"/><inertia ixx="1e-2" iyy="1e-2" izz="1e-2" ixy="0" ixz="0"
iyz="0"/></inertial>{body}</link>"""
JOINT = """<joint name="j{k}" type="revolute"><parent link="{parent}"/><child link="{child}"/><origin xyz="{x} 0 0.05"
rpy="0.2 {k} 0.1"/><axis xyz="0 {y} {z}"/><limit lower="-2" upper="2" velocity="1" effort="50"/></joint>"""
FORMS = {
    "box": '<box size="0.05 0.07 0.21"/>',
    "cylinder": '<cylinder radius="0.033" length="0.19"/>',
    "sphere": '<sphere radius="0.061"/>',
    "mesh": '<mesh filename="meshes/wedge.stl"/>',
    "scaled": '<mesh filename="meshes/wedge_mm.stl" scale="0.001 0.001 0.002"/>',
    "mirrored": '<mesh filename="meshes/wedge.stl" scale="1 -1 1"/>',
    "file": '<mesh filename="file://{folder}/meshes/wedge.stl"/>',
    "package": '<mesh filename="package://bars/meshes/wedge.stl"/>',
}
BALL = 0.02


def body(form: str, kind: str = "collision", xyz: str = "0.08 0.01 -0.02", rpy: str = "0.3 1.2 -0.4") -> str:
    return f'<{kind}><origin xyz="{xyz}" rpy="{rpy}"/><geometry>{form}</geometry></{kind}>'


def wedge(scale: float = 1.0) -> trimesh.Trimesh:
    """A body without any symmetry."""
    return trimesh.convex.convex_hull(scale * np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.09, 0], [0.02, 0.01, 0.06]]))


def written(folder: Path, bodies: list[str], name: str = "arm.urdf") -> Path:
    """An arm of some links, one per text of bodies, with the model file."""
    (folder / "meshes").mkdir(parents=True, exist_ok=True)
    wedge().export(folder / "meshes/wedge.stl")
    wedge(1e3).export(folder / "meshes/wedge_mm.stl")
    names = ["base", *(f"link{k}" for k in range(len(bodies)))]
    links = '<link name="base"/>' + "".join(
        LINK.format(name=one, body=text.replace("{folder}", str(folder)))
        for one, text in zip(names[1:], bodies, strict=True)
    )
    joints = "".join(
        JOINT.format(k=k, parent=names[k], child=names[k + 1], x=0.25 * (k > 0), y=k % 2, z=1 - k % 2)
        for k in range(len(bodies))
    )
    (folder / name).write_text(f'<robot name="foreign">{links}{joints}</robot>')
    model = folder / f"{name}.yaml"
    model.write_text(f"urdf: {name}\n")
    return model


def compared(folder: Path, arm: Arm, judge: Judge, count: int = 25) -> float:
    """Largest difference of the distance from a ball at random places and joints [m]."""
    rng, robot, worst = np.random.default_rng(0), Robot("F", arm, np.eye(4)), 0.0
    for _ in range(count):
        q, p = rng.uniform(arm.q_min, arm.q_max), rng.uniform(-0.6, 0.6, 3)
        exact = judge.to_sphere(q, p, BALL)
        if exact > 1e-3:
            world = World((obstacle("ball", surfaces.Sphere(BALL), at(*p)),))
            worst = max(worst, abs(Checker(robot, world).nearest(q)[0].distance - exact))
    return worst


@pytest.mark.parametrize("form", FORMS)
def test_collision_geometry_is_used_as_the_urdf_gives_it(form, tmp_path) -> None:
    folder = tmp_path / "bars"
    texts = [body(FORMS[form]), body(FORMS[form], xyz="0 0.05 0.1", rpy="0 0 0") + body(FORMS["sphere"])]
    arm = Arm.load(written(folder, texts))
    assert compared(folder, arm, Judge(folder / "arm.urdf", [str(folder), str(tmp_path)])) < 2e-6


def test_collision_comes_before_visual(tmp_path) -> None:
    """A thin <visual> beside a thick <collision>, and a link that has only a <visual>."""
    texts = [body(FORMS["cylinder"]) + body('<cylinder radius="0.005" length="0.19"/>', "visual"),
             body(FORMS["box"], "visual")]  # fmt: skip
    robot = Robot("F", Arm.load(written(tmp_path, texts)), np.eye(4))
    assert {b.link: b.kind for b in robot.bodies} == {"link0": "primitives", "link1": "capsules"}
    assert next(b for b in robot.bodies if b.link == "link0").capsule.radius > 0.033 - 1e-9


def test_links_without_a_body_are_told(tmp_path) -> None:
    robot = Robot("F", Arm.load(written(tmp_path, [body(FORMS["box"]), "", body(FORMS["mesh"])])), np.eye(4))
    assert {b.link for b in robot.bodies} == {"link0", "link2"}  # no stick is invented
    (note,) = robot.notes
    assert "links base, link1 have no body" in note
    sticks = Robot("F", Arm.load(written(tmp_path, ["", ""])), np.eye(4))
    assert "describes no bodies" in sticks.notes[0]
    assert Robot("P", Arm.psm(), np.eye(4)).notes == []


def collada(path: Path, mesh: trimesh.Trimesh, unit: float) -> None:
    """The mesh, in metres, as a COLLADA file of another unit [m]."""
    pytest.importorskip("collada")
    data = mesh.copy().apply_scale(1.0 / unit).export(file_type="dae").decode()
    start = data.index("<unit") if "<unit" in data else -1
    if start >= 0:
        data = data[:start] + data[data.index("/>", start) + 2 :]
    path.write_text(data.replace("<up_axis>", f'<unit name="u" meter="{unit}"/><up_axis>'))


@pytest.mark.parametrize("unit", [1.0, 0.1, 0.0254, 1e-3])
def test_the_unit_of_collada_is_read(unit, tmp_path) -> None:
    """Oracle: the same body as an STL in metres."""
    texts = [body('<mesh filename="meshes/part.stl"/>'), body('<mesh filename="meshes/part.stl" scale="1 2 1"/>')]
    model = written(tmp_path, texts)
    wedge().export(tmp_path / "meshes/part.stl")
    collada(tmp_path / "meshes/part.dae", wedge(), unit)
    named = (tmp_path / "arm.urdf").read_text().replace("part.stl", "part.dae")
    judge = Judge(tmp_path / "arm.urdf")
    (tmp_path / "arm.urdf").write_text(named)
    assert compared(tmp_path, Arm.load(model), judge) < 2e-6


@pytest.mark.parametrize("name", ["meshes/wedge.stl", "../bars/meshes/wedge.stl", "package://bars/meshes/wedge.stl",
                                  "package://renamed/meshes/wedge.stl", "model://bars/meshes/wedge.stl",
                                  "meshes/with%20space.stl"])  # fmt: skip
@pytest.mark.parametrize("under", ["", "urdf"])
def test_meshes_are_found_from_any_directory(name, under, tmp_path, monkeypatch) -> None:
    folder = tmp_path / "bars"
    model = written(folder / under, [body(f'<mesh filename="{name}"/>')])
    written(folder, [""], "other.urdf")  # the package's meshes
    (folder / under / "meshes/with%20space.stl").write_bytes((folder / "meshes/wedge.stl").read_bytes())
    elsewhere = tmp_path / "elsewhere/meshes"
    elsewhere.mkdir(parents=True)
    trimesh.creation.box((1.0, 1.0, 1.0)).export(elsewhere / "wedge.stl")  # not this one
    monkeypatch.chdir(elsewhere.parent)
    if name.startswith("../bars") and under:
        return
    (found,) = Robot("F", Arm.load(model), np.eye(4)).bodies
    assert found.mesh is not None
    assert len(found.mesh[0]) == 4


def test_packages_are_found_where_ros_looks(tmp_path, monkeypatch) -> None:
    model = written(tmp_path / "a", [body('<mesh filename="package://hand/wedge.stl"/>')])
    for variable, folder in (("ROS_PACKAGE_PATH", "src/hand"), ("AMENT_PREFIX_PATH", "install/share/hand")):
        with pytest.raises(PlanningError, match=r"package://hand/wedge.stl of link link0 is not found\n.*looked for"):
            _ = Robot("F", Arm.load(model), np.eye(4)).bodies
        place = tmp_path / "ros" / folder
        place.mkdir(parents=True)
        wedge().export(place / "wedge.stl")
        monkeypatch.setenv(variable, str(tmp_path / "ros" / folder.split("/")[0]))
        assert len(Robot("F", Arm.load(model), np.eye(4)).bodies) == 1
        monkeypatch.delenv(variable)


@pytest.mark.parametrize(("form", "words"), [
    ("<torus radius='1'/>", r"<torus>, which is not understood"),
    ('<box size="0.1 0.2"/>', r"is not 3 numbers"),
    ('<cylinder radius="0.1"/>', r"<cylinder length=''> of link link0 is not 1 number"),
    ('<sphere radius="0"/>', r"has the size 0 m"),
    ('<mesh filename="meshes/wedge.stl" scale="0 1 1"/>', r"has the scale 0 1 1"),
    ('<mesh filename="meshes/gone.stl"/>', r"meshes/gone.stl of link link0 is not found"),
])  # fmt: skip
def test_what_is_not_understood_is_refused_by_name(form, words, tmp_path) -> None:
    with pytest.raises(PlanningError, match=words):
        _ = Robot("F", Arm.load(written(tmp_path, [body(form)])), np.eye(4)).bodies


def problem_of(arm: Arm, world: World | None = None) -> Problem:
    states = {"home": arm.home, "current": arm.home}
    return Problem(Robot("F", arm, at(0.1, 0.2, 0.3)), world or World(), states, Limits.of(arm, 0.5), 0.002)


def test_export_for_moveit_keeps_the_collision_geometry(tmp_path) -> None:
    """Oracle: Pinocchio reads the exported file and the original one."""
    forms = [body(FORMS[form]) + body(FORMS["box"], xyz="0 0.1 0") for form in ("mesh", "scaled", "package", "sphere")]
    arm = Arm.load(written(tmp_path / "bars", [*forms, body(FORMS["mirrored"], "visual")]))
    out = tmp_path / "out"
    out.mkdir()
    moveit.export(problem_of(arm), out)
    (file,) = out.glob("*.urdf")
    theirs, ours = Judge(file, [str(out)]), Judge(tmp_path / "bars/arm.urdf", [str(tmp_path / "bars"), str(tmp_path)])
    assert sorted(theirs.links()) == sorted([*ours.links(), "link4"])  # which has only a visual mesh
    rng = np.random.default_rng(1)
    for q in rng.uniform(arm.q_min, arm.q_max, (20, arm.n)):
        p = rng.uniform(-0.5, 0.5, 3)
        mine = Checker(problem_of(arm).robot, World((obstacle("b", surfaces.Sphere(BALL), at(*p)),))).nearest(q)[0]
        if mine.distance > 1e-3:
            assert theirs.to_sphere(q, p, BALL) == pytest.approx(mine.distance, abs=2e-6)
    meshes = [
        m.get("filename", "") for m in ElementTree.parse(file).iter("mesh") if m.get("filename", "")[:5] == "file:"
    ]
    assert all(Path(name.removeprefix("file://")).is_file() for name in meshes)
    assert len(meshes) == 4


def test_a_hollow_link_around_a_post_is_free(tmp_path) -> None:
    """A ring: the axis of its capsule lies in the post, its material does not."""
    ring = trimesh.creation.annulus(0.06, 0.07, 0.02)
    model = written(tmp_path, [body('<mesh filename="meshes/ring.stl"/>', xyz="0 0 0", rpy="0 0 0")])
    ring.export(tmp_path / "meshes/ring.stl")
    arm = Arm.load(model)
    robot = Robot("F", arm, np.eye(4))
    X = robot.arm.link_poses(np.zeros(1))["link0"]
    post = trimesh.creation.icosphere(3, 0.04)
    from palpate import Mesh

    world = World((obstacle("post", Mesh(np.asarray(post.vertices), np.asarray(post.faces)), X),))
    assert Checker(robot, world).refusal(np.zeros(1), 0.002) is None
    big = trimesh.creation.icosphere(3, 0.2)
    world = World((obstacle("post", Mesh(np.asarray(big.vertices), np.asarray(big.faces)), X),))
    refused = Checker(robot, world).refusal(np.zeros(1), 0.002)
    assert refused is not None
    assert refused.distance < -0.1


def test_a_urdf_that_has_a_link_world_is_exported_once_or_refused(tmp_path) -> None:
    model = written(tmp_path, [body(FORMS["box"])])
    (tmp_path / "arm.urdf").write_text((tmp_path / "arm.urdf").read_text().replace('"base"', '"world"'))
    made = problem_of(Arm.load(model))
    with pytest.raises(PlanningError, match="has a link 'world' of its own"):
        moveit.urdf(made)
    still = Problem(Robot("F", made.robot.arm, np.eye(4)), World(), made.states, made.limits, 0.002)
    (tmp_path / "out.urdf").write_text(moveit.urdf(still))
    assert Judge(tmp_path / "out.urdf").links() == ["link0"]
