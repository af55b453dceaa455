"""Rigid bodies on a device: the hand feels them, moves them, and a task is judged."""

from __future__ import annotations

import json
import threading

import numpy as np
import pytest

pytest.importorskip("mujoco")

import palpate
from palpate.cli import main
from palpate.scene import Scene, held
from palpate.scene.rig import build
from palpate.session import Session
from palpate.world.bodies.engine import World

BLOCK = 0.02  # [m]
SCENE = {
    "objects": [{"name": "table", "plane": {"size": 0.2}, "pose": {"xyz": [0, 0, -0.02]}}],
    "bodies": [
        {"name": "floor", "fixed": True, "parts": [{"box": [0.2, 0.2, 0.01], "pose": {"xyz": [0, 0, -0.005]}}]},
        {"name": "block", "mass": 0.05, "parts": [{"box": [BLOCK] * 3}], "pose": {"xyz": [0, 0, 0.5 * BLOCK]}},
    ],
    "arms": {"follower": {"model": "psm_prograsp", "base": {"xyz": [0, 0, 0.19]}, "jaw": {"start": 0.3}}},
    "mapping": {"scale": 1.0, "align_rate": 0},
    "operator": {"path": [{"t": 0, "xyz": [0, 0, 0.05]}]},
}


def test_a_loop_of_ones_own_feels_a_block_at_its_place():
    felt, X = [], np.eye(4)
    with palpate.Haptics(Scene.model_validate(SCENE), rate=1000, force_cap=3.0) as haptics:
        for k in range(580):
            X[2, 3] = 0.2 - 0.00008 * k  # 8 cm/s, 46 mm down
            felt.append(haptics.step(0.001 * k, X)[2])
        assert np.abs(felt[60:130]).max() < 0.01, "in the air nothing is felt, once the virtual tool moves"
        assert felt[-1] > 0.5, "the block carries"
        assert haptics.session.world.states()["poses"][0, 2] == pytest.approx(0.5 * BLOCK, abs=1e-3)
        assert np.array(haptics.session.latest()["p_WT"])[2] < 0.05 - 0.03


def test_an_engine_that_stands_still_lets_go_of_the_hand():
    """As one whose thread hangs, or was ended with another pair's session: its last state would push for ever."""
    X = np.eye(4)
    with palpate.Haptics(Scene.model_validate(SCENE), rate=1000, force_cap=3.0) as haptics:
        for k in range(480):
            X[2, 3] = 0.2 - 0.00008 * k
            haptics.step(0.001 * k, X)
        assert np.mean([haptics.step(0.001 * k, X)[2] for k in range(480, 600)]) > 0.5
        haptics.session.world.threaded = True  # its thread was never started
        felt = np.array([haptics.step(0.001 * k, X)[2] for k in range(600, 800)])
        assert felt[40] > 0.5, "a pause of 40 ms is not felt"
        assert not felt[150:].any()
        haptics.session.world.threaded = False
        felt = np.array([haptics.step(0.001 * k, X)[2] for k in range(800, 1000)])
        assert felt[-1] > 0.5, "it is felt again"
        (words,) = haptics.close().faults
    assert "the engine of the bodies stood still for more than 50 ms, once" in words


def test_an_engine_that_stood_still_is_named_in_terminal_json_and_report(tmp_path, monkeypatch, capsys):
    start = World.start

    def start_for_a_while(self):
        start(self)
        threading.Timer(0.4, self.core_bodies.stop).start()

    monkeypatch.setattr(World, "start", start_for_a_while)
    file, out = tmp_path / "block.yaml", tmp_path / "result.json"
    file.write_text(Scene.model_validate(SCENE).with_driver("simulated").to_yaml())
    main(["run", str(file), "--headless", "--duration", "1", "--out", str(tmp_path), "--json", str(out)])
    words = "the engine of the bodies stood still for more than 50 ms, once"
    result = json.loads(out.read_text())
    assert any(words in fault for fault in result["faults"])
    told = capsys.readouterr()
    assert words in " ".join((told.out + told.err).split())
    main(["report", result["record"], "--out", str(tmp_path / "report.html")])
    assert words in " ".join((tmp_path / "report.html").read_text().split())


def test_the_damping_of_a_coupling_is_that_of_the_slowest_loop():
    """On ROS 2 the leader's rate may be below the scene's; its force then comes later, and needs more damping."""
    scene = Scene.model_validate(SCENE)
    slow = scene.model_copy(update={"rates": scene.rates.model_copy(update={"haptic": 125.0})})
    given, stated = held.world({"": build(scene)}, rate=125.0), held.world({"": build(slow)})
    assert given.damping == stated.damping > 1.5 * held.world({"": build(scene)}).damping


def test_a_driver_in_real_time_moves_bodies_and_records_them(tmp_path):
    scene = Scene.model_validate(SCENE).with_driver("simulated")
    session = Session(scene, tmp_path)
    summary = session.run(0.3)
    assert not session.failed, summary.faults
    assert session.world.states()["t"] > 0.1
    assert palpate.Record.open(summary.record).bodies.at(0.2)["block"][2] == pytest.approx(0.5 * BLOCK, abs=1e-3)


def test_a_task_on_a_device_is_judged_and_nobody_else_acts(tmp_path):
    task = {"limit": 0.2, "place": {"bodies": ["block"], "targets": [[0.03, 0, 0.01]]}}
    file = tmp_path / "block.yaml"
    file.write_text(Scene.model_validate(SCENE | {"task": task}).with_driver("simulated").to_yaml())
    out = tmp_path / "result.json"
    main(["run", str(file), "--headless", "--duration", "2", "--out", str(tmp_path), "--json", str(out)])
    result = json.loads(out.read_text())
    assert result["success"] is False
    assert result["time_s"] == pytest.approx(0.2, abs=0.1)
