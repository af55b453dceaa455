"""One soft body under two pairs: recorded once, drawn live and in a replay as it was."""

import numpy as np
import pytest
from soft_bodies import CUBE, soft_cube

from palpate.record import Record
from palpate.record.snapshots import QUANTUM, topic_of
from palpate.session import PairsSession

SCENE = (
    CUBE
    + """pairs:
  right:
    arms:
      leader: {base: {xyz: [0.345, 0.243, 0.219], rpy_deg: [0, 0, -20]}}
      follower: {base: {xyz: [0.060, -0.060, 0.155], rpy_deg: [0, 0, 155]}}
    operator: {palpate: {at: [0.015, 0, 0.1], length: 0.002, force: 0.02, approach: 0.3, press: 0.2}}
  left:
    arms:
      leader: {model: mtm_left, base: {xyz: [-0.345, 0.243, 0.219], rpy_deg: [0, 0, 20]}}
      follower: {base: {xyz: [-0.120, -0.060, 0.155], rpy_deg: [0, 0, 205]}}
    operator: {palpate: {at: [-0.015, 0, 0.1], length: 0.002, force: 0.25, approach: 0.3, press: 0.2}}
"""
)
TOPIC = topic_of("soft cube")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run in which the left tool makes the deeper dent, and the shape at its end."""
    folder = tmp_path_factory.mktemp("pairs")
    session = PairsSession(soft_cube(folder, SCENE), out=folder / "runs")
    session.step(600)
    for pair in session.pairs.values():
        pair._snapshots._due = -np.inf
        pair.take_snapshot()
    shape = session.pairs["right"].soft_vertices(0)
    session.step(1)
    runs, rigs = session.folder, session.rigs
    session.close()
    return runs, shape, rigs


def test_one_record_holds_the_shape_with_the_dents_of_both_tools(run):
    folder, shape, rigs = run
    right, left = (Record.open(folder / name / "record.mcap") for name in ("right", "left"))
    assert left.snapshots(TOPIC) is None, "the same shape is not stored twice"
    track, rest = right.snapshots(TOPIC), rigs["right"].snapshot.objects[0].surface.vertices
    assert np.abs(rest + track.at(track.t[-1]) - shape).max() <= 0.5 * QUANTUM + 1e-12
    down = (shape - rest)[:, 2]
    at_left = rest[:, 0] < -0.005
    assert down[at_left].min() < -4e-4, "the record of the right pair holds the dent of the left tool"


def test_viewer_and_replay_draw_the_shape(run):
    pytest.importorskip("viser", reason="the viewer is not installed (extra viewer)")
    from palpate.viewer import stage_of
    from palpate.viewer.pairs_replay import PairsReplayViewer
    from palpate.viewer.staging import stage_of_record

    folder, shape, rigs = run
    for rig in rigs.values():
        drawn = stage_of(rig).objects[0]
        assert drawn.soft
        assert drawn.vertices.shape == shape.shape
    records = {name: Record.open(folder / name / "record.mcap") for name in ("left", "right")}
    end = float(records["right"].snapshots(TOPIC).t[-1])
    assert 0 in stage_of_record(records["left"]).shapes, "the replay of one pair finds the shape beside it"
    viewer = PairsReplayViewer(records, "soft", port=0)
    try:
        viewer._stop.set()
        viewer._thread.join()
        viewer.show(end)
        assert np.abs(viewer._snapshots.soft_vertices(0) - shape).max() <= 0.5 * QUANTUM + 1e-12
        assert viewer._snapshots.soft.frames == 1
    finally:
        viewer.close()
