"""Fixtures in Python and YAML: every geometry and key round, one line each, words for what is wrong, why, a drawing."""

import json

import matplotlib as mpl
import numpy as np
import pytest
import trimesh

import palpate
from palpate import _core, guidance
from palpate.errors import GuidanceError, SceneError
from palpate.guidance import Fixture, Geometry, Here, Mesh, OfObject, Sphere, from_yaml, to_yaml
from palpate.guidance.one_line import KEYS
from palpate.guidance.plot import query
from palpate.guidance.sections import LawName, RoleName
from palpate.scene import Scene
from palpate.scene.rig import build
from palpate.scene.schema import schema_text

mpl.use("Agg")

SHAPES = {
    "point": {"at": [0.01, 0, 0]},
    "line": {"start": [0, 0, 0], "end": ["5 mm", 0, 0]},
    "plane": {"at": [0, 0, 0.01], "normal": [0, 1, 1]},
    "path": {"waypoints": [[0, 0, 0], [0.01, 0.01, 0], [0.02, 0, 0]]},
    "tube": {"waypoints": [[0, 0, 0], [0.01, 0.01, 0], [0.02, 0, 0]], "radius": "3 mm"},
    "cone": {"entry": [0, 0, 0.1], "target": [0, 0, 0]},
    "sphere": {"radius": 0.02, "at": [0, 0, 0.01]},
    "box": {"size": [0.02, 0.03, 0.04]},
    "cylinder": {"radius": 0.01, "length": 0.05},
    "mesh": {"file": "ball.stl"},
    "cloud": {"file": "cloud.csv", "radius": "2 mm"},
    "grid": {"file": "ball.stl", "spacing": "2 mm"},
    "object": {"name": "liver"},
    "offset": {"of": {"sphere": {"radius": 0.02}}, "margin": "-2 mm"},
    "union": {"of": [{"sphere": {"radius": 0.02}}, {"box": {"size": [0.05, 0.01, 0.01]}}], "blend": "1 mm"},
    "intersection": {"of": [{"sphere": {"radius": 0.02}}, {"plane": {}}]},
    "difference": {"of": [{"sphere": {"radius": 0.02}}, {"plane": {}}]},
}


@pytest.fixture(scope="module")
def here(tmp_path_factory):
    folder = tmp_path_factory.mktemp("files")
    ball = trimesh.creation.icosphere(3, 20.0)
    ball.export(folder / "ball.stl")
    ball.update_faces(np.arange(len(ball.faces)) > 5)
    ball.export(folder / "open.stl")
    np.savetxt(folder / "cloud.csv", 1e3 * np.random.default_rng(0).normal(size=(50, 3)) * 0.02, delimiter=",")
    np.savetxt(folder / "suture.csv", [[0, 0, 0], [10, 5, 0], [20, 0, 5]], delimiter=";")
    from palpate import surfaces

    frames = {"world": _core.MotionFrame(), "liver": _core.MotionFrame(np.eye(4), _core.Motion(v=np.ones(3)))}
    places = {"entry": [0, 0, 0.1], "target": [0, 0, 0.02]}
    return Here(lambda name: folder / name, frames, places, {"liver": surfaces.Sphere(0.03)})


def at(fixture, points, here, t=0.0):
    return query(fixture.make_geometry(here), points, t)


def test_every_geometry_has_a_specimen_here_and_every_name_is_the_cores():
    assert set(SHAPES) == set(Geometry.model_fields)
    assert set(RoleName.__args__) == set(_core.guidance_roles())
    assert set(LawName.__args__) == set(_core.guidance_laws())


@pytest.mark.parametrize("key", SHAPES)
def test_every_geometry_goes_round_and_answers_the_same(key, here):
    fixture = Fixture(geometry={key: SHAPES[key]}, role="guide", name="it")
    again = Fixture.from_yaml(fixture.to_yaml())
    assert again == fixture
    assert Fixture.model_validate(fixture.model_dump(mode="json")) == fixture
    where = np.random.default_rng(1).uniform(-0.05, 0.05, (100, 3))
    np.testing.assert_array_equal(at(again, where, here)["distance"], at(fixture, where, here)["distance"])
    assert fixture.make(here).role == "guide"


