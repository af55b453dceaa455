"""Values that are possible but hardly meant are refused or warned of by name."""
# ruff: noqa: E501  (a message and its text stay on one line)

import warnings

import pytest

from palpate.base.errors import PalpateWarning, SceneError
from palpate.scene import Scene
from palpate.scene.rig import build

BALL = "objects: [{name: ball, sphere: {radius: 0.03}}]\n"
CAMERA = "objects: [{name: ball, sphere: {radius: 0.03}}, {name: seen, cloud: {sensor: cam}}]\n"


def warned(text):
    """All warnings of a scene, as one text."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        build(Scene.parse(text, "s.yaml"))
    return "\n".join(str(w.message) for w in found if issubclass(w.category, PalpateWarning))


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("stability: {force_cap: 3000}", "s.yaml:2: stability.force_cap = 3000 N: a hand is not protected above 50 N"),
        ("stability: {force_cap: 120}", "stability.force_cap = 120 N"),
        ("stability: {moment_cap: 40}", "stability.moment_cap = 40 N m"),
        ("stability: {rate_cap: 1.0e9}", "stability.rate_cap = 1e+09 N/s limits nothing: it lets all 3 N come in one"),
        ("stability: {rate_cap: 2.0e4}", "stability.rate_cap = 20000 N/s limits nothing"),
        ("stability: {moment_cap: 0.2, moment_rate_cap: 1000}", "stability.moment_rate_cap = 1000 N m/s limits nothing"),
        ("guidance: [{margin: 3 m around: ball}]", "guidance[0].role.margin = 3 m: fixture 'ball' is as wide as a body"),
        ("guidance: [{margin: 50 cm around: ball}]", "guidance[0].role.margin = 0.5 m"),
        ("guidance: [keep-rcm]", "guidance[0]: fixture 'keep-rcm' has no effect on psm_lnd"),
    ],
)  # fmt: skip
def test_doubtful_value_is_warned_of_by_name(more, words):
    assert words in warned(BALL + more)


@pytest.mark.parametrize(
    "more",
    ["", "stability: {force_cap: 6, rate_cap: 300, moment_cap: 0.3}", "guidance: [{margin: 3 mm around: ball}]",
     "places: {entry: [0, 0, 0.1]}\nguidance: [{keep-rcm: entry}]"],
)  # fmt: skip
def test_usual_values_are_not(more):
    assert warned(BALL + more) == ""


@pytest.mark.parametrize(
    ("pose", "sees"),
    [
        ("{xyz: [0, 0, 0.6]}", False),  # looks up, away from the ball
        ("{xyz: [0, 0, 0.6], rpy_deg: [180, 0, 0]}", True),
        ("{xyz: [0, 0, 0.6], rpy_deg: [90, 0, 0]}", False),
        ("{xyz: [0, 0, 6], rpy_deg: [180, 0, 0]}", False),  # beyond the range of 4 m
        ("{xyz: [1.5, 0, 0.6], rpy_deg: [180, 0, 0]}", False),
        ("{xyz: [0.6, 0, 0], rpy_deg: [0, -90, 0]}", True),
    ],
)
def test_camera_that_looks_away_is_warned_of(pose, sees):
    words = warned(CAMERA + f"sensors: {{cam: {{simulated: {{}}, pose: {pose}}}}}")
    assert ("sensor 'cam' sees none of the real objects: ball" in words) is not sees


@pytest.mark.parametrize(
    ("shape", "what"),
    [("sphere: {radius: 30}", "objects[0].sphere: 'b' is 60 m wide"),
     ("sphere: {radius: 12}", "objects[0].sphere: 'b' is 24 m wide"),
     ("box: {size: [40, 5, 5]}", "objects[0].box: 'b' is 40 m wide"),
     ("capsule: {radius: 8, length: 40}", "objects[0].capsule: 'b' is 56 m wide")],
)  # fmt: skip
def test_millimetres_in_a_scene_are_named_where_they_stand(shape, what):
    with pytest.raises(SceneError) as error:
        build(Scene.parse(f"objects: [{{name: b, {shape}}}]", "s.yaml"))
    assert what in str(error.value)
    assert "s.yaml:1" in str(error.value)
    assert "write 30 mm or 0.03 instead of 30" in error.value.mend


def test_an_object_of_some_metres_is_doubted():
    words = warned("objects: [{name: b, sphere: {radius: 3}}]\n"
                   "operator: {palpate: {hover: 0.02}}\n")  # fmt: skip
    assert "objects[0].sphere: 'b' is 6 m wide" in words


@pytest.mark.parametrize("young", [6, 25, 400])
def test_youngs_modulus_in_kilopascals_is_named(young):
    with pytest.raises(SceneError) as error:
        build(Scene.parse(f"objects: [{{name: b, sphere: {{radius: 0.03}}, tissue: {{young: {young}, fixed: [{{at: [0, 0, 0], radius: 0.02}}]}}}}]", "s.yaml"))  # fmt: skip
    assert f"objects[0].tissue.young = {young} Pa: 'b' is too soft" in str(error.value)
    assert "write young: 6 kPa" in error.value.mend


def test_a_stiffness_that_no_object_returns_is_named():
    with pytest.raises(SceneError, match=r"objects\[0\].stiffness = 0.4 N/m: 'ball' is too soft"):
        build(Scene.parse("objects: [{name: ball, sphere: {radius: 0.03}, stiffness: 0.4}]", "s.yaml"))


def test_pressures_have_units():
    tissue = Scene.parse("objects: [{name: b, sphere: {radius: 0.03}, tissue: {young: 6 kPa}}]").objects[0].tissue
    assert tissue.young == 6000.0


def test_path_and_palpate_together_are_refused():
    with pytest.raises(SceneError, match="path and palpate are given: the hand follows one of them"):
        Scene.parse(BALL + "operator: {path: [{t: 0, xyz: [0, 0, 0.1]}], palpate: {force: 1}}")


def test_the_resolved_scene_of_a_path_can_be_read_again():
    rig = build(Scene.parse(BALL + "operator: {path: [{t: 0, xyz: [0, 0, 0.1]}, {t: 1, xyz: [0, 0, 0.09]}]}"))
    assert Scene.parse(rig.resolved_yaml()).operator.path == rig.scene.operator.path


@pytest.mark.parametrize(
    ("text", "advice"),
    [
        ("folow: p.csv", "did you mean 'guidance: [follow: suture-path.csv]'?"),
        ("margn: 3 mm", "did you mean 'guidance: [margin: 3 mm around: vessel.stl]'?"),
        ("guidance: [{folow: p.csv}]", "did you mean 'follow'? Write e.g. follow: suture-path.csv"),
        ("guidance: [{stay_in: ball}]", "did you mean 'stay-in'? Write e.g. stay-in: cone(entry, target)"),
        ("guidance: [keep-rmc]", "did you mean 'keep-rcm'? Write e.g. keep-rcm"),
        ("stabilty: {}", "did you mean 'stability'?"),
        ("forse_cap: 3", "did you mean 'stability.force_cap'?"),
    ],
)
def test_a_mistyped_key_gets_the_nearest_word(text, advice):
    with pytest.raises(SceneError) as error:
        Scene.parse(BALL + text, "s.yaml")
    assert advice in str(error.value)
    assert "'guidance[0].geometry' is missing" not in str(error.value)
