"""Sessions: runs, records and their end."""

import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import palpate
from palpate.base.errors import OutputError, PalpateError, SceneError
from palpate.record import Record
from palpate.scene import Scene
from palpate.session.recorded import recorded_scene

SOFT = """\
objects: [{shape: organ, triangles: 3000, stiffness: 400}]
operator: {palpate: {force: 1.5, approach: 0.6, press: 0.5, slide: 1.0, leave: 0.5}}
"""


def scene(more: str = "") -> Scene:
    return Scene.parse(SOFT + more)


def test_run_approaches_presses_slides_and_retracts():
    session = palpate.Session(scene())
    phases = []
    summary = session.run(2.6, on_progress=lambda s: phases.append((s.phase, s.force)))
    assert list(dict.fromkeys(phase for phase, _ in phases)) == ["approach", "press", "slide", "leave"]
    assert phases[0][1] == 0.0
    assert phases[-1][1] == 0.0
    # The hand's path gives the palpation force; friction of the arm and motion need a tolerance.
    assert summary.peak_force_N == pytest.approx(1.5, rel=0.5)
    assert 0.5 < summary.contact_s < 2.6
    assert summary.faults == ()
    assert summary.record is None


def test_two_sessions_of_one_scene_have_equal_ticks(tmp_path):
    sums = [palpate.Session(scene(), out=tmp_path / str(i)).run(0.5).record_sha256 for i in range(2)]
    assert sums[0] is not None
    assert sums[0] == sums[1]


def test_steps_equal_a_run():
    one, many = palpate.Session(scene()), palpate.Session(scene())
    one.run(0.05)
    for _ in range(10):
        many.step(5)
    np.testing.assert_array_equal(one.state.tick["q"], many.state.tick["q"])
    assert many.state.t == pytest.approx(0.05, abs=0.002)


def test_steps_and_runs_share_a_record_until_it_is_closed(tmp_path):
    session = palpate.Session(scene(), out=tmp_path)
    session.step(100)
    first = session.run(0.2)
    assert first.ticks == 300
    second = session.run(0.1)
    assert second.ticks == 100
    assert first.record != second.record
    a, b = Record.open(first.record).ticks, Record.open(second.record).ticks
    assert b["t"][0] == pytest.approx(a["t"][-1] + 0.001)


def test_context_manager_closes_the_record(tmp_path):
    with palpate.Session(scene(), out=tmp_path) as session:
        session.step(10)
    assert Record.open(session.record).complete


def test_record_contains_the_resolved_scene(tmp_path):
    session = palpate.Session(scene(), out=tmp_path)
    summary = session.run(0.05)
    again = palpate.Session(Scene.parse(Record.open(summary.record).scene))
    np.testing.assert_allclose(again.rig.arms.X_WB, session.rig.arms.X_WB, atol=1e-12)
    np.testing.assert_allclose(again.rig.arms.X_WL, session.rig.arms.X_WL, atol=1e-12)
    np.testing.assert_allclose(again.rig.arms.q_leader0, session.rig.arms.q_leader0)
    np.testing.assert_allclose(again.rig.arms.q_follower0, session.rig.arms.q_follower0, atol=1e-5)


