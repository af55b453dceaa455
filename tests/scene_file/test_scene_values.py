"""Values of a scene file are in the scene; missing values are those of the core."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from palpate import _core
from palpate.base.values import Diagonal, Section, units
from palpate.base.values.descriptions import descriptions
from palpate.scene import Pose, Scene
from palpate.scene.schema import schema_text

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
    ("text", "unit", "value"),
    [
        *(("36 in", "m", 0.9144), ("100 cm", "m", 1.0), ("1000mm", "m", 1.0), ("1e6 um", "m", 1.0)),
        *((".5 cm", "m", 0.005), ("3 mm", "m", 0.003), ("0.4 N/mm", "N/m", 400.0), ("-2.5 mm", "m", -0.0025)),
        *(("180 deg", "rad, m", math.pi), ("2 mm", "rad, m", 0.002), ("1 kHz", "Hz", 1000.0)),
        *(("50 mm/s", "m/s", 0.05), ("5 Ns/m", "N s/m", 5.0)),
        *(("2 N*m/rad", "N m/rad", 2.0), ("981 cm/s^2", "m/s^2", 9.81), ("20 ms", "s", 0.02), ("2 mJ", "J", 0.002)),
        *(("1e999999999 m", "m", math.inf), ("1e-999999999 m", "m", 0.0)),
    ],
)  # fmt: skip
def test_text_with_a_unit_is_converted_to_the_unit_of_the_key(text, unit, value):
    """Reference: the yard is 36 inches and 0.9144 m by its definition; the others are powers of ten, or of pi."""
    assert units.convert(text, unit) == value


@pytest.mark.parametrize(
    ("text", "unit"),
    [("3", "m"), ("mm", "m"), ("3 ft", "m"), ("3 mm wide", "m"), ("1 2 mm", "m"), ("3 N", "m"), ("2 N m", "N m/rad")],
)
def test_text_without_number_or_with_another_kind_of_unit_is_not_converted(text, unit):
    assert units.convert(text, unit) is None


def test_every_key_with_a_unit_reads_text_with_a_unit():
    scene = Scene.parse(
        "objects: [{sphere: {radius: 3 cm}, stiffness: 0.4 N/mm, damping: [1 N s/m, 2, 3],"
        " pose: {rpy_deg: [0, 1 rad, 0]}, regions: [{at: [1 mm, 0, 0], radius: 5 mm}]}]\n"
        "contact: {radius: 2 mm}\nloop_delay: 1 ms\nplaces: {a: [1 cm, 0, 0]}\n"
        "guidance: [{geometry: {point: {at: a}}, role: guide, ramps: [{by: time, start: 0, end: 200 ms}]}]\n"
    )
    obj = scene.objects[0]
    assert (obj.sphere.radius, obj.stiffness, obj.damping) == (0.03, (400.0,) * 3, (1.0, 2.0, 3.0))
    assert (obj.pose.rpy_deg[1], obj.regions[0].at) == (math.degrees(1.0), (0.001, 0.0, 0.0))
    assert (scene.contact.radius, scene.loop_delay, scene.places["a"][0]) == (0.002, 0.001, 0.01)
    assert scene.guidance[0].ramps[0].end == 0.2


def test_every_dimensional_number_of_a_scene_states_its_unit():
    """Text with a unit is read where the description ends with the unit; other numbers say why they have none."""
    without = set()
    for section in (s for s in _sections(Section) if not s.__name__.startswith("_")):
        for key, field in section.model_fields.items():
            if "float" in str(field.annotation) and not descriptions(section).get(key, "").endswith("]"):
                without.add(f"{section.__name__}.{key}")
    assert without == {"FrameSection.stamp", "ObjectSection.threshold", "Ramp.end", "Ramp.start"}


def _sections(section):
    for child in section.__subclasses__():
        yield child
        yield from _sections(child)


@pytest.mark.parametrize("value", [True, "500", None])
def test_stiffness_is_a_number_or_three(value):
    with pytest.raises(ValidationError, match=r"must be a number, or a list of three\. Got: .* \| write e\.g\. 500"):
        TypeAdapter(Diagonal).validate_python(value)


def test_stiffness_of_one_number_is_that_of_every_axis():
    adapter = TypeAdapter(Diagonal)
    assert adapter.validate_python(500) == (500.0, 500.0, 500.0)
    assert adapter.validate_python([1.0, 2.0, 3.0]) == adapter.validate_python((1.0, 2.0, 3.0)) == (1.0, 2.0, 3.0)