def test_every_other_key_goes_round_and_reaches_the_core(here):
    fixture = Fixture(
        Sphere(radius=0.02),
        name="ball",
        role={"name": "keep-in", "margin": "1 mm"},
        law={"name": "potential", "stiffness": 700.0, "range": "4 mm", "force": 2.0},
        frame={"of": "liver", "pose": {"xyz": [0, 0, 0.1]}},
        hard=True,
        authority=0.5,
        priority=3,
        engage=0.05,
        release=0.06,
        rise=0.3,
        ramps=[{"by": "distance", "start": 0.02, "end": 0.0}],
        enabled=False,
    )
    assert Fixture.from_yaml(fixture.to_yaml()) == fixture
    assert "damping" not in fixture.to_yaml(), "what is as always is not written"
    core = fixture.make(here)
    told = (core.policy.hard, core.policy.authority, core.policy.priority, core.policy.engage, core.policy.release)
    assert told == (True, 0.5, 3, 0.05, 0.06)
    assert (core.policy.rise, core.stiffness, core.on, core.law) == (0.3, 700.0, False, "potential")
    assert [(r.by, r.start, r.end) for r in core.policy.ramps] == [("distance", 0.02, 0.0)]
    gap = core.ask(np.eye(4) + _shift(0, 0, 0.1))["gap"]
    assert gap == pytest.approx(0.02 - 0.001)


def _shift(*p):
    X = np.zeros((4, 4))
    X[:3, 3] = p
    return X


def test_a_fixture_moves_with_the_object_it_is_attached_to(here):
    fixture = Fixture(OfObject(name="liver"), role="forbid", frame="liver")
    q = at(fixture, [[1, 1, 1.1]], here, t=1.0)
    np.testing.assert_allclose(q["distance"], 0.07)
    np.testing.assert_allclose(q["velocity"], [[1, 1, 1]])


def test_the_defaults_are_the_cores():
    fixture = Fixture(Sphere(radius=0.02), role="guide")
    o, r, p = _core.GuidanceLawOptions(), _core.GuidanceRoleOptions(), _core.Policy()
    assert (fixture.law.stiffness, fixture.law.damping, fixture.law.range) == (o.K, o.B, o.range)
    assert (fixture.role.margin, fixture.authority, fixture.hard) == (r.margin, p.authority, p.hard)
    cone = guidance.Cone(entry=(0, 0, 1), target=(0, 0, 0))
    assert np.radians(cone.half_angle_deg) == pytest.approx(_core.CONE_HALF_ANGLE)


def test_a_margin_around_a_mesh_in_one_line(here):
    """3 mm around a ball of 20 mm: gap of a tool 24 mm and 22 mm from its middle."""
    fixture = Fixture("margin: 3 mm around: ball.stl")
    assert (fixture.role.name, fixture.role.margin, fixture.hard, fixture.name) == ("forbid", 0.003, True, "ball")
    core = fixture.make(here)
    assert core.ask(np.eye(4) + _shift(0.024, 0, 0))["gap"] == pytest.approx(0.001, abs=1e-4)
    assert core.ask(np.eye(4) + _shift(0.022, 0, 0))["gap"] == pytest.approx(-0.001, abs=1e-4)
    same = from_yaml(
        "- margin: 3 mm around: ball.stl\n- margin: 3 mm around ball.stl\n- {margin: 3 mm, around: ball.stl}"
    )
    assert {f.to_yaml() for f in same} == {fixture.to_yaml()}
    soft = from_yaml("[{margin: 0.003, around: ball.stl, hard: false, authority: 0.3, unit: m}]")[0]
    assert (soft.hard, soft.authority, soft.geometry.mesh.unit) == (False, 0.3, "m")


