"""Objects and arms of a scene are placed by its frames; wrong frames are refused with their line."""

import numpy as np
import pytest
import yaml

from palpate.base.errors import SceneError
from palpate.scene import Scene, placing
from palpate.scene.rig import build

HEAD = """\
frames:
  - {child: table, pose: {xyz: [100, 0, 20], rpy_deg: [0, 0, 90], unit: mm}}
  - {parent: table, child: patient, pose: {xyz: [0.05, 0, 0]}, sigma_mm: 0.5, sigma_deg: 0.1}
"""
OBJECTS = "objects:\n  - {name: ball, sphere: {radius: 0.03}, frame: patient, pose: {xyz: [0.01, 0, 0]}}\n"
TRACKED = HEAD.replace("sigma_mm", "tracker: t, sigma_mm") + "trackers: {t: {simulated: {}}}\n"


def test_an_object_stands_where_the_product_of_its_frames_puts_it():
    (X,) = placing.object_poses(Scene.parse(HEAD + OBJECTS))
    # The table is turned by 90 deg about z: 50 mm and 10 mm along its x axis lie along y of the world.
    assert pytest.approx(np.array([[0, -1, 0, 0.1], [1, 0, 0, 0.06], [0, 0, 1, 0.02], [0, 0, 0, 1]]), abs=1e-12) == X
    assert pytest.approx(X) == build(Scene.parse(HEAD + OBJECTS)).snapshot.objects[0].X_WO


@pytest.mark.parametrize("side", ["leader", "follower"])
def test_an_arm_stands_on_its_frame(side):
    base = {"xyz": [0.0, 0.0, 0.1], "rpy_deg": [0, 0, 30]}
    scene = Scene.parse(HEAD + OBJECTS + yaml.safe_dump({"arms": {side: {"frame": "table", "base": base}}}))
    assert placing.base_pose(scene, side)[:3, 3] == pytest.approx([0.1, 0.0, 0.12])
    bare = Scene.parse(HEAD + OBJECTS + yaml.safe_dump({"arms": {side: {"frame": "table"}}}))
    assert placing.base_pose(bare, side)[:3, 3] == pytest.approx([0.1, 0.0, 0.02])
    assert placing.base_pose(Scene.parse(HEAD + OBJECTS), side) is None


def test_a_record_holds_the_poses_of_files(tmp_path):
    (tmp_path / "r.yaml").write_text("X: [[1, 0, 0, 0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\nsource: points\n")
    (tmp_path / "s.yaml").write_text("frames: [{child: patient, file: r.yaml, sigma_mm: 1}]\n" + OBJECTS)
    rig = build(Scene.load(tmp_path / "s.yaml"))
    (tmp_path / "r.yaml").unlink()
    again = build(Scene.parse(rig.resolved_yaml()))
    assert pytest.approx(rig.snapshot.objects[0].X_WO, abs=1e-15) == again.snapshot.objects[0].X_WO
    assert pytest.approx(rig.arms.X_WB, abs=1e-9) == again.arms.X_WB
    assert placing.graph(again.scene).edge("patient").source == "points"


def test_fixtures_may_name_the_frames():
    frames = build(Scene.parse(HEAD + OBJECTS)).context.frames
    assert frames["table"].at(0.0)[0][:3, 3] == pytest.approx([0.1, 0.0, 0.02])


def test_a_tracked_object_names_its_tracker():
    scene = Scene.parse(TRACKED + OBJECTS)
    assert placing.tracked(scene, placing.graph(scene)) == {"ball": "t"}


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        (HEAD + OBJECTS.replace("patient", "patent"), 5, "did you mean 'patient'"),
        (HEAD.replace("parent: table", "parent: tabel") + OBJECTS, 3, "no parent 'tabel'"),
        (HEAD.replace("parent: table, child: patient", "child: table") + OBJECTS, 3, "placed twice"),
        (HEAD.replace("child: patient", "child: ball") + OBJECTS, 0, "name of the world, an arm"),
        (HEAD.replace(", unit: mm", "") + OBJECTS, 2, "give unit: mm"),
        (HEAD.replace("pose: {xyz: [0.05, 0, 0]}", "file: none.yaml") + OBJECTS, 3, "not found"),
        (HEAD.replace("sigma_mm", "tracker: t, sigma_mm") + OBJECTS, 0, "no tracker 't' | trackers: none"),
        (TRACKED + OBJECTS.replace("pose:", "motion: {amplitude: [0, 0, 0.1]}, pose:"), 6, "follows the tracked frame"),
        (TRACKED + OBJECTS + "arms: {follower: {frame: patient}}\n", 7, "an arm's base does not"),
        (TRACKED + OBJECTS + "arms: {follower: {frame: patient}}\n", 7, "palpate frames SCENE --of patient"),
        (HEAD + OBJECTS + "trackers: {t: {}}\n", 6, "no source is given"),
        (HEAD + OBJECTS + "trackers: {t: {openigtlink: here}}\n", 6, "is not an address"),
    ],
)
def test_wrong_frames_are_refused_with_their_line(text, line, message):
    with pytest.raises(SceneError) as error:
        build(Scene.parse(text))
    for part in message.split(" | "):
        assert part in str(error.value)
    assert not line or f"scene.yaml:{line}:" in str(error.value)
