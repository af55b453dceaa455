"""`report` and `replay` of a rosbag2 of a CRTK session, from each storage plug-in, with the written numbers."""

import json

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="rosbags (test group) is not installed")
import crtk_bag
from rosbags.rosbag2 import StoragePlugin

from palpate.arm import Arm
from palpate.base.errors import RecordError
from palpate.cli import main
from palpate.record.bags import Bag
from palpate.record.bags.summary import summary_of
from palpate.viewer.bag import stage_and_ticks


@pytest.fixture(scope="module", params=[StoragePlugin.MCAP, StoragePlugin.SQLITE3], ids=["mcap", "sqlite3"])
def folder(request, tmp_path_factory):
    return crtk_bag.write(tmp_path_factory.mktemp("bag") / "session", request.param)


def test_tracks_equal_the_written_values(folder):
    bag = Bag.open(folder)
    arm = bag.arms["MTMR"]
    t = np.arange(crtk_bag.RATE * crtk_bag.SECONDS) / crtk_bag.RATE
    np.testing.assert_allclose(arm.q.t, t, atol=1e-6)
    np.testing.assert_array_equal(arm.q.values, [crtk_bag.motion(x) for x in t])
    np.testing.assert_array_equal(arm.wrench.values[:, :3], [crtk_bag.force(x) for x in t[t <= 1.6]])
    assert (arm.absolute.values[:, 0] == (t[t <= 1.6] >= 1.0)).all()
    assert bag.pair == ("MTMR", "PSM1")
    events = [(e.topic, e.text) for e in bag.events]
    assert events == [("/MTMR/operating_state", "ENABLED, homed"), ("/MTMR_PSM1/following", "True")]
    rates = {topic.name: topic.rate for topic in bag.topics}
    assert rates["/MTMR/measured_js"] == pytest.approx(crtk_bag.RATE)


def test_force_without_renewal_is_counted(folder):
    summary = summary_of(Bag.open(folder)).arms["MTMR"]
    assert summary.held_s == pytest.approx(1.995 - 1.6, abs=1e-6)
    assert summary.peak_force_N == pytest.approx(2.0)
    assert 0.0 < summary.peak_50ms_N <= summary.peak_force_N


def test_ticks_have_the_force_in_both_frames(folder):
    """The wrench is in the axes of the tip before 1 s, then of the base; the arm's kinematics gives the rotation."""
    stage, ticks = stage_and_ticks(Bag.open(folder), None)
    arm = Arm.mtm("right")
    for k in (20, 250, 310):
        t = float(ticks["t"][k])
        R_LH = arm.fk(crtk_bag.motion(t))[:3, :3]
        f = crtk_bag.force(t)
        np.testing.assert_allclose(ticks["F_H_L"][k], R_LH @ f if t < 1.0 else f, atol=1e-9)
        np.testing.assert_allclose(ticks["F_H_H"][k], f if t < 1.0 else R_LH.T @ f, atol=1e-9)
        np.testing.assert_allclose(ticks["p_LH"][k], arm.fk(crtk_bag.motion(t))[:3, 3], atol=1e-12)
    psm = Arm.psm()
    np.testing.assert_allclose(ticks["p_WT"][5], (stage.follower.X_WA @ psm.fk(psm.home))[:3, 3], atol=1e-12)


@pytest.mark.usefixtures("unarranged_figures")
def test_report_writes_a_page_and_json(folder, tmp_path, capsys):
    page, summary = tmp_path / "page.html", tmp_path / "summary.json"
    assert main(["report", str(folder), "--out", str(page), "--json", str(summary)]) == 0
    text = page.read_text()
    assert "MTMR" in text
    assert "an arm without a timeout keeps pushing" in text
    assert json.loads(summary.read_text())["leader"] == "MTMR"
    assert main(["report", str(next(folder.glob("session.*"))), "--out", str(page)]) == 0  # the file without its folder


def test_viewer_plays_a_bag(folder):
    pytest.importorskip("viser", reason="the viewer is not installed")
    from palpate.viewer.replay import ReplayViewer

    stage, ticks = stage_and_ticks(Bag.open(folder), None)
    viewer = ReplayViewer(ticks, stage, port=0)
    try:
        viewer.show_at(0.5)
    finally:
        viewer.close()


def test_incomplete_and_unreadable_bags_are_reported(tmp_path):
    bag = Bag.open(crtk_bag.write(tmp_path / "strange", follower=False, named="HAPLY"))
    with pytest.raises(RecordError, match=r"no model of the arm HAPLY[\s\S]*--scene"):
        stage_and_ticks(bag, None)
    assert bag.pair == ("HAPLY", None)
    (tmp_path / "metadata.yaml").write_text("nonsense: 1\n")
    with pytest.raises(RecordError, match=r"the bag cannot be read[\s\S]*metadata key is missing"):
        Bag.open(tmp_path)
    empty = tmp_path / "none.db3"
    empty.write_bytes(b"")
    with pytest.raises(RecordError, match="the bag cannot be read"):
        Bag.open(empty)
