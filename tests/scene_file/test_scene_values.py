"""Values of a scene file are in the scene; missing values are those of the core."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from palpate import _core
from palpate.scene import Pose, Scene
from palpate.scene.schema import schema_text
from palpate.values import Diagonal, Place
from palpate.values import metres as length_in_metres

ROOT = Path(__file__).parents[2]


def test_own_stl_in_five_lines():
    scene = Scene.parse("objects:\n  - mesh: my_organ.stl\n    unit: mm\n    stiffness: 500\n    friction: 0.1\n")
    obj = scene.objects[0]
    assert (obj.name, obj.mesh, obj.unit, obj.friction) == ("my_organ", "my_organ.stl", "mm", 0.1)
    assert obj.stiffness == (500.0, 500.0, 500.0)


def test_defaults_are_those_of_the_core():
    scene, core, material = Scene.parse("objects: [{shape: organ}]"), _core.SimulationOptions(), _core.Material()
    assert scene.contact.radius == core.contact.radius == 0.002
    assert scene.contact.release == core.contact.release == 0.05
    assert scene.stability.force_cap == core.stability.force_cap == 3.0
    assert scene.stability.rate_cap == core.stability.rate_cap == 50.0
    assert scene.stability.stale_after == core.stability.stale_after == 0.03
    assert scene.rates.haptic == core.rate
    assert scene.rates.plant == core.plant_rate
    assert scene.mapping.scale == core.mapping.scale
    assert scene.operator.stiffness == core.hand.stiffness
    assert scene.objects[0].stiffness == tuple(material.K)


def test_off_needs_no_quotes():
    """YAML 1.1 reads it as false."""
    scene = Scene.parse("objects: [{name: wall, plane: {}}]\nstability: {passivity: off}\n")
    assert scene.stability.passivity == "off"


def test_preset_paper_has_the_values_of_the_paper():
    scene = Scene.parse("preset: paper\nobjects: [{shape: organ}]")
    assert (scene.contact.radius, scene.rates.haptic, scene.torque.mode) == (0.015, 500.0, "paper")
    assert scene.objects[0].stiffness == (400.0,) * 3
    assert scene.objects[0].damping == (5.0,) * 3


def test_preset_as_shipped_has_slow_haptics_and_no_damping():
    scene = Scene.parse("preset: as-shipped\nobjects: [{shape: organ}]")
    assert (scene.rates.haptic, scene.contact.collision_rate, scene.contact.method) == (100.0, 250.0, "paper-alg1")
    assert scene.objects[0].damping == (0.0,) * 3


def test_values_of_the_file_take_precedence_over_the_preset():
    scene = Scene.parse("preset: paper\nobjects: [{shape: organ, stiffness: 300}]\nrates: {haptic: 2000}")
    assert (scene.objects[0].stiffness[0], scene.objects[0].damping[0]) == (300.0, 5.0)
    assert (scene.rates.haptic, scene.contact.radius) == (2000.0, 0.015)


def test_scientific_notation_is_a_number():
    assert Scene.parse("objects: [{shape: organ, stiffness: 1e3}]\nloop_delay: 1e-3").loop_delay == 0.001


@pytest.mark.parametrize(
    "text", ["objects: [{mesh: a.stl, unit: cm}]", "objects: [{shape: organ}]\npreset: paper\nseed: 5"]
)
def test_every_value_survives_a_round_trip(text):
    scene = Scene.parse(text)
    assert Scene.parse(scene.to_yaml()).model_dump() == scene.model_dump()


def test_objects_without_a_name_get_that_of_their_file():
    scene = Scene.parse("objects: [{mesh: a/liver.stl}, {mesh: b/liver.stl}, {shape: organ}]")
    assert [o.name for o in scene.objects] == ["liver", "liver-2", "organ"]


def test_paths_are_relative_to_the_scene(monkeypatch):
    monkeypatch.setenv("ORGANS", "/organs")
    scene = Scene.parse(
        "objects: [{mesh: a.stl}, {mesh: '${ORGANS}/b.stl'}, {mesh: '${NOWHERE:-../x}/c.stl'}]", "d/s.yaml"
    )
    assert [str(scene.path_of(i)) for i in range(3)] == ["d/a.stl", "/organs/b.stl", "d/../x/c.stl"]


def test_values_know_their_line():
    scene = Scene.parse("seed: 1\nobjects:\n  - shape: organ\n    stiffness: 3\n", "s.yaml")
    assert scene.where("objects", 0, "stiffness") == "s.yaml:4"
    assert scene.where("objects", 0, "damping") == "s.yaml:3"
    assert scene.where("contact", "radius") == "s.yaml"


def test_scene_cannot_be_changed():
    with pytest.raises(ValidationError, match="frozen"):
        Scene.parse("objects: [{shape: organ}]").seed = 3


@given(st.tuples(*[st.floats(-180, 180)] * 3))
def test_pose_is_yaw_pitch_roll(rpy):
    """Reference: three successive rotations about the fixed axes x, y, z."""

    def turn(axis, degrees):
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        R = np.eye(3)
        i, j = [(1, 2), (2, 0), (0, 1)][axis]
        R[i, i] = R[j, j] = c
        R[i, j], R[j, i] = -s, s
        return R

    X = Pose(xyz=(1, 2, 3), rpy_deg=rpy).matrix()
    np.testing.assert_allclose(X[:3, :3], turn(2, rpy[2]) @ turn(1, rpy[1]) @ turn(0, rpy[0]), atol=1e-12)
    np.testing.assert_array_equal(X[:3, 3], [1, 2, 3])


def test_published_schema_is_up_to_date():
    published = ROOT / "docs/scene.schema.json"
    assert published.read_text() == schema_text(), "renew it: palpate schema --out docs/scene.schema.json"


def test_every_key_of_the_schema_is_described():
    definitions = json.loads(schema_text())["$defs"]
    bare = [
        f"{name}.{key}"
        for name, d in definitions.items()
        for key, p in d["properties"].items()
        if not p.get("description")
    ]
    assert bare == []


@pytest.mark.parametrize("path", sorted((ROOT / "scenes").glob("*.yaml")), ids=lambda p: p.name)
def test_shipped_scenes_are_valid_and_name_the_schema(path):
    Scene.load(path)
    assert "# yaml-language-server: $schema=../docs/scene.schema.json\n" in path.read_text()


@pytest.mark.parametrize(
    ("text", "metres"),
    [("36 in", 0.9144), ("100 cm", 1.0), ("1000mm", 1.0), ("1e6 um", 1.0), (" -2.5 m ", -2.5), (".5 cm", 0.005)],
)
def test_length_with_a_unit_is_in_metres(text, metres):
    """Reference: the yard is 36 inches and 0.9144 m by its definition; the other units are powers of ten of a metre."""
    assert length_in_metres(text) == metres


def test_number_is_a_length_in_metres():
    assert length_in_metres(0.25) == 0.25


@pytest.mark.parametrize("text", ["3", "mm", "3 ft", "3 mm wide", "1 2 mm"])
def test_text_without_number_or_known_unit_is_no_length(text):
    with pytest.raises(ValueError, match=r"is not a length \| write metres.*3 mm \(um, mm, cm, m, in\)") as caught:
        length_in_metres(text)
    assert repr(text) in str(caught.value)


def test_every_component_of_a_position_has_its_own_unit():
    adapter = TypeAdapter(Place)
    assert adapter.validate_python(["1 in", "2 mm", 3]) == (0.0254, 0.002, 3.0)
    assert adapter.validate_python("port") == "port"


@pytest.mark.parametrize("value", [True, "500", None])
def test_stiffness_is_a_number_or_three(value):
    with pytest.raises(ValidationError, match=r"must be a number, or a list of three\. Got: .* \| write e\.g\. 500"):
        TypeAdapter(Diagonal).validate_python(value)


def test_stiffness_of_one_number_is_that_of_every_axis():
    adapter = TypeAdapter(Diagonal)
    assert adapter.validate_python(500) == (500.0, 500.0, 500.0)
    assert adapter.validate_python([1.0, 2.0, 3.0]) == adapter.validate_python((1.0, 2.0, 3.0)) == (1.0, 2.0, 3.0)
