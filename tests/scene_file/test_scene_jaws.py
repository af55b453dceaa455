"""Scene keys of gripper and jaws: they reach the core, and invalid ones are refused with the mend."""

import numpy as np
import pytest

from palpate.base.errors import SceneError
from palpate.scene import Scene
from palpate.scene.rig import build

PLANE = "objects: [{name: wall, plane: {}}]\n"
PATH = "path: [{t: 0, xyz: [0, 0, 0.02]}]"


def rig(text):
    return build(Scene.parse(PLANE + text))


def test_keys_reach_the_core():
    made = rig(
        "arms: {leader: {gripper: {closed: 5 deg, open: 0.9}}, follower: {jaw: {start: 1.2, closed: -0.1, open: 1.3, "
        f"rate: 3}}}}}}\noperator: {{{PATH}, grip: [{{t: 0, angle: 0.9}}, {{t: 1, angle: 0}}]}}"
    )
    m = made.options().mapping
    assert (m.jaw_start, m.jaw_min, m.jaw_max, m.jaw_rate) == (1.2, -0.1, 1.3, 3.0)
    assert (m.gripper_min, m.gripper_max) == (np.radians(5.0), 0.9)
    assert [made.path.core(made.scene.operator.grip).at(t)[2] for t in (0.0, 0.5, 1.0)] == pytest.approx([0.9, 0.45, 0])


BAD = {
    "jaw beyond its limits": ("arms: {follower: {jaw: {open: 1.5}}}", "open: 1.5 rad is outside the jaws' limits"),
    "closed above open": ("arms: {follower: {jaw: {closed: 0.5, open: 0.4}}}", "not below open"),
    "rate zero": ("arms: {follower: {jaw: {rate: 0}}}", "rate"),
    "follower without jaws": ("arms: {follower: {model: six_axis, jaw: {open: 0.5}}}", "six_axis has no jaws"),
    "gripper without motor": ("arms: {leader: {gripper: {torque: 0.1}}}", "gripper of mtm_right has no motor"),
    "gripper the wrong way": ("arms: {leader: {gripper: {closed: 1, open: 0.5}}}", "not below open"),
    "times fall": (f"operator: {{{PATH}, grip: [{{t: 1, angle: 0}}, {{t: 0, angle: 1}}]}}", "times must rise"),
    "empty program": (f"operator: {{{PATH}, grip: []}}", "grip is empty"),
    "not a number": (f"operator: {{{PATH}, grip: [{{t: 0, angle: .nan}}]}}", "angle"),
    "impossible angle": (f"operator: {{{PATH}, grip: [{{t: 0, angle: 4}}]}}", "angle"),
}


@pytest.mark.parametrize(("text", "words"), BAD.values(), ids=BAD.keys())
def test_invalid_values_are_refused_with_words(text, words):
    with pytest.raises(SceneError, match=words):
        rig(text)