def test_a_path_a_cone_and_a_trocar_in_one_line(here):
    follow = Fixture("follow: suture.csv")
    assert follow.role.name == "guide"
    assert at(follow, [[0.01, 0.005, 0.003]], here)["distance"][0] < 0.004
    stay = Fixture("stay-in: cone(entry, target)").make(here)
    assert stay.role == "keep-in"
    assert stay.ask(np.eye(4) + _shift(0, 0, 0.07))["gap"] == pytest.approx(0.05 * np.sin(_core.CONE_HALF_ANGLE))
    wide = Fixture("stay-in: cone([0, 0, 10 cm], target, 30 deg)").make(here)
    assert wide.ask(np.eye(4) + _shift(0, 0, 0.07))["gap"] == pytest.approx(0.025)
    rcm = Fixture("keep-rcm")
    assert (rcm.role.name, rcm.geometry.point.at) == ("rcm", "rcm")
    assert Fixture("keep-rcm: entry").geometry.point.at == "entry"
    assert Fixture("stay-in: tube(suture.csv, 2 mm)").make(here).ask(np.eye(4))["gap"] == pytest.approx(0.002)
    around = Fixture("margin: 1 mm around: liver")
    assert (around.geometry.object.name, around.frame.of) == ("liver", "liver")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("margin: 3 mm", "around what"),
        ("margin: 3 furlongs around: ball.stl", "'3 furlongs' is no length | a number of metres"),
        ("keep-away: ball.stl", "is no fixture"),
        ("follow: suture.docx", "is no kind of file that is known"),
        ("stay-in: pyramid(a, b)", "there is no shape 'pyramid' to be called"),
        ("stay-in: cone(a, b, c, d)", "has 4 arguments"),
    ],
)
def test_a_line_that_is_none_says_what_is_possible(text, told):
    with pytest.raises(GuidanceError, match=told.split(" | ")[0].replace("(", r"\(")):
        from_yaml(f"- {text!r}")


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("follow: sutur.csv", r"(?s)file not found.*did you mean .*suture.csv"),
        ("margin: 1 mm around: missing.stl", "mesh file not found"),
        ("margin: 1 mm around: open.stl", r"(?s)open.stl' is open, a forbidden region needs an inside.*--repair"),
        ("margin: 1 mm around: livre", r"(?s)there is no object 'livre'.*did you mean 'liver'"),
        ("stay-in: cone(entrance, target)", "there is no place 'entrance'"),
        ("stay-in: cone(entry, entry)", "a cone needs a finite apex, and a mouth apart from it"),
        ("keep-rcm", "there is no place 'rcm'"),
    ],
)
def test_what_is_missing_is_told_with_the_mend(line, told, here):
    with pytest.raises(Exception, match=told):
        Fixture(line).make(here)


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        ("", "no place in it"),
        ("x_mm,y_mm,z_mm\n1,2\n", r"2 numbers in a row\n  mend: x y z, or"),
        ("1,2,3\nfour,5,6\n", "'four,5,6' is no row of numbers"),
        ("x_ft,y_ft,z_ft\n1,2,3", "unknown unit 'ft' in 'x_ft'"),
        ("1,2,3,1,1,0,0\n2,2,3,1,0,0,0", "quaternion of length 1.41"),
        ("0,0,0\n20000,0,0", r"20 m long\n  why: waypoints are metres here\n  mend: unit: mm"),
        ("0,0,0\n10,10,0\n10,0,0\n0,10,0", "the path crosses itself"),
    ],
)
def test_a_bad_path_file_is_told_with_its_line(rows, told, tmp_path):
    (tmp_path / "p.csv").write_text(rows)
    with pytest.raises(GuidanceError, match=told):
        Fixture("follow: p.csv").make(Here(lambda name: tmp_path / name))


SCENE = """
objects: [{sphere: {radius: 0.03}, name: liver, motion: {velocity: [0.01, 0, 0]}}]
places: {entry: [0, 0, 0.2], target: [0, 0, 0.03]}
guidance:
  - margin: 3 mm around: liver
  - stay-in: cone(entry, target)
  - keep-rcm
  - {geometry: {sphere: {radius: 0.1}}, role: keep-in, frame: liver}
"""
ATTACHED = """
objects: [{sphere: {radius: 0.03}}]
guidance: [{name: ahead, geometry: {point: {at: [0, 0.01, 0]}}, role: guide, frame: FRAME}]
operator: {path: [{t: 0, xyz: [0, 0, 0.05]}, {t: 1, xyz: [0.02, 0, 0.05]}]}
"""


def test_a_scene_attaches_a_fixture_to_its_tool_and_to_a_camera_that_is_told():
    session = palpate.Session(Scene.parse(ATTACHED.replace("FRAME", "tool")))
    session.step(600)
    assert session.step().tick["guidance_gap"] == pytest.approx(-0.01, abs=1e-3)
    session = palpate.Session(Scene.parse(ATTACHED.replace("FRAME", "camera")))
    X_WC = np.eye(4)
    X_WC[:3, 3] = [0, 0.02, 0.05]
    session.frames["camera"].set(X_WC)
    goal = np.array(session.step().tick["p_WT_goal"])
    assert session.latest()["guidance_gap"] == pytest.approx(-np.linalg.norm(goal - [0, 0.03, 0.05]), abs=1e-6)


