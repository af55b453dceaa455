"""The list `guidance` of scenes and sessions: parsing, writing, attachment, edits, and mistakes with their line."""

import numpy as np
import pytest

import palpate
from palpate.base.errors import SceneError
from palpate.scene import Scene
from palpate.scene.rig import build

SCENE = """
objects: [{sphere: {radius: 0.03}, name: liver, motion: {velocity: [0.01, 0, 0]}}]
places: {entry: [0, 0, 0.2], target: [0, 0, 0.03]}
guidance:
  - margin: 3 mm around: liver
  - stay-in: cone(entry, target)
  - keep-rcm
  - {geometry: {sphere: {radius: 0.1}}, role: keep-in, frame: liver}
"""
ATTACHED = """
objects: [{sphere: {radius: 0.03}}]
guidance: [{name: ahead, geometry: {point: {at: [0, 0.01, 0]}}, role: guide, frame: FRAME}]
operator: {path: [{t: 0, xyz: [0, 0, 0.05]}, {t: 1, xyz: [0.02, 0, 0.05]}]}
"""


def test_scene_attaches_fixtures_to_its_tool_and_to_a_live_camera_frame():
    session = palpate.Session(Scene.parse(ATTACHED.replace("FRAME", "tool")))
    session.step(600)
    assert session.step().tick["guidance_gap"] == pytest.approx(-0.01, abs=1e-3)
    session = palpate.Session(Scene.parse(ATTACHED.replace("FRAME", "camera")))
    X_WC = np.eye(4)
    X_WC[:3, 3] = [0, 0.02, 0.05]
    session.frames["camera"].set(X_WC)
    goal = np.array(session.step().tick["p_WT_goal"])
    assert session.latest()["guidance_gap"] == pytest.approx(-np.linalg.norm(goal - [0, 0.03, 0.05]), abs=1e-6)


def test_fixtures_of_a_scene_survive_a_round_trip():
    scene = Scene.parse(SCENE)
    assert [f.name for f in scene.guidance] == ["liver", "cone", "keep-rcm", "keep-in"]
    assert Scene.parse(scene.to_yaml()).guidance == scene.guidance
    rig = build(scene)
    assert len(rig.fixtures) == 4
    np.testing.assert_allclose(rig.context.place("rcm", np.eye(4)), rig.arms.X_WB[:3, 3])
    assert Scene.parse(rig.resolved_yaml(absolute=True)).guidance == scene.guidance


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("keep-rcm\n", "keep-out\n", r"scene.yaml:7: guidance\[2\]: 'keep-out' is not a fixture"),
        ("3 mm", "3 mn", r"scene.yaml:5: guidance\[0\].role.margin must be a number. Got: '3 mn'"),
        ("radius: 0.1}", "radius: -0.1}", r"scene.yaml:8: guidance\[3\].geometry.sphere.radius must be greater than 0"),
        ("radius: 0.1}", "radios: 0.1}", r"(?s)unknown key .*radios.*did you mean 'radius'"),
        (
            "role: keep-in",
            "role: orient",
            r"scene.yaml:8: fixture 'orient': role orient with target axis needs a geometry",
        ),
        ("role: keep-in", "role: keepin", r"guidance\[3\].role.name must be 'guide', 'forbid'"),
        ("around: liver", "around: spleen", r"scene.yaml:5: fixture 'spleen': there is no object 'spleen'"),
        ("frame: liver", "frame: spleen", r"scene.yaml:8: fixture 'keep-in': there is no frame 'spleen'"),
        ("(entry, target)", "(entry, entry)", r"scene.yaml:6: fixture 'cone': a cone needs a finite apex"),
    ],
)
def test_mistake_in_a_scene_is_reported_with_its_line(old, new, message):
    with pytest.raises(SceneError, match=message):
        build(Scene.parse(SCENE.replace(old, new)))


def test_duplicate_names_are_rejected_and_missing_names_numbered():
    both = "  - {geometry: {sphere: {radius: 0.1}}, role: keep-in, frame: liver}\n"
    assert [f.name for f in Scene.parse(SCENE + both).guidance][-2:] == ["keep-in", "keep-in-5"]
    with pytest.raises(SceneError, match="two fixtures are named 'cone'"):
        Scene.parse(SCENE + "  - stay-in: cone(entry, target)\n")


def test_session_explains_the_guidance_force_and_accepts_new_fixtures():
    text = """
objects: [{sphere: {radius: 0.03}}]
guidance: [{name: line, geometry: {line: {start: [0, 0.01, 0.05], end: [0.03, 0.01, 0.05]}}, role: guide}]
operator: {path: [{t: 0, xyz: [0, 0, 0.05]}, {t: 1, xyz: [0.02, 0, 0.05]}]}
"""
    session = palpate.Session(Scene.parse(text))
    tick = session.step(300).tick
    pulled = np.array(tick["F_guidance_W"])
    assert pulled[1] > 0.5, "the force points towards the line"
    message = session.why()
    assert "guidance applies" in message
    assert "most of it from line" in message
    assert "at 400 N/m" in message
    session.fixtures = [f.model_copy(update={"enabled": False}) for f in session.fixtures]
    after = session.step(1).tick
    assert np.linalg.norm(np.array(after["F_guidance_W"]) - pulled) < 0.1, "no step"
    assert np.linalg.norm(session.step(600).tick["F_guidance_W"]) < 1e-6
    assert session.why() == "no fixture applies a force"
