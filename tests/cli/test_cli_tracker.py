"""`palpate tracker simulate`: its poses reach a client in another process; mistakes are explained."""

import re
import time

import numpy as np
import pytest

from palpate.scene import Scene
from palpate.scene.rig import build

pytest.importorskip("pyigtl", reason="OpenIGTLink needs the extra tracking")
from palpate.sensing.trackers.openigtlink import OpenIGTLinkTracker

SCENE = """\
objects: [{name: ball, sphere: {radius: 0.03}}]
frames: [{child: patient, tracker: polaris, tool: PatientToTracker, pose: {xyz: [0, 0, 1.2]}}]
trackers: {polaris: {simulated: {noise_mm: 0.1}}}
"""


def test_client_in_another_process_sees_the_simulated_tool(spawn, tmp_path):
    (tmp_path / "t.yaml").write_text(SCENE)
    server = spawn("tracker", "simulate", "t.yaml", "--port", "0", "--duration", "60")
    line = server.stdout.readline()
    assert "PatientToTracker" in line
    tracker = OpenIGTLinkTracker(re.search(r"127\.0\.0\.1:\d+", line)[0])
    end, found = time.monotonic() + 30.0, []
    while len(found) < 3:
        assert time.monotonic() < end, "nothing has arrived"
        found += tracker.poll(0.0)
        time.sleep(0.01)
    tracker.close()
    truth = build(Scene.parse(SCENE)).frames.edge("patient").X
    assert all(one.tool == "PatientToTracker" and one.valid for one in found)
    assert all(np.abs(one.X - truth).max() < 0.02 for one in found)
    assert [one.t for one in found] == sorted(one.t for one in found)
    assert abs(found[-1].t - time.time()) < 60.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            lambda s: s.replace("polaris: {simulated: {noise_mm: 0.1}}", "polaris: {openigtlink: 127.0.0.1:1}"),
            "has 0 sim",
        ),
        (lambda s: s.replace("trackers: {", "trackers: {second: {simulated: {}}, "), "has 2 simulated trackers"),
    ],
)
def test_scene_without_one_simulated_tracker_is_explained(palpate, tmp_path, change, words):
    (tmp_path / "t.yaml").write_text(change(SCENE))
    done = palpate("tracker", "simulate", "t.yaml", "--port", "0")
    assert done.code == 2
    assert words in done.err
