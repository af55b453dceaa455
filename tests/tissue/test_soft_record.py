"""The shape of a soft object in a record: small, within its quantum, equal in equal runs, and drawn by the replay."""

import numpy as np
import pytest
from soft_bodies import CUBE, soft_cube

import palpate
from palpate.record import Record
from palpate.record.snapshots import QUANTUM, RATE, Track, joints_message, joints_of, shape_message, shape_of, topic_of
from palpate.report.rates import rates_of
from palpate.report.run import Run

SCENE = (
    CUBE
    + """operator: {palpate: {object: soft cube, approach: 0.3, press: 0.5, force: 0.25}}
"""
)
DURATION = 1.0


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Two records of the same run, and the shapes of the first one as they were, by time."""
    folder = tmp_path_factory.mktemp("soft")
    scene = soft_cube(folder, SCENE)
    session = palpate.Session(scene, out=folder / "a")
    truth, take = {}, session._snapshots.take

    def note(t):
        truth[round(t, 6)] = session.soft_vertices(0)
        take(t)

    session._snapshots.take = note
    first = session.run(DURATION)
    second = palpate.Session(scene, out=folder / "b").run(DURATION)
    return session, truth, first, second


def test_lockstep_records_with_shapes_are_equal_byte_by_byte(run):
    _, _, first, second = run
    assert first.record_sha256 == second.record_sha256
    assert first.record_sha256 is not None


def test_recorded_shapes_are_those_of_the_run_within_the_quantum(run):
    session, truth, summary, _ = run
    track = Record.open(summary.record).snapshots(topic_of("soft cube"))
    rest = session.rig.snapshot.objects[0].surface.vertices
    assert len(track.t) == pytest.approx(DURATION * RATE, abs=2)
    errors = [np.linalg.norm(rest + track.at(t) - truth[round(t, 6)], axis=1).max() for t in track.t]
    assert max(errors) < 1e-4
    assert max(errors) <= 0.87 * QUANTUM
    assert np.abs(track.values).max() * QUANTUM > 4e-4, "the tool has pressed it"


def test_other_readers_decode_the_shape(run):
    pytest.importorskip("rosbags.rosbag2", reason="rosbags (test group) is not installed")
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore

    _, _, summary, _ = run
    record = Record.open(summary.record)
    track, store = record.snapshots(topic_of("soft cube")), get_typestore(Stores.ROS2_HUMBLE)
    with Reader(record.path.parent) as bag:
        chosen = [c for c in bag.connections if c.topic == "/scene/shape/soft_cube"]
        found = [store.deserialize_cdr(raw, c.msgtype) for c, _, raw in bag.messages(connections=chosen)]
    assert len(found) == len(track.t)
    dims = [(one.label, one.size, one.stride) for one in found[-1].layout.dim]
    n = track.values.shape[1]
    assert dims == [("vertex", n, 3 * n), ("axis", 3, 3)]
    np.testing.assert_array_equal(np.array(found[-1].data).reshape(-1, 3), track.values[-1])


def test_replay_draws_the_shape_and_the_report_names_its_rate(run):
    pytest.importorskip("viser", reason="the viewer is not installed (extra viewer)")
    from palpate.viewer import ReplayViewer, stage_of_record

    _, truth, summary, _ = run
    record = Record.open(summary.record)
    stage = stage_of_record(record)
    viewer = ReplayViewer(record.ticks, stage, port=0)
    try:
        viewer._stop.set()
        viewer._thread.join()
        t = float(stage.shapes[0].t[-2])
        viewer._show(int(np.searchsorted(record.ticks["t"], t)))
        drawn = viewer._drawing._organs[0]._parts[0].mesh.vertices
        assert np.abs(drawn - truth[round(t, 6)]).max() < QUANTUM
        viewer._snapshots.soft.colour.value = "strain"
        viewer._snapshots.soft._redraw()
        viewer._show(viewer._shown)
        assert viewer._drawing._organs[0]._coloured._parts[0].mesh is not None
    finally:
        viewer.close()
    (row,) = [row for row in rates_of(Run(record)) if "soft_cube" in row.name]
    assert row.measured_Hz == pytest.approx(RATE, rel=0.05)


def test_a_record_without_shapes_shows_objects_at_rest(run, tmp_path):
    pytest.importorskip("viser", reason="the viewer is not installed (extra viewer)")
    from palpate.viewer import stage_of_record

    session, _, _, _ = run
    scene = session.scene.model_copy(update={"record": session.scene.record.model_copy(update={"frames": False})})
    record = Record.open(palpate.Session(scene, out=tmp_path).run(0.3).record)
    assert record.snapshots(topic_of("soft cube")) is None
    assert stage_of_record(record).shapes == {}
    assert record.snapshot_topics == []


def test_messages_come_back():
    moved = np.random.default_rng(1).normal(scale=2e-3, size=(40, 3))
    assert np.abs(QUANTUM * shape_of(shape_message(moved)) - moved).max() <= 0.5 * QUANTUM + 1e-12
    assert np.abs(QUANTUM * shape_of(shape_message(np.full((1, 3), 9.0)))).max() < 0.66, "limited, not wrapped"
    for names in (("yaw", "pitch", "insertion", "roll"), ("a", "bb", "ccc"), ()):
        q = np.arange(len(names)) + 0.25
        np.testing.assert_array_equal(joints_of(joints_message(12.5, names, q)), q)


def test_a_track_is_linear_between_snapshots_and_constant_outside():
    track = Track(np.array([1.0, 2.0]), np.array([[0], [10]], dtype=np.int16), 0.1)
    assert [track.at(t)[0] for t in (0.0, 1.0, 1.25, 2.0, 9.0)] == pytest.approx([0.0, 0.0, 0.25, 1.0, 1.0])
