"""The section `pairs`: what each pair takes from the scene, and refused values."""

from pathlib import Path

import pytest

from palpate.base.errors import SceneError
from palpate.scene import Scene
from palpate.scene.rig import build
from palpate.scene.together import build_pairs

ORGAN = "objects: [{shape: organ, triangles: 2000, stiffness: 300}]\n"
RIGHT = "{follower: {base: {xyz: [-0.12, -0.06, 0.155], rpy_deg: [0, 0, 205]}}}"
LEADER = "{model: mtm_left, base: {xyz: [-0.3, 0.2, 0.2]}}"
LEFT = f"{{leader: {LEADER}, follower: {{base: {{xyz: [0.06, -0.06, 0.155], rpy_deg: [0, 0, 155]}}}}}}"

MANY = ", ".join(f"p{i}: {{}}" for i in range(9))


def scene(text: str) -> Scene:
    return Scene.parse(ORGAN + text, "two.yaml")


def refused(text: str) -> str:
    with pytest.raises(SceneError) as caught:
        build_pairs(scene(text))
    return str(caught.value)


def test_a_pair_overrides_the_scene_key_by_key():
    both = scene(
        f"mapping: {{scale: 0.4, force_scale: 0.8}}\n"
        f"pairs:\n  right: {{arms: {RIGHT}, mapping: {{scale: 0.2}}}}\n  left: {{arms: {LEFT}}}\n"
    )
    right, left = both.pair("right"), both.pair("left")
    assert (right.mapping.scale, right.mapping.force_scale) == (0.2, 0.8)
    assert (left.mapping.scale, left.arms.leader.model) == (0.4, "mtm_left")
    assert right.pairs == {}
    assert right.objects == both.objects


def test_a_scene_of_one_pair_does_not_mention_pairs():
    one = scene("mapping: {scale: 0.4}\n")
    assert "pairs" not in one.to_yaml()
    assert "instruments" not in one.to_yaml()
    assert "pairs" not in build(one).resolved_yaml()
    assert list(one.each_pair()) == [""]


def test_pairs_survive_yaml():
    pairs = f"pairs:\n  right: {{arms: {RIGHT}, mapping: {{scale: 2}}}}\n  left: {{arms: {LEFT}}}\n"
    both = scene("mapping: {scale: 4}\n" + pairs)
    again = Scene.parse(both.to_yaml())
    for name, cap in (("right", 70.0), ("left", 190.0)):  # 0.2 m/s times the felt stiffness less 250 N/m
        assert both.pair(name).stability.rate_cap == pytest.approx(cap)
        assert again.pair(name).model_dump() == both.pair(name).model_dump()


def test_messages_about_a_pair_name_its_line():
    text = "pairs:\n  right:\n    operator:\n      palpate: {force: 9}\n"
    assert "two.yaml:5" in refused(text)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("pairs: {Right: {}}", "cannot name a pair"),
        ("pairs: {a/b: {}}", "cannot name a pair"),
        ("pairs: {right: {mappings: {}}}", "mapping"),
        (
            "pairs: {right: {arms: {leader: {driver: loop}}}, left: {arms: {leader: {driver: loop}}}}",
            "leader driver 'loop'",
        ),
        (
            "pairs: {a: {devices: {leader: MTMR, follower: PSM1}}, b: {devices: {leader: MTML, follower: PSM1}}}",
            "follower 'PSM1'",
        ),
        (f"pairs: {{right: {{arms: {RIGHT}}}, left: {{arms: {RIGHT}}}}}", "in each other's place"),
        (f"pairs: {{right: {{arms: {RIGHT}}}, left: {{}}}}", "in each other's place"),
        (f"pairs: {{{MANY}}}", "at most 8"),
    ],
)
def test_refused(text: str, words: str):
    if "place" in words:
        text = text.replace("left: {}", f"left: {{arms: {RIGHT}}}")
    with pytest.raises(SceneError) as caught:
        build_pairs(scene(text + "\n"))
    assert words in str(caught.value)


def test_instruments_that_overlap_at_the_start_are_refused():
    start = "operator: {path: [{t: 0, xyz: [0, 0, 0.07]}]}"
    text = f"pairs: {{right: {{arms: {RIGHT}, {start}}}, left: {{arms: {LEFT}, {start}}}}}\n"
    message = refused(text)
    assert "overlap by" in message
    assert "pairs.left.arms.follower.base" in message


def test_commands_of_one_pair_ask_which():
    with pytest.raises(SceneError, match="several pairs: right, left"):
        build(Scene.load("two_hands"))
    with pytest.raises(SceneError, match="there is no pair 'middle'"):
        Scene.load("two_hands").pair("middle")


def test_pairs_share_surfaces_and_snapshot():
    rigs = list(build_pairs(Scene.load(Path("two_hands"))).values())
    assert rigs[0].snapshot is rigs[1].snapshot
    assert rigs[0].surfaces[0].body is rigs[1].surfaces[0].body