def test_other_seed_gives_another_tremor():
    trembling = Scene.parse(SOFT.replace("operator: {", "operator: {tremor: 0.0005, "))
    one, same, other = (palpate.Session(trembling, seed=seed).step(300).tick["p_hand_L"] for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert np.linalg.norm(one - other) > 1e-5


def test_real_time_session_keeps_every_tick(tmp_path):
    session = palpate.Session(scene(), out=tmp_path)
    begin = time.monotonic()
    summary = session.run(1.0, realtime=True)
    assert time.monotonic() - begin > 0.9
    assert summary.realtime
    assert summary.ticks >= 1000
    ticks = Record.open(summary.record).ticks
    assert len(ticks) == summary.ticks
    periods = np.rint(np.diff(ticks["t"]) / 0.001)
    assert periods.min() == 1  # a missed deadline is a gap, and is counted
    assert (periods - 1).sum() <= summary.missed_ticks


def test_start_and_stop_for_viewers():
    session = palpate.Session(scene())
    session.start()
    session.start()
    time.sleep(0.2)
    assert session.running
    assert session.latest()["t"] > 0.0
    session.stop()
    session.stop()
    assert not session.running
    assert session.close().ticks > 50


def test_session_has_one_driver_at_a_time():
    session = palpate.Session(scene())
    session.start()
    for drive in (session.run, session.step):
        with pytest.raises(PalpateError, match="runs in real time already"):
            drive()
    session.stop()
    session.step()


@pytest.mark.parametrize("realtime", [False, True])
def test_ctrl_c_ends_a_run_between_two_batches(tmp_path, realtime):
    session = palpate.Session(scene(), out=tmp_path)
    summary = session.run(60.0, realtime, on_progress=lambda _: signal.raise_signal(signal.SIGINT))
    assert summary.interrupted
    assert len(Record.open(summary.record).ticks) == summary.ticks < 5000
    assert not session.run(0.01).interrupted
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_session_runs_in_any_thread():
    session = palpate.Session(scene())
    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(session.run, 0.05).result().ticks == 50


def test_controls_reach_the_loop():
    session = palpate.Session(scene())
    session.step(700)
    controls = session.controls
    controls.clutch = True
    session.controls = controls
    before = session.state.tick["p_WT_goal"].copy()
    after = session.step(300).tick["p_WT_goal"]
    np.testing.assert_allclose(after, before, atol=1e-4)


def test_unwritable_folder_is_rejected_before_the_run(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="records cannot be written into this folder"):
        palpate.Session(scene(), out=tmp_path / "file" / "runs")


def test_package_names_are_lazy_and_unknown_names_reported():
    with pytest.raises(
        AttributeError,
        match=r"'Sesion'\. Available: Arm, DeviceModel, Fixture, Haptics, Mesh, OwnLoop, PairsSession, PalpateError",
    ):
        _ = palpate.Sesion


@pytest.mark.parametrize("more", ["preset: paper\n", "rates: {haptic: 4000}\n", "arms: {leader: {model: mtm_left}}\n"])
def test_other_set_ups_render_the_organ(more):
    summary = palpate.Session(scene(more)).run(1.6)
    assert summary.peak_force_N > 0.3
    assert summary.contact_s > 0.3
    assert summary.faults == ()


def test_waypoints_move_the_tool():
    start = palpate.Session(scene()).rig.path.positions_W[0]
    goal = start + np.array([0.01, 0.0, 0.02])
    path = f"[{{t: 0, xyz: {start.tolist()}}}, {{t: 1, xyz: {goal.tolist()}}}]"
    session = palpate.Session(Scene.parse(f"objects: [{{shape: organ, triangles: 3000}}]\noperator: {{path: {path}}}"))
    session.run(2.0)
    # Friction of the master leaves a deviation of the hand, which the mapping scales down.
    np.testing.assert_allclose(session.state.tick["p_WT"], goal, atol=0.002)


MESHED = """\
objects: [{mesh: soft.obj, unit: m, stiffness: 400}]
operator: {palpate: {approach: 0.3, press: 0.2, slide: 0.4, leave: 0.2}}
"""
RUN_ONE = "import palpate, sys; print(palpate.Session(palpate.Scene.load(sys.argv[1]), out='o').run(0.6).record_sha256)"


def meshed(folder):
    """A scene with its own mesh file in a new folder."""
    folder.mkdir()
    vertices, triangles = palpate.shapes.organ(3000)
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles.tolist()]
    (folder / "soft.obj").write_text("\n".join(lines))
    (folder / "soft.yaml").write_text(MESHED)
    return folder / "soft.yaml"


