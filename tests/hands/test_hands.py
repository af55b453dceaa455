"""Hand models: presets, random samples, files, and their use in scenes."""

import numpy as np
import pytest
import yaml

from palpate import _core
from palpate.arm import hands
from palpate.base.errors import RecordingError, SceneError
from palpate.scene import Scene, rig

ONE = "objects: [{shape: organ, triangles: 2000}]\n"


def test_presets_are_ordered_by_stiffness_and_name_their_sources():
    assert list(hands.PRESETS) == ["relaxed", "light", "normal", "firm", "rigid"]
    for key in ("mass", "damping", "stiffness"):
        values = [getattr(hand, key) for hand in hands.PRESETS.values()]
        assert values == sorted(values)
        assert len(set(values)) == 5
    for hand in hands.PRESETS.values():
        assert "sure" in hand.source
        assert any(year in hand.source for year in ("1985", "1997", "2002", "2012"))


def test_preset_normal_is_the_default_of_the_core():
    core, normal = _core.HandOptions(), hands.PRESETS["normal"]
    assert (normal.mass, normal.damping, normal.stiffness) == (core.mass, core.damping, core.stiffness)


def test_sampled_hands_scatter_by_the_factor_around_the_preset():
    rng = np.random.default_rng(3)
    drawn = [hands.PRESETS["light"].drawn(rng, 2.0) for _ in range(4000)]
    ratio = np.array([[h.mass / 0.10, h.damping / 5.0, h.stiffness / 120.0] for h in drawn])
    assert np.median(ratio, axis=0) == pytest.approx(1.0, abs=0.03)
    inside = np.mean((ratio > 0.5) & (ratio < 2.0), axis=0)
    assert inside == pytest.approx(0.95, abs=0.015)  # three standard errors of 4000 draws are 0.010


def test_hand_survives_a_round_trip_through_a_file(tmp_path):
    hand = hands.Hand("mine", 0.2, 7.5, 210.0, source="measured")
    hand.save(tmp_path / "mine.yaml", {"coherence": 0.97})
    assert hands.load(tmp_path / "mine.yaml") == hand
    assert yaml.safe_load((tmp_path / "mine.yaml").read_text())["notes"] == {"coherence": 0.97}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("kind: gravity\n", "its kind is 'gravity'"),
        ("kind: hand\nmass: 0.1\ndamping: 3\n", "'stiffness' is missing"),
        ("kind: hand\nmass: -1\ndamping: 3\nstiffness: 5\n", "mass must be a number above 0. Got: -1"),
        ("kind: hand\nmass: .nan\ndamping: 3\nstiffness: 5\n", "mass must be a number above 0. Got: nan"),
        ("3\n", "does not describe a hand"),
        ("a: [", "the hand cannot be read"),
    ],
)
def test_invalid_hand_file_is_reported(tmp_path, text, message):
    (tmp_path / "h.yaml").write_text(text)
    with pytest.raises(RecordingError, match=r"h\.yaml") as caught:
        hands.load(tmp_path / "h.yaml")
    assert message in str(caught.value)


# ---------------------------------------------------------------- in scenes
@pytest.mark.parametrize("name", list(hands.PRESETS))
def test_scene_uses_a_preset(name):
    scene = Scene.parse(ONE + f"operator: {{hand: {name}}}")
    o, hand = rig.build(scene).options().hand, hands.PRESETS[name]
    assert (o.mass, o.damping, o.stiffness) == (hand.mass, hand.damping, hand.stiffness)


def test_values_of_the_scene_take_precedence():
    o = Scene.parse(ONE + "operator: {hand: firm, damping: 3}").operator
    assert (o.mass, o.damping, o.stiffness) == (0.30, 3.0, 600.0)


def test_hand_file_is_found_next_to_the_scene_and_not_needed_by_the_record(tmp_path):
    hands.Hand("mine", 0.2, 7.5, 210.0).save(tmp_path / "mine.yaml")
    (tmp_path / "s.yaml").write_text(ONE + "operator: {hand: mine.yaml}")
    scene = Scene.load(tmp_path / "s.yaml")
    assert (scene.operator.mass, scene.operator.damping, scene.operator.stiffness) == (0.2, 7.5, 210.0)
    assert Scene.parse(scene.to_yaml(), "elsewhere/s.yaml").operator == scene.operator


@pytest.mark.parametrize(
    ("hand", "message"),
    [
        ("gentle", "s.yaml:2: operator: there is no hand 'gentle'\n"),
        ("gentle", "\n  mend: use one of relaxed, light, normal, firm, rigid"),
        ("none.yaml", "s.yaml:2: operator: the hand cannot be read: none.yaml, No such file"),
        ("3", "s.yaml:2: operator.hand must be text. Got: 3"),
    ],
)
def test_missing_hand_is_reported(hand, message):
    with pytest.raises(SceneError) as caught:
        Scene.parse(ONE + f"operator: {{hand: {hand}}}", "s.yaml")
    assert message in str(caught.value)
