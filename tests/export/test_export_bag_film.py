"""Films of the cameras in a bag of a real dVRK: pictures of their time, stamps, intrinsics, and what is refused."""

import json

import numpy as np
import pytest
from crtk_bag import shown
from crtk_bag import write as write_bag
from lerobot_rules import faults, faults_of_open_h

from palpate.base.errors import RecordError
from palpate.export import export
from palpate.record.bags import images

av = pytest.importorskip("av", reason="av (extra learning) is not installed")
pq = pytest.importorskip("pyarrow.parquet", reason="pyarrow (extra learning) is not installed")


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return write_bag(tmp_path_factory.mktemp("real") / "a bag", posed=True, cameras=True)


def test_films_show_the_pictures_of_their_time(bag, tmp_path):
    """Both eyes, raw and JPEG, by the newest picture at each frame, with its stamp and the intrinsics of the bag."""
    export(bag, tmp_path / "out", video=True)
    assert faults(tmp_path / "out", images=True) == []
    without = [one for one in faults_of_open_h(tmp_path / "out") if "observation.meta.force_torque" not in one]
    assert without == []  # a bag has no force at the instrument
    info = json.loads((tmp_path / "out/meta/info.json").read_text())
    table = pq.read_table(tmp_path / "out/data/chunk-000/file-000.parquet")
    n = table.num_rows
    newest = 0.04 * np.floor((np.rint(1000 * np.arange(n) / 30) / 1000 + 1e-6) / 0.04)
    for side in ("left", "right"):
        name = f"observation.images.endoscope.{side}"
        assert info["features"][name]["shape"] == [482, 640, 3]
        with av.open(str(tmp_path / f"out/videos/{name}/chunk-000/file-000.mp4")) as film:
            frames = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
        assert len(frames) == n
        for k in (0, 7, 20, n - 1):
            expected = shown(newest[k])
            for x in (100, 500):
                np.testing.assert_allclose(frames[k][200, x], expected[200, x], atol=6)
        stamps = np.array(table[f"observation.meta.endoscope.{side}_stamp_ns"].to_pylist())
        np.testing.assert_allclose(1e-9 * stamps - 100.0, newest, atol=1e-6)
    camera = json.loads((tmp_path / "out/meta/calibration/camera_intrinsics.json").read_text())
    assert camera["endoscope.left"]["fx"] == 700.0
    assert camera["endoscope.right"]["cy"] == 241.0
    assert camera["endoscope.left"]["distortion"][0] == -0.1
    assert camera["endoscope.left"]["distortion_model"] == "opencv_radtan"
    assert camera["baseline_m"] == pytest.approx(0.005)


def test_topics_of_cameras_are_found_by_their_side(bag):
    found = images.cameras(bag)
    assert found == {"left": "/davinci/left/image_raw", "right": "/davinci/right/image_raw/compressed"}


def test_pictures_of_a_kind_that_is_not_read_are_named(bag, tmp_path, monkeypatch):
    with pytest.raises(RecordError, match="no pictures"):
        export(write_bag(tmp_path / "blind", posed=True), tmp_path / "out", video=True)
    monkeypatch.delitem(images._CHANNELS, "bgr8")
    with pytest.raises(RecordError, match="encoding 'bgr8'"):
        export(bag, tmp_path / "out", video=True)
    monkeypatch.undo()
    monkeypatch.setattr(images, "_CODECS", {})
    with pytest.raises(RecordError, match="packed pictures that begin with"):
        export(bag, tmp_path / "out", video=True)
    monkeypatch.undo()
    monkeypatch.setattr(images, "_MOST", 400)
    with pytest.raises(RecordError, match="640 x 482 pixels"):
        export(bag, tmp_path / "out", video=True)
    assert not (tmp_path / "out").exists()