def test_two_processes_in_two_folders_give_the_same_bytes(tmp_path):
    """The record depends only on scene and seed, not on the process or the folders of scene, mesh and record."""
    path = meshed(tmp_path / "one")
    done = subprocess.run(
        [sys.executable, "-c", RUN_ONE, path], cwd=path.parent, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    here = palpate.Session(Scene.load(meshed(tmp_path / "another-place")), out=tmp_path / "out").run(0.6).record_sha256
    assert len(here) == 64
    assert done.stdout.strip() == here


def test_record_finds_its_meshes(tmp_path):
    path = meshed(tmp_path / "here")
    record = Path(palpate.Session(Scene.load(path), out=tmp_path / "o").run(0.3).record)
    assert str(tmp_path) not in Record.open(record).scene
    found = recorded_scene(Record.open(record)).path_of(0)
    assert found.samefile(path.with_name("soft.obj"))
    palpate.Session(Scene.load(record.with_name("scene.yaml"))).step()  # the recorded scene runs unchanged
    moved = record.parent / "soft.obj"  # the run's folder was moved together with the mesh
    path.with_name("soft.obj").rename(moved)
    assert recorded_scene(Record.open(record)).path_of(0).samefile(moved)


@pytest.mark.parametrize("realtime", [False, True])
def test_exception_of_a_callback_leaves_a_complete_record_and_zero_force(tmp_path, realtime):
    session = palpate.Session(scene(), out=tmp_path)

    def fail(_):
        raise RuntimeError("a listener failed")

    with pytest.raises(RuntimeError, match="a listener failed"):
        session.run(60.0, realtime, on_progress=fail)
    assert not session.running
    assert Record.open(session.record).complete
    if realtime:
        assert not session.latest()["F_H_L"].any()


AT_EXIT = """\
import atexit, palpate, sys, time
ends = lambda: print(session.simulation.running, session.latest()["F_H_L"].any(), session.latest()["tau_gravity"].any())
atexit.register(ends)  # registered before the session: called after it is through
session = palpate.Session(palpate.Scene.load(sys.argv[1]))
session.start()
time.sleep(1.0)
"""


def test_running_session_stops_at_the_end_of_python(tmp_path):
    """Without a call of stop() the force is zero before the process ends, with gravity compensation."""
    path = meshed(tmp_path / "left")
    done = subprocess.run([sys.executable, "-c", AT_EXIT, path], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["False", "False", "True"]


def test_a_record_ends_at_its_limit_complete_and_the_next_begins_by_request(tmp_path):
    """What an open viewer records has a limit."""
    session = palpate.Session(scene(), out=tmp_path)
    session.step(1)
    first = session.record
    assert first is not None
    session.limit_record(1e6)
    steps = 0
    while session.recording and steps < 100:
        session.step(100)
        steps += 1
    assert not session.recording
    assert 1e6 < first.stat().st_size < 2e6
    assert len(Record.open(first).ticks) == 1 + 100 * steps
    session.step(100)
    assert session.record is None
    session.set_recording(True)
    session.step(1)
    assert session.record not in (None, first)


def test_a_session_takes_a_scene_its_values_its_file_or_its_name(tmp_path):
    values = {"objects": [{"shape": "organ", "triangles": 3000, "stiffness": 400}]}
    (tmp_path / "mine.yaml").write_text(SOFT)
    ticks = [palpate.Session(given).step(20).tick for given in (Scene.model_validate(values), values)]
    np.testing.assert_array_equal(ticks[0]["q"], ticks[1]["q"])
    assert palpate.Session(tmp_path / "mine.yaml").scene.objects[0].shape == "organ"
    assert palpate.Session("palpation").scene.title == "palpation"
    with pytest.raises(SceneError, match=r"(?s)3 is no scene.*palpate\.Scene\.load"):
        palpate.Session(3)
    with pytest.raises(SceneError, match="stiffness"):
        palpate.Session({"objects": [{"shape": "organ", "stiffness": -1}]})
