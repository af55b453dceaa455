"""Mistakes in a scene file: each message states file, line, cause and remedy."""
# ruff: noqa: E501  (a message and its text stay on one line)

import contextlib

import pytest
from effort import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate.base.arrays.yaml_loader import Loader
from palpate.base.errors import MeshError, SceneError
from palpate.scene import Scene
from palpate.scene.rig import build

ONE = "objects:\n  - shape: organ\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("objects:\n  - mesh: a.stl\n    stifness: 3\n", "s.yaml:3: unknown key 'objects[0].stifness'\n  mend: did you mean 'stiffness'?"),
        (ONE + "radius: 3\n", "s.yaml:3: unknown key 'radius'\n  mend: did you mean 'contact.radius'?"),
        (ONE + "contact:\n  qqq: 1\n", "s.yaml:4: unknown key 'contact.qqq'\n  mend: remove it; valid keys here: method, radius, collision_rate"),
        (ONE + "seed: many\n", "s.yaml:3: seed must be a whole number. Got: 'many'\n  why: seed: seed of all random numbers\n  mend: write a whole number"),
        (ONE + "seed: -1\n", "s.yaml:3: seed must be at least 0. Got: -1"),
        (ONE + "loop_delay: yes\n", "s.yaml:3: loop_delay must be a number. Got: True"),
        (ONE + "loop_delay: .nan\n", "s.yaml:3: loop_delay must be a finite number. Got: nan"),
        (ONE + "    stiffness: soft\n", "s.yaml:3: objects[0].stiffness: must be a number, or a list of three. Got: 'soft'"),
        (ONE + "    damping: [1, 2]\n", "s.yaml:3: objects[0].damping has too few numbers. Got: [1, 2]"),
        (ONE + "    pose: 3\n", "s.yaml:3: objects[0].pose must be a section with keys such as xyz, rpy_deg. Got: 3"),
        (ONE + "    pose: {xyz: [0, 0, a]}\n", "s.yaml:3: objects[0].pose.xyz[2] must be a number. Got: 'a'\n  why: xyz: origin [m]\n  mend: write a number [m], or one with its unit (um, mm, cm, m, in)"),
        (ONE + "contact: [1]\n", "s.yaml:3: contact must be a section with keys such as method, radius, collision_rate, whole_tool, spheres, release. Got: [1]"),
        ("objects:\n  - mesh: a.stl\n    unit: feet\n", "s.yaml:3: objects[0].unit must be 'mm', 'cm', 'm' or 'in'. Got: 'feet'"),
        ("objects:\n  - {}\n", "s.yaml:2: objects[0]: an object is one of mesh, cloud, sdf, shape, plane,"),
        ("objects:\n  - {mesh: a, shape: organ}\n", "mesh and shape are given"),
        ("objects: []\n", "s.yaml:1: objects must have at least 1 entry. Got: []"),
        ("objects: 3\n", "s.yaml:1: objects must be a list. Got: 3"),
        ("seed: 1\n", "'objects' is missing\n  why: objects that can be touched"),
        ("", "the scene is empty"),
        ("# nothing\n", "the scene is empty"),
        ("hello", "s.yaml:1: a scene is a mapping of sections\n  why: the file holds a str"),
        ("a: [1", "s.yaml:1: not valid YAML\n  why: while parsing a flow sequence, "),
        (ONE + "\tseed: 1\n", "s.yaml:3: not valid YAML\n  why: there is a tab in this line, which YAML does not allow as indentation\n  mend: use spaces"),
        ("objects:\n  shape: organ\n", "s.yaml:1: objects must be a list. Got: {'shape': 'organ'}\n  why: objects: objects that can be touched\n  mend: add `- ` before its first key"),
        (ONE + "contact: {radius: 2 ft}\n", "s.yaml:3: contact.radius must be a number. Got: '2 ft'\n  why: radius: radius of the sphere on the tool tip that touches the objects [m]\n  mend: write it in m, or in another unit of the same kind: um, mm, cm, m, in"),
        (ONE + "contact: {radius: 2 N}\n", "s.yaml:3: contact.radius must be a number. Got: '2 N'"),
        (ONE + "contact: {method: proxxy}\n", "mend: did you mean 'proxy'?"),
        (ONE + "    stiffness: -400\n", "s.yaml:3: objects[0].stiffness: must be 0 or more, and finite. Got: -400"),
        (ONE + "1: 2\n", "s.yaml:3: [1] is a name that is not text. Got: 1"),
        (ONE + "seed: 1\nseed: 2\n", "s.yaml:4: key 'seed' given twice\n  why: first given in line 3"),
        ("&a [*a]", "a value contains itself"),
        ("!!python/object/apply:os.system [ls]", "not valid YAML"),
        ("\0", "not valid YAML"),
        ("objects: " + "[" * 3000, "not valid YAML"),
        (ONE + "preset: papper\n", "s.yaml:3: preset must be 'paper' or 'as-shipped'. Got: 'papper'"),
        (ONE + "operator: {path: []}\n", "operator: path is empty"),
        (ONE + "operator:\n  path:\n    - {t: 1, xyz: [0, 0, 0]}\n    - {t: 1, xyz: [0, 0, 0]}\n", "path: times must rise: 1 s follows 1 s"),
        (ONE + "operator:\n  palpate:\n    object: liver\n", "s.yaml:5: operator.palpate.object: there is no object 'liver'\n  mend: name one of organ"),
        ("objects:\n  - {shape: organ, name: a}\n  - {shape: organ, name: a}\n", "s.yaml:3: objects[1].name: another object is named 'a' too\n  mend: rename one of them"),
        (ONE + "arms: {leader: {start: []}}\n", "arms.leader.start must have at least 1 entry. Got: []"),
        (ONE + "arms: {leader: {model: omega}}\n", "arms.leader.model: there is no arm 'omega'"),
    ],
)  # fmt: skip
def test_mistake_is_reported_with_its_line(text, message):
    with pytest.raises(SceneError) as caught:
        Scene.parse(text, "s.yaml")
    assert message in str(caught.value)


