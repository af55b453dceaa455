"""A record holds the poses of rigid bodies: what fell, falls again in replay, film and data set."""

from __future__ import annotations

import time

import numpy as np
import pytest

pytest.importorskip("mujoco")

from palpate.base.arrays.so3 import pose
from palpate.export.demonstration import demonstrations
from palpate.export.episode import episode_of
from palpate.export.formats.lerobot.columns import NAMINGS
from palpate.record.reader import Record
from palpate.scene import Scene, held
from palpate.session import PairsSession, Session
from palpate.session.recorded import body_track
from palpate.viewer.replay import ReplayViewer
from palpate.viewer.staging import stage_of_record

G = 9.81
DROP = 0.12  # height [m]
SCENE = {
    "objects": [{"name": "table", "plane": {"size": 0.2}, "pose": {"xyz": [0, 0, -0.02]}}],
    "bodies": [
        {"name": "floor", "fixed": True, "parts": [{"box": [0.2, 0.2, 0.01], "pose": {"xyz": [0, 0, -0.005]}}]},
        {"name": "peg 1", "mass": 0.004, "parts": [{"box": [0.01, 0.01, 0.01]}], "color": [200, 60, 50],
         "pose": {"xyz": [0.05, 0.02, DROP], "rpy_deg": [0, 0, 30]}},
        {"name": "door", "mass": 0.01, "parts": [{"box": [0.02, 0.002, 0.02], "pose": {"xyz": [0.01, 0, 0]}}],
         "joint": {"to": "floor", "kind": "hinge", "axis": [0, 1, 0]}, "pose": {"xyz": [-0.06, 0.03, 0.05]}},
        {"name": "needle", "parts": [{"capsule": {"radius": 0.001, "length": 0.02}}],
         "pose": {"xyz": [0.05, -0.05, 0.05]}, "thread": {"links": 3, "length": 0.015}},
    ],
    "arms": {"leader": {"base": {"xyz": [0.345, 0.243, 0.219], "rpy_deg": [0, 0, -20]}},
             "follower": {"model": "psm_prograsp", "base": {"xyz": [0, 0, 0.19]}}},
    "operator": {"path": [{"t": 0, "xyz": [0, 0, 0.06]}]},
}  # fmt: skip


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A record of 0.4 s, in which the peg falls, and the places of all bodies at its end."""
    session = Session(Scene.model_validate(SCENE), out=tmp_path_factory.mktemp("run"), seed=1)
    starts = {solid.name: solid.X_WO for solid in held.solids(session.scene) if solid.moves}
    for name, place in session.world.drawn().items():
        assert np.allclose(pose(place[:3], place[3:]), starts[name], atol=1e-9), name
    session.run(0.4)
    return Record.open(session.record), session.world.drawn()


def test_the_record_holds_the_fall_of_a_body(run):
    record, end = run
    track = record.bodies
    assert set(track.names) == set(end) == {"peg 1", "door", *(f"needle/thread{k}" for k in range(3)), "needle"}
    assert track.track.rate == pytest.approx(25.0)
    for t in track.track.t[
        :4
    ].tolist():  # Galilei; the engine is half a step ahead, and the pose is up to two steps old
        assert track.at(t)["peg 1"][2] == pytest.approx(DROP - 0.5 * G * t**2, abs=G * t * 0.002 + 1e-9)
    assert track.at(0.4)["peg 1"][2] == pytest.approx(0.005, abs=1e-3)
    turned = track.at(0.4)["door"][3:]
    assert 2.0 * np.degrees(np.arccos(abs(turned[0]))) > 20.0, "the door swung on its hinge"
    for name, place in end.items():
        assert np.allclose(track.at(10.0)[name][:3], place[:3], atol=2e-3), name


def test_markers_and_frames_show_the_bodies_in_other_viewers(run):
    from palpate.record.mcap_scan import scan

    index = scan(run[0].path)
    topics = {channel.topic: number for number, channel in index.channels.items()}
    (markers,) = index.messages({topics["/scene/bodies"]})
    for frame in (b"palpate_body_floor", b"palpate_body_peg 1", b"palpate_body_needle/thread2"):
        assert frame in markers.data
    (static,) = index.messages({topics["/tf_static"]})
    assert b"palpate_body_floor" in static.data
    assert b"palpate_body_door" not in static.data


def test_a_replay_shows_where_the_bodies_were(run):
    record, _ = run
    viewer = ReplayViewer(record, stage_of_record(record), port=0)
    try:
        for t in (0.1, 0.38, 0.02):
            viewer.show_at(t)
            limit, frame = time.monotonic() + 20.0, viewer._snapshots._bodies._moving["peg 1"]
            while not np.allclose(frame.position, record.bodies.at(t)["peg 1"][:3], atol=1e-3):
                assert time.monotonic() < limit, f"the peg is drawn at {frame.position} at {t} s"
                time.sleep(0.02)
    finally:
        viewer.close()


@pytest.mark.parametrize("naming", NAMINGS)
def test_a_data_set_holds_the_poses_of_the_bodies(run, naming):
    record, _ = run
    (found,) = demonstrations([record.path])
    episode = episode_of(found, 30)
    column = NAMINGS[naming](episode)["observation.environment_state"]
    place = dict(zip(column.names, column.values[-1], strict=True))
    expected = record.bodies.at(float(episode.arms[0].frames.t[-1]))["peg 1"]
    assert [place[f"peg 1.{k}"] for k in ("x", "y", "z", "qw")] == pytest.approx(expected[:4], abs=1e-6)


def test_a_film_shows_the_fall(run):
    pytest.importorskip("moderngl")
    from palpate.base.errors import PalpateError
    from palpate.export.video.film import Film

    (found,) = demonstrations([run[0].path])
    try:
        film = Film(found, (60, 80))
    except PalpateError as error:
        pytest.skip(str(error))
    try:
        assert {name: len(parts) for name, parts in film.solids.bodies.items()}["peg 1"] == 1
        *_, last = film.pictures(episode_of(found, 30))
        assert film.solids.bodies["peg 1"][0].X_WB[2, 3] < 0.01
        assert last["left"].shape == (60, 80, 3)
    finally:
        film.close()


def test_equal_lockstep_runs_give_equal_bytes(tmp_path):
    one, two = (Session(Scene.model_validate(SCENE), out=tmp_path / name, seed=1) for name in "ab")
    assert one.run(0.1).record_sha256 == two.run(0.1).record_sha256


def test_of_two_pairs_one_record_holds_the_bodies(tmp_path):
    pairs = {
        name: {"arms": {"leader": {"model": f"mtm_{name}",
                                   "base": {"xyz": [side * 0.345, 0.243, 0.219], "rpy_deg": [0, 0, -20 * side]}},
                        "follower": {"model": "psm_prograsp", "base": {"xyz": [side * 0.06, 0, 0.19]}}},
               "operator": {"path": [{"t": 0, "xyz": [side * 0.06, 0, 0.06]}]}}
        for name, side in (("left", -1), ("right", 1))
    }  # fmt: skip
    scene = {key: value for key, value in SCENE.items() if key not in ("arms", "operator")} | {"pairs": pairs}
    session = PairsSession(Scene.model_validate(scene), out=tmp_path, seed=1)
    session.run(0.1)
    left, right = (Record.open(session.pairs[name].record) for name in ("left", "right"))
    assert right.bodies is None
    assert body_track(right).at(0.1)["peg 1"] == pytest.approx(left.bodies.at(0.1)["peg 1"])


def test_meshes_of_bodies_are_found_again_from_the_record(tmp_path):
    import trimesh

    trimesh.creation.box([0.01, 0.01, 0.01]).export(tmp_path / "block.stl")
    bodies = [
        {"name": "block", "mass": 0.01, "parts": [{"mesh": "block.stl", "unit": "m"}], "pose": {"xyz": [0.05, 0, 0.05]}}
    ]
    (tmp_path / "my.yaml").write_text(Scene.model_validate(SCENE | {"bodies": bodies}).to_yaml())
    session = Session(tmp_path / "my.yaml", out=tmp_path / "runs", seed=1)
    session.run(0.05)
    (solid,) = stage_of_record(Record.open(session.record)).solids
    assert len(solid.shapes[0].vertices) >= 8


def test_the_force_score_of_a_record_sees_what_the_tool_presses(tmp_path):
    from palpate import metrics

    press = {"path": [{"t": 0, "xyz": [0, 0, 0.06]}, {"t": 0.5, "xyz": [0, 0, 0.01]}, {"t": 0.8, "xyz": [0, 0, 0.01]}]}
    session = Session(Scene.model_validate(SCENE | {"operator": press}), out=tmp_path, seed=1)
    found = metrics.summary(session.run(0.8).record)
    assert found["contact_s"] > 0.1
    assert 0.3 < found["peak_force_N"] < 10.0
    assert np.isfinite(found["force_sensitivity"])
