"""The laws of the mapping on devices: one word in the scene, no pressing by itself, a ledger that closes."""

import drivers
import numpy as np
import pytest
from test_haptics import CAP, RATE_CAP, K, pose, scene

import palpate
from palpate.base.errors import SceneError
from palpate.record.reader import Record
from palpate.scene import MappingSection
from palpate.session import Session

LOOP = {"leader": {"driver": "loop"}}
SMALL = {"workspace": [0.04, 0.04, 0.04], "centre": [0, 0, 0]}


def stepped(folder, law, motion, seconds=4.0, **changes):
    """The record of a motion t -> p (3,), with a clutch button if the motion gives a pair."""
    mapping = {"law": law, "scale": 1.0, **SMALL}
    with palpate.Haptics(scene(arms=LOOP, mapping=mapping, **changes), record=folder) as haptics:
        felt = []
        for i in range(int(1000 * seconds)):
            p, buttons = motion(1e-3 * i)
            felt.append(haptics.step(1e-3 * i, pose(*p), buttons=buttons))
        summary = haptics.close()
    return np.array(felt), Record.open(summary.record).ticks


def test_a_hand_at_the_rim_reaches_the_surface_but_is_not_pressed_into_it(tmp_path):
    """Nine millimetres of hand motion cannot reach a surface 10 mm away: rate control does, and stops at contact."""

    def hold(t):
        return (0.0, 0.0, -0.019 * min(1.0, t)), 0

    start = {"t": 0.0, "xyz": [0.0, 0.0, 0.042]}
    far = {"operator": {"path": [start, {**start, "t": 1.0}]}}  # 40 mm away: the hand has 19 mm
    felt, ticks = stepped(tmp_path, "rate", hold, 3.0, **far)
    assert ticks["p_WT_goal"][-1, 2] == pytest.approx(0.002, abs=2e-4)
    assert np.abs(felt).max() < K * 2e-4
    felt, ticks = stepped(tmp_path, "indexed", hold, 3.0, **far)
    assert ticks["p_WT_goal"][-1, 2] == pytest.approx(0.042 - 0.019, abs=1e-4)


@pytest.mark.parametrize("law", ["rate", "drift"])
def test_the_ledger_closes_and_no_energy_is_generated(tmp_path, law):
    """Over a ball, through the rim and the clutch; port + withheld = spring + damping + mapping."""
    ball = {"sphere": {"radius": 0.02}, "pose": {"xyz": [0, 0, -0.035]}}  # 25 mm below the tool

    def wander(t):
        p = np.array([0.006 * np.sin(2.1 * t), 0.006 * np.sin(3.4 * t), 0.0095 * (np.cos(2.3 * t) - 1.0)])
        return p, int(t % 1.7 > 1.6)

    felt, ticks = stepped(tmp_path, law, wander, 8.0, objects=[{"name": "one", "stiffness": K, "damping": 0.0, **ball}])
    assert np.linalg.norm(felt[:, :3], axis=1).max() > 0.5
    assert np.linalg.norm(felt[:, :3], axis=1).max() <= CAP * (1 + 1e-9)
    rise = np.diff(np.linalg.norm(felt[:, :3], axis=1)) * 1e3
    assert rise.max() <= RATE_CAP * (1 + 1e-6)
    goal = np.linalg.norm(np.diff(ticks["p_WT_goal"], axis=0), axis=1) * 1e3
    speed = np.linalg.norm(np.diff(ticks["p_LH"], axis=0), axis=1) * 1e3
    assert (goal - speed).max() <= (0.05 if law == "rate" else 0.2 * 1.05 * speed.max()) + 1e-6
    withheld = sum(ticks[f"energy_{name}"] for name in ("port", "cut", "passivity", "low_pass", "coupling"))
    kept = sum(ticks[f"energy_{name}"] for name in ("spring", "damping", "mapping"))
    assert np.abs(withheld - kept).max() < 2e-3 * max(1.0, np.abs(ticks["energy_port"]).max())
    assert ticks["energy_port"].min() > -1e-4
    assert (np.diff(ticks["energy_mapping"]) >= 0.0).all()


def test_scaled_covers_the_objects_unless_the_scene_gives_a_scale():
    """A ball of 60 mm and a workspace of 100 x 100 x 40 mm: the shortest axis decides, 60 / 40."""
    ball = {"name": "one", "sphere": {"radius": 0.03}, "stiffness": K}
    size = {"law": "scaled", "workspace": [0.1, 0.1, 0.04]}
    with palpate.Haptics(scene(ball, arms=LOOP, mapping=size)) as haptics:
        assert haptics.session.rig.scene.mapping.scale == pytest.approx(1.5, rel=0.01)
    with palpate.Haptics(scene(ball, arms=LOOP, mapping={**size, "scale": 0.7})) as haptics:
        assert haptics.session.rig.scene.mapping.scale == 0.7
    with pytest.raises(SceneError, match=r"the objects need 6.* times the workspace, at most 5[\s\S]*mend: use rate"):
        palpate.Haptics(scene(ball, arms=LOOP, mapping={"law": "scaled", "workspace": [0.1, 0.1, 0.01]}))
    turned = MappingSection(law="scaled", workspace=(0.1, 0.2, 0.4))
    R = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])  # x of the device is y of the world
    assert turned.covering([0, 0, 0], [0.1, 0.3, 0.1], R).scale == pytest.approx(3.0)


def test_workspace_is_that_of_the_driver_and_the_scene_takes_precedence():
    session = Session(scene(mapping="drift"), driver=drivers.Still())
    assert session.rig.scene.mapping.workspace == drivers.Still.workspace
    assert session.rig.scene.mapping.centre == (0.0, 0.0, 0.0)
    session = Session(scene(mapping={"law": "drift", "workspace": [0.3, 0.2, 0.1]}), driver=drivers.Still())
    assert session.rig.scene.mapping.workspace == (0.3, 0.2, 0.1)
    assert session.rig.options().mapping.recentring.centre is None  # the first position


def test_a_law_without_workspace_or_device_is_refused_with_the_line():
    with pytest.raises(SceneError, match=r"mapping law rate needs the workspace[\s\S]*mend: write mapping: \{law"):
        palpate.Haptics(scene(mapping="rate"))
    text = "objects: [{sphere: {radius: 0.03}}]\n\nmapping: drift\n"
    with pytest.raises(SceneError, match=r"scene.yaml:3: mapping law drift is for a device[\s\S]*mend: use indexed"):
        palpate.Session(palpate.Scene.parse(text))
    with pytest.raises(SceneError, match=r"mapping.law must be 'indexed', 'scaled', 'rate' or 'drift'"):
        palpate.Scene.parse(text.replace("drift", "drifting"))


def test_the_word_of_a_record_gives_the_same_mapping(tmp_path):
    session = Session(scene(mapping="rate"), driver=drivers.Still())
    again = palpate.Scene.parse(session.rig.resolved_yaml())
    assert again.mapping == session.rig.scene.mapping
