"""The viewer of several pairs: the same objects once, a gauge and a handle a hand, a warning of close handles."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from two_pairs import TWO

from palpate.scene import Scene
from palpate.session import PairsSession
from palpate.session.rates import LiveRates

pytest.importorskip("viser", reason="the viewer is not installed (extra viewer)")

from palpate.viewer import stage_of
from palpate.viewer.pairs import COLORS, PairsViewer
from palpate.viewer.stage import DeviceMark


@pytest.fixture
def shown():
    session = PairsSession(Scene.parse(TWO))
    session.step(20)
    stages = {name: stage_of(rig, name) for name, rig in session.rigs.items()}
    viewer = PairsViewer(session.pairs, stages, "two", session, session, LiveRates(session.pairs).rows, 5.0, port=0)
    viewer._stop.set()
    viewer._thread.join()  # the test calls each frame itself
    yield session, viewer
    viewer.close()


def test_every_pair_has_its_arms_and_ball_and_the_objects_are_drawn_once(shown):
    _, viewer = shown
    assert len(COLORS) >= 8
    assert [len(drawing._organs) for drawing in viewer.drawings.values()] == [1, 0]
    names = {name for name in viewer._server.scene._handle_from_node_name if name.endswith("/hand")}
    assert names == {"/right/hand", "/left/hand"}


def test_a_dragged_ball_moves_its_own_hand_only(shown):
    session, viewer = shown
    viewer.handles["left"].move(np.array([0.0, 0.0, 0.01]))
    np.testing.assert_array_equal(session.pairs["left"].controls.p_hand_offset_W, [0, 0, 0.01])
    assert not np.any(session.pairs["right"].controls.p_hand_offset_W)
    before = {name: state.tick["p_hand_L"].copy() for name, state in session.states.items()}
    session.step(400)
    after = {name: state.tick["p_hand_L"] for name, state in session.states.items()}
    assert np.linalg.norm(after["left"] - before["left"]) > 0.005
    viewer._frame()
    X_WL = session.rigs["left"].arms.X_WL
    p_W = X_WL[:3, :3] @ after["left"] + X_WL[:3, 3]
    np.testing.assert_allclose(viewer.handles["left"].ball.position, p_W, atol=1e-9)


def test_gauges_name_every_hand_and_warn_of_close_handles(shown):
    _, viewer = shown
    viewer.frames = 0
    viewer._frame()
    text = viewer._gauges._figures.content
    assert 'id="palpate-pair-right"' in text
    assert 'id="palpate-pair-left"' in text
    assert "palpate-handles" in text  # this viewer warns below 5 m
    viewer._gauges._near = 0.08
    viewer.frames = 0
    viewer._frame()
    assert "palpate-handles" not in viewer._gauges._figures.content
    assert "right haptic loop" in viewer._gauges._rates._table.content
    assert "left haptic loop" in viewer._gauges._rates._table.content


def test_gauges_show_the_filter_lag_of_every_hand(shown):
    session, viewer = shown
    ticks = {name: source.latest().copy() for name, source in session.pairs.items()}
    ticks["right"]["lag_ms"], ticks["left"]["lag_ms"] = [0.0, 1.144, 0.0, 0.0], [-0.5, 0.0, 0.0, 8.0]
    viewer._gauges.show(ticks, False)
    text = viewer._gauges._figures.content
    assert 'id="palpate-lag-right">low-pass 1.1 ms<' in text
    assert 'id="palpate-lag-left">virtual coupling -0.5 ms, caps 8 ms<' in text


def test_pause_stops_both_pairs(shown):
    session, viewer = shown
    viewer.run.pause.value = True
    viewer._pause()
    assert all(one.controls.paused for one in session.pairs.values())


def test_replay_shows_all_pairs_of_a_run_at_one_time(tmp_path):
    from palpate.record import Record
    from palpate.report.pairs import pair_records
    from palpate.viewer.pairs_replay import PairsReplayViewer

    summary = PairsSession(Scene.parse(TWO), out=tmp_path).run(0.4)
    records = {name: Record.open(path) for name, path in pair_records(Path(summary.record)).items()}
    viewer = PairsReplayViewer(records, "two", port=0)
    try:
        viewer._stop.set()
        viewer._thread.join()
        viewer.show(0.3)
        for name, record in records.items():
            np.testing.assert_allclose(viewer.drawings[name].p_WT, record.ticks["p_WT"][300], atol=1e-12)
    finally:
        viewer.close()


def test_pedals_act_on_both_hands_and_the_surgeon_sees_both_tools():
    session = PairsSession(Scene.parse("ecm: {}\n" + TWO))
    session.step(20)
    stages = {name: stage_of(rig, name) for name, rig in session.rigs.items()}
    viewer = PairsViewer(session.pairs, stages, "two", session, session, port=0)
    try:
        viewer._stop.set()
        viewer._thread.join()
        box = viewer.pedals.boxes["camera"]
        box.value = True
        viewer.pedals._send(session.console, "camera", None)
        assert {state.session for state in session.step(2).values()} == {"camera"}
        session.console.press("camera", "foot")
        box.value = False
        viewer.pedals._send(session.console, "camera", None)
        assert session.console.pedals["camera"], "the foot still holds it"
        session.console.release("camera", "foot")
        assert {state.session for state in session.step(2).values()} == {"following"}
        session.camera.move_to(session.camera.q + np.array([0.1, 0, 0, 0.2]))
        shown = []
        viewer.drawings["right"].show_ecm = shown.append
        viewer._frame()
        np.testing.assert_array_equal(shown[0], session.camera.q)
        assert len(viewer.surgeon._ticks()) == 2
        np.testing.assert_array_equal(viewer.surgeon._joints(), session.camera.q)
        assert viewer.drawings["left"]._ecm is None, "the endoscope arm is drawn once"
    finally:
        viewer.close()


def test_a_pause_keeps_the_pedals_and_the_drag_of_each_hand(shown):
    session, viewer = shown
    viewer.handles["left"].move(np.array([0.0, 0.0, 0.01]))
    session.console.press("clutch")
    viewer.run.pause.value = True
    viewer._pause()
    for name, one in session.pairs.items():
        assert one.controls.paused
        assert one.controls.clutch
        assert one.controls.p_hand_offset_W[2] == (0.01 if name == "left" else 0.0)


def test_the_rod_is_drawn_where_it_is_live_and_in_a_replay(tmp_path):
    from palpate.record import Record
    from palpate.report.pairs import pair_records
    from palpate.viewer.pairs_replay import PairsReplayViewer

    scene = Scene.load(Path(__file__).resolve().parents[2] / "scenes" / "hand_over.yaml")
    session = PairsSession(scene, out=tmp_path)
    stages = {name: stage_of(rig, name) for name, rig in session.rigs.items()}
    live = PairsViewer(session.pairs, stages, "rod", session, session, port=0)
    live._stop.set()
    live._thread.join()
    rod = live.drawings["right"]._rod
    assert live.drawings["left"]._rod is None, "the rod is drawn once"
    np.testing.assert_allclose(rod._mesh.position, scene.graspable.pose.matrix()[:3, 3])
    session.step(3000)
    tick = session.states["right"].tick
    assert tick["holding"] == 1
    assert np.linalg.norm(tick["p_WO"]) > 0.004, "it was carried away"
    live._frame()
    summary = session.close()
    replay = PairsReplayViewer(
        {n: Record.open(p) for n, p in pair_records(Path(summary.record)).items()}, "rod", port=0
    )
    try:
        replay._stop.set()
        replay._thread.join()
        replay.show(float(tick["t"]))
        (again,) = (one._rod for one in replay.drawings.values() if one._rod is not None)
        for one in (rod, again):
            np.testing.assert_allclose(one._mesh.position, tick["p_WO"], atol=1e-9)
            np.testing.assert_allclose(one._mesh.wxyz, tick["quat_WO"], atol=1e-9)
        low, high = rod._mesh.vertices.min(axis=0), rod._mesh.vertices.max(axis=0)
        np.testing.assert_allclose(high, [0.001, 0.001, 0.016], atol=2e-5)
        np.testing.assert_allclose(low, -high, atol=2e-5)
    finally:
        live.close()
        replay.close()


def test_a_hand_on_a_device_has_its_range_and_mapping_and_an_unknown_gap_is_no_number():
    session = PairsSession(Scene.parse(TWO))
    session.step(20)
    stages = {name: stage_of(rig, name) for name, rig in session.rigs.items()}
    mark = DeviceMark(
        "omega", stages["right"].leader.X_WA, np.full(3, 0.2), np.zeros(3), "indexed, 0.5 times the hand", 0.5
    )
    stages["right"] = replace(stages["right"], device=mark)
    viewer = PairsViewer(session.pairs, stages, "two", session, port=0)
    viewer._stop.set()
    viewer._thread.join()
    ticks = {name: state.tick for name, state in session.states.items()}
    ticks["right"]["p_LH"] = [0.05, 0.0, 0.0]
    ticks["left"]["instrument_gap"] = np.inf
    viewer._gauges.show(ticks, paused=False)
    text = viewer._gauges._figures.content
    assert ">50 mm to +x<" in text
    assert "mapping indexed, 0.5 times the hand" in text
    assert 'id="palpate-range-left"' not in text
    assert "inf" not in text
    viewer.close()
