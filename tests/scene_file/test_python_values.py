"""Invalid values given in Python are refused in Palpate's words, as those of a file are."""

import pytest

import palpate
from palpate.errors import DeviceError, InvalidSceneError, PalpateError, SceneError
from palpate.scene import Scene

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