def test_a_scene_lists_fixtures_and_writes_them_back():
    scene = Scene.parse(SCENE)
    assert [f.name for f in scene.guidance] == ["liver", "cone", "keep-rcm", "keep-in"]
    assert Scene.parse(scene.to_yaml()).guidance == scene.guidance
    rig = build(scene)
    assert len(rig.fixtures) == 4
    np.testing.assert_allclose(rig.here.place("rcm", np.eye(4)), rig.arms.X_WB[:3, 3])
    assert Scene.parse(rig.resolved_yaml(absolute=True)).guidance == scene.guidance


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("keep-rcm\n", "keep-out\n", r"scene.yaml:7: guidance\[2\]: 'keep-out' is no fixture"),
        ("3 mm", "3 mn", r"scene.yaml:5: guidance\[0\].role.margin: '3 mn' is no length"),
        ("radius: 0.1}", "radius: -0.1}", r"scene.yaml:8: guidance\[3\].geometry.sphere.radius must be greater than 0"),
        ("radius: 0.1}", "radios: 0.1}", r"(?s)unknown key .*radios.*did you mean 'radius'"),
        ("role: keep-in", "role: keepin", r"guidance\[3\].role.name must be 'guide', 'forbid'"),
        ("around: liver", "around: spleen", r"scene.yaml:5: fixture 'spleen': there is no object 'spleen'"),
        ("frame: liver", "frame: spleen", r"scene.yaml:8: fixture 'keep-in': there is no frame 'spleen'"),
        ("(entry, target)", "(entry, entry)", r"scene.yaml:6: fixture 'cone': a cone needs a finite apex"),
    ],
)
def test_a_mistake_in_a_scene_is_told_with_its_line(old, new, told):
    with pytest.raises(SceneError, match=told):
        build(Scene.parse(SCENE.replace(old, new)))


def test_two_fixtures_of_one_name_are_refused_and_nameless_ones_numbered():
    both = "  - {geometry: {sphere: {radius: 0.1}}, role: keep-in, frame: liver}\n"
    assert [f.name for f in Scene.parse(SCENE + both).guidance][-2:] == ["keep-in", "keep-in-5"]
    with pytest.raises(SceneError, match="two fixtures are named 'cone'"):
        Scene.parse(SCENE + "  - stay-in: cone(entry, target)\n")


def test_why_names_the_term_that_made_the_force():
    fixture = Fixture(Sphere(radius=0.03), role={"name": "forbid", "margin": 0.002}, name="vessel")
    told = fixture.why([0.028, 0, 0], V_WT=[-0.02, 0, 0, 0, 0, 0])
    assert "vessel (forbid, law spring, soft)" in told
    assert "the tool is 4 mm inside its margin of 2 mm" in told
    assert "spring: 1.6 N, at 400 N/m" in told
    assert "damping: 0.04 N, at 2 N s/m" in told
    assert "together 1.64 N along (+1.00, +0.00, +0.00) in W; most of it is the spring" in told
    assert "no force" in fixture.why([0.1, 0, 0])
    assert "switched off" in fixture.model_copy(update={"enabled": False}).why([0.028, 0, 0])


@pytest.mark.parametrize("key", SHAPES)
def test_every_geometry_can_be_drawn(key, here):
    role = {"name": "forbid" if key not in ("point", "line", "path") else "guide", "margin": 0.002}
    axes = Fixture(geometry={key: SHAPES[key]}, role=role).plot(here=here)
    assert axes.collections or axes.lines
    mpl.pyplot.close("all")


def test_several_fixtures_go_round():
    fixtures = [Fixture("margin: 3 mm around: ball.stl"), Fixture(Mesh(file="ball.stl"), role="guide", name="b")]
    assert list(from_yaml(to_yaml(fixtures))) == fixtures


def test_a_session_is_guided_tells_why_and_takes_other_fixtures_while_it_runs():
    text = """
objects: [{sphere: {radius: 0.03}}]
guidance: [{name: line, geometry: {line: {start: [0, 0.01, 0.05], end: [0.03, 0.01, 0.05]}}, role: guide}]
operator: {path: [{t: 0, xyz: [0, 0, 0.05]}, {t: 1, xyz: [0.02, 0, 0.05]}]}
"""
    session = palpate.Session(Scene.parse(text))
    tick = session.step(300).tick
    pulled = np.array(tick["F_guidance_W"])
    assert pulled[1] > 0.5, "towards the line"
    told = session.why()
    assert "guidance pulls with" in told
    assert "most of it is line's" in told
    assert "at 400 N/m" in told
    session.fixtures = [f.model_copy(update={"enabled": False}) for f in session.fixtures]
    after = session.step(1).tick
    assert np.linalg.norm(np.array(after["F_guidance_W"]) - pulled) < 0.1, "no step"
    assert np.linalg.norm(session.step(600).tick["F_guidance_W"]) < 1e-6
    assert session.why() == "no fixture pulls"


def test_the_published_schema_knows_the_lines_too():
    item = json.loads(schema_text())["$defs"]["Fixture"]
    assert item["type"] == ["object", "string"]
    assert [one["required"] for one in item["anyOf"]] == [["geometry", "role"], *([key] for key in KEYS)]
    assert set(item["properties"]) >= {*KEYS, "around", "unit", *Fixture.model_fields}
