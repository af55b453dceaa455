"""Invalid values given in Python are refused in Palpate's words, as those of a file are."""

import pytest

import palpate
from palpate.base.errors import DeviceError, InvalidSceneError, PalpateError, SceneError
from palpate.base.values import Section
from palpate.scene import Scene
from palpate.scene.guidance.sections import Law

BALL = {"name": "ball", "sphere": {"radius": 0.03}}


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"objects": [{"sphere": {"radius": -1}}]}, "Scene: objects[0].sphere.radius must be greater than 0. Got: -1"),
        ({"objects": [BALL], "sed": 3}, "unknown key 'sed'\n  mend: did you mean 'seed'?"),
        ({}, "'objects' is missing"),
        ({"objects": [BALL], "guidance": [{"folow": "a.csv"}]}, "did you mean 'follow'?"),
        ({"objects": [{**BALL, "stiffness": "soft"}]}, "objects[0].stiffness: must be a number, or a list of three"),
    ],
)
@pytest.mark.parametrize("make", [Scene.model_validate, lambda values: Scene(**values)])
def test_an_invalid_scene_in_python_is_explained(make, values, words):
    with pytest.raises(InvalidSceneError) as error:
        make(values)
    assert words in str(error.value)
    assert "pydantic" not in str(error.value)
    assert isinstance(error.value, SceneError)
    assert isinstance(error.value, ValueError)


def test_all_errors_are_listed():
    with pytest.raises(PalpateError) as error:
        Scene.model_validate({"objects": [BALL], "sed": 3, "contact": {"radius": "x"}})
    assert "unknown key 'sed'" in str(error.value)
    assert "contact.radius must be a number" in str(error.value)


@pytest.mark.parametrize("given", [7, {"objects": [BALL]}, None])
def test_something_else_than_a_scene_is_named(given):
    with pytest.raises(DeviceError, match=r"takes a scene, or the path of a scene file. Got: (int|dict|NoneType)"):
        palpate.Haptics(given)


def test_a_file_still_names_its_lines():
    with pytest.raises(SceneError, match=r"s\.yaml:2: unknown key 'sed'"):
        Scene.parse("objects: [{sphere: {radius: 0.03}}]\nsed: 3\n", "s.yaml")


def sections(kind=Section):
    """All sections of a scene that are Palpate's own, and their sections."""
    for one in kind.__subclasses__():
        if one.__module__.startswith("palpate.") and one.model_config["extra"] == "forbid":
            yield one
        yield from sections(one)


@pytest.mark.parametrize("kind", sorted(set(sections()), key=lambda one: (one.__module__, one.__name__)))
@pytest.mark.parametrize("how", ["constructor", "model_validate"])
def test_every_section_alone_refuses_in_words_of_a_scene(kind, how):
    values = {"no_such_key": 1.0}
    with pytest.raises(InvalidSceneError) as error:
        kind(**values) if how == "constructor" else kind.model_validate(values)
    said = str(error.value)
    assert said.startswith(f"{kind.__name__}: ")
    assert said.count(f"{kind.__name__}: {kind.__name__}") == 0
    assert "no_such_key" in said
    assert "pydantic" not in said


@pytest.mark.parametrize(
    ("make", "what", "why", "mend"),
    [
        (
            lambda: palpate.Fixture(role="forbid", geometry={"sphere": {"radius": -0.1}}),
            "geometry.sphere.radius must be greater than 0. Got: -0.1",
            "radius: radius [m]",
            "write a number greater than 0 [m]",
        ),
        (
            lambda: palpate.Fixture(palpate.guidance.Sphere(radius=0.1), role="forbit"),
            "role.name must be 'guide', 'forbid', 'keep-in', 'orient', 'limit' or 'rcm'. Got: 'forbit'",
            "name: guide: attract the tool",
            "did you mean 'forbid'?",
        ),
        (
            lambda: palpate.guidance.Sphere(radius="3 kg"),
            "radius must be a number. Got: '3 kg'",
            "radius: radius [m]",
            "write it in m",
        ),
        (lambda: palpate.Fixture("sideways"), "'sideways' is not a fixture", "", "write one of margin: 3 mm around:"),
        (lambda: palpate.Fixture.model_validate(3), "must be a section", "", "write NAME: value"),
        (lambda: Law(stiffness=-1.0), "stiffness must be at least 0. Got: -1.0", "stiffness of the spring", "[N/m]"),
        (lambda: Law(ratio=0.5), "spring does not read ratio", "", "leave ratio out"),
    ],
)
def test_a_section_alone_names_value_cause_and_mend(make, what, why, mend):
    with pytest.raises(PalpateError) as error:
        make()
    assert error.value.what.startswith(what)
    assert why in error.value.why
    assert mend in error.value.mend


def test_a_fixture_in_a_scene_names_each_of_its_values():
    line = {"geometry": {"sphere": {"radius": -1.0}}, "role": "forbit"}
    with pytest.raises(InvalidSceneError) as error:
        Scene.model_validate({"objects": [BALL], "guidance": [line]})
    first, second = (error.value, *error.value.others)
    assert {first.what.split()[0], second.what.split()[0]} == {
        "guidance[0].geometry.sphere.radius",
        "guidance[0].role.name",
    }
