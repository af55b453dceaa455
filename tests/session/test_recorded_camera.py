"""The endoscope arm in a record: its joints as they were, and the surgeon's view of the replay."""

from pathlib import Path

import numpy as np
import pytest
from two_pairs import TWO

from palpate.record import Record
from palpate.record.snapshots import CAMERA
from palpate.scene import Scene
from palpate.session import PairsSession
from palpate.session.rates import LiveRates


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run in which the camera moves halfway, and the joints that it had then."""
    session = PairsSession(Scene.parse("ecm: {}\n" + TWO), out=tmp_path_factory.mktemp("camera"))
    before = session.camera.q
    session.step(200)
    session.camera.move_to(before + np.array([0.1, -0.05, 0.01, 0.2]))
    session.step(200)
    rates = LiveRates(session.pairs).rows()
    folder = session.folder
    session.close()
    return before, session.camera.q, Path(folder), rates


def test_joints_of_the_camera_are_recorded_bit_by_bit(run):
    before, after, folder, _ = run
    for name in ("right", "left"):
        track = Record.open(folder / name / "record.mcap").snapshots(CAMERA)
        np.testing.assert_array_equal(track.values[0], before)
        np.testing.assert_array_equal(track.values[-1], after)
        assert 0.19 < track.t[(track.values == after).all(axis=1)][0] < 0.25


def test_rates_name_the_endoscope_once(run):
    _, _, _, rates = run
    assert [row.name for row in rates if row.name == "endoscope"] == ["endoscope"]


def test_replay_shows_the_view_of_the_surgeon_as_it_was(run):
    pytest.importorskip("viser", reason="the viewer is not installed (extra viewer)")
    from palpate.viewer.pairs_replay import PairsReplayViewer

    before, after, folder, _ = run
    records = {name: Record.open(folder / name / "record.mcap") for name in ("right", "left")}
    viewer = PairsReplayViewer(records, "camera", port=0)
    try:
        viewer._stop.set()
        viewer._thread.join()
        for t, q in ((0.1, before), (0.39, after)):
            viewer.show(t)
            np.testing.assert_allclose(viewer.surgeon._joints(), q)
            assert len(viewer.surgeon._ticks()) == 2
    finally:
        viewer.close()
