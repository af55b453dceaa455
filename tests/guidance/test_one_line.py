"""Fixtures in one line: their meaning, and errors with remedies for mistakes and missing names."""

import json

import numpy as np
import pytest
from fixtures import pose

from palpate import _core
from palpate.base.errors import GuidanceError
from palpate.scene.guidance import Fixture, FixtureContext, from_yaml
from palpate.scene.guidance.one_line import KEYS
from palpate.scene.guidance.plot import query
from palpate.scene.schema import schema_text


def test_margin_around_a_mesh_in_one_line(here):
    """A margin of 3 mm around a ball of 20 mm: gap of a tool at 24 mm and at 22 mm from its centre."""
    fixture = Fixture("margin: 3 mm around: ball.stl")
    assert (fixture.role.name, fixture.role.margin, fixture.hard, fixture.name) == ("forbid", 0.003, True, "ball")
    core = fixture.make(here)
    assert core.evaluate(pose((0.024, 0, 0)))["gap"] == pytest.approx(0.001, abs=1e-4)
    assert core.evaluate(pose((0.022, 0, 0)))["gap"] == pytest.approx(-0.001, abs=1e-4)
    same = from_yaml(
        "- margin: 3 mm around: ball.stl\n- margin: 3 mm around ball.stl\n- {margin: 3 mm, around: ball.stl}"
    )
    assert {f.to_yaml() for f in same} == {fixture.to_yaml()}
    soft = from_yaml("[{margin: 0.003, around: ball.stl, hard: false, authority: 0.3, unit: m}]")[0]
    assert (soft.hard, soft.authority, soft.geometry.mesh.unit) == (False, 0.3, "m")


def test_path_cone_and_trocar_in_one_line(here):
    follow = Fixture("follow: suture.csv")
    assert follow.role.name == "guide"
    assert query(follow.make_geometry(here), [[0.01, 0.005, 0.003]], 0.0)["distance"][0] < 0.004
    stay = Fixture("stay-in: cone(entry, target)").make(here)
    assert stay.role == "keep-in"
    assert stay.evaluate(pose((0, 0, 0.07)))["gap"] == pytest.approx(0.05 * np.sin(_core.CONE_HALF_ANGLE))
    wide = Fixture("stay-in: cone([0, 0, 10 cm], target, 30 deg)").make(here)
    assert wide.evaluate(pose((0, 0, 0.07)))["gap"] == pytest.approx(0.025)
    rcm = Fixture("keep-rcm")
    assert (rcm.role.name, rcm.geometry.point.at) == ("rcm", "rcm")
    assert Fixture("keep-rcm: entry").geometry.point.at == "entry"
    assert Fixture("stay-in: tube(suture.csv, 2 mm)").make(here).evaluate(np.eye(4))["gap"] == pytest.approx(0.002)
    around = Fixture("margin: 1 mm around: liver")
    assert (around.geometry.object.name, around.frame.of) == ("liver", "liver")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("margin: 3 mm", "does not name what it is around"),
        ("margin: 3 furlongs around: ball.stl", "role.margin must be a number. Got: '3 furlongs' | write it in m"),
        ("keep-away: ball.stl", "is not a fixture"),
        ("follow: suture.docx", "has an unknown file type"),
        ("stay-in: pyramid(a, b)", "there is no shape 'pyramid'"),
        ("stay-in: cone(a, b, c, d)", "has 4 arguments"),
    ],
)
def test_error_for_an_invalid_line_lists_the_choices(text, message):
    with pytest.raises(GuidanceError, match=message.split(" | ")[0].replace("(", r"\(")):
        from_yaml(f"- {text!r}")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("follow: sutur.csv", r"(?s)file not found.*did you mean .*suture.csv"),
        ("margin: 1 mm around: missing.stl", "mesh file not found"),
        ("margin: 1 mm around: open.stl", r"(?s)open.stl' is open, but a forbidden region needs an inside.*--repair"),
        ("margin: 1 mm around: livre", r"(?s)there is no object 'livre'.*did you mean 'liver'"),
        ("stay-in: cone(entrance, target)", "there is no place 'entrance'"),
        ("stay-in: cone(entry, entry)", "a cone needs a finite apex, and a mouth apart from it"),
        ("keep-rcm", "there is no place 'rcm'"),
    ],
)
def test_missing_names_are_reported_with_the_remedy(line, message, here):
    with pytest.raises(Exception, match=message):
        Fixture(line).make(here)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("", "the file holds no places"),
        ("x_mm,y_mm,z_mm\n1,2\n", r"2 numbers in a row\n  mend: x y z, or"),
        ("1,2,3\nfour,5,6\n", "'four,5,6' is not a row of numbers"),
        ("x_ft,y_ft,z_ft\n1,2,3", "unknown unit 'ft' in 'x_ft'"),
        ("1,2,3,1,1,0,0\n2,2,3,1,0,0,0", "quaternion of length 1.41"),
        ("0,0,0\n20000,0,0", r"20 m long\n  why: waypoints are in metres here\n  mend: is the unit mm"),
        ("0,0,0\n10,10,0\n10,0,0\n0,10,0", "the path crosses itself"),
    ],
)
def test_invalid_path_file_is_reported_with_its_line(rows, message, tmp_path):
    (tmp_path / "p.csv").write_text(rows)
    with pytest.raises(GuidanceError, match=message):
        Fixture("follow: p.csv").make(FixtureContext(lambda name: tmp_path / name))


def test_published_schema_includes_one_line_fixtures():
    item = json.loads(schema_text())["$defs"]["Fixture"]
    assert item["type"] == ["object", "string"]
    assert [one["required"] for one in item["anyOf"]] == [["geometry", "role"], *([key] for key in KEYS)]
    assert set(item["properties"]) >= {*KEYS, "around", "unit", *Fixture.model_fields}