def test_all_mistakes_are_reported_in_the_order_of_the_file():
    with pytest.raises(SceneError) as caught:
        Scene.parse("objects:\n  - mesh: a.stl\n    stifness: 3\n    unit: feet\nseeed: 1\n", "s.yaml")
    lines = [line for line in str(caught.value).splitlines() if line.startswith("s.yaml:")]
    assert [line.split(":")[1] for line in lines] == ["3", "4", "5"]
    assert len(caught.value.others) == 2


def test_error_for_a_missing_file_lists_similar_files(tmp_path):
    (tmp_path / "liver.yaml").write_text(ONE)
    with pytest.raises(SceneError, match=r"livr\.yaml: scene file not found\n  mend: scenes in .*: liver\.yaml"):
        Scene.load(tmp_path / "livr.yaml")


@pytest.mark.parametrize(("data", "message"), [(b"\xff\xfe\x00", "not a text file"), (b"", "the scene is empty")])
def test_other_files_are_rejected(tmp_path, data, message):
    (tmp_path / "s.yaml").write_bytes(data)
    with pytest.raises(SceneError, match=message):
        Scene.load(tmp_path / "s.yaml")


def test_folder_is_rejected(tmp_path):
    with pytest.raises(SceneError, match="scene file cannot be read"):
        Scene.load(tmp_path)


def test_missing_mesh_is_reported_with_its_line(tmp_path):
    scene = Scene.parse("objects:\n  - mesh: a.stl\n", str(tmp_path / "s.yaml"))
    with pytest.raises(MeshError, match=r"s\.yaml:2: mesh file not found\n  why: .*a\.stl\n  mend: check the path"):
        build(scene)


def test_sixty_thousand_objects_are_refused_before_they_are_read(monkeypatch):
    """Reading ends at the limit: the loader composes no value beyond it."""
    composed = []
    compose = Loader.compose_node
    monkeypatch.setattr(Loader, "compose_node", lambda *args: composed.append(0) or compose(*args))
    with pytest.raises(SceneError, match=r"more than 50,000 values[\s\S]*files of their own"):
        Scene.parse("objects:\n" + "  - {shape: organ, stiffness: 400}\n" * 60_000)
    assert len(composed) == 50_001, "the last one is refused"


def test_unset_variable_is_reported(monkeypatch):
    monkeypatch.delenv("ORGANS", raising=False)
    scene = Scene.parse("objects:\n  - mesh: ${ORGANS}/a.stl\n", "s.yaml")
    with pytest.raises(SceneError, match=r"s\.yaml:2: variable ORGANS is not set[\s\S]*export ORGANS="):
        scene.path_of(0)


_words = st.sampled_from(
    [
        *[
            "objects",
            "mesh",
            "shape",
            "organ",
            "a.stl",
            "contact",
            "radius",
            "stiffness",
            "operator",
            "path",
            "t",
            "xyz",
            "preset",
            "paper",
            "pose",
            "arms",
        ],
        *[
            "leader",
            "start",
            "[",
            "]",
            "{",
            "}",
            "&a",
            "*a",
            "1e3",
            "-1",
            ".nan",
            "yes",
            "~",
            "'",
            "|",
            ">",
            "#",
            "!!",
            "%",
            "@",
            "0x1",
            "2001-13-41",
            "1:2:3",
            "<<",
        ],
        *("- ", ": ", "\n", "  ", "\t", '"'),
    ]
)


@settings(max_examples=examples(300), deadline=None)
@given(st.lists(_words, max_size=40).map("".join) | st.text(max_size=60))
def test_any_text_gives_a_scene_or_a_scene_error(text):
    with contextlib.suppress(SceneError):
        Scene.parse(text)


_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=8,
)


@settings(max_examples=examples(300), deadline=None)
@given(st.sampled_from(sorted(Scene.model_fields)), _values)
def test_any_value_of_a_section_gives_a_scene_or_a_scene_error(section, value):
    import yaml

    text = yaml.safe_dump({"objects": [{"shape": "organ"}], section: value})
    with contextlib.suppress(SceneError):
        Scene.parse(text)


def test_too_many_objects_are_rejected():
    """The contact methods have room for 512 objects; one more would be drawn but not rendered."""
    with pytest.raises(SceneError, match="512"):
        Scene.parse("objects:\n" + "- {sphere: {radius: 0.01}}\n" * 513)
